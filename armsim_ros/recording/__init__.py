# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The last seconds of a simulation, and the file that keeps them."""
