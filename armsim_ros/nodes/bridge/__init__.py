# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients without ROS: rosbridge v2, rosapi and Foxglove over websockets."""
