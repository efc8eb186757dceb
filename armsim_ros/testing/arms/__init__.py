# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm that a test moves: in the test's own process, or behind ROS interfaces."""
