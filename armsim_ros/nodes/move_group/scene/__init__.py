# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is there, and where the robot is in it."""
