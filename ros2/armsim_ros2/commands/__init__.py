# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One module per command of ros2; none imports rclpy before its verb runs."""
