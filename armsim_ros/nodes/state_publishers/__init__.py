# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""robot_state_publisher and joint_state_publisher."""
