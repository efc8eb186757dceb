# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that draws what cameras see, from what the simulation sends it."""
