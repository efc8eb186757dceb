# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arms of Franka, as ``franka_ros2`` of Jazzy presents them."""
