# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Writes a robot's files in the layout of ROS 2."""
