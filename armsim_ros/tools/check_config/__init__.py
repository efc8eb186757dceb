# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reports the errors in a robot's files, and how each key is used."""
