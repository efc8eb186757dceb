# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arms of Universal Robots, as ``ur_robot_driver`` of Jazzy presents them."""
