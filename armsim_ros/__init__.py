# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A physically simulated robot arm behind the interfaces of ros2_control and MoveIt."""
