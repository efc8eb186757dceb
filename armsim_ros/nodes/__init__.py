# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs and their ROS endpoints; together with testing, all that may import rclpy."""
