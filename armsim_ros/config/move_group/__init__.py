# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What move_group reads: planners, kinematics, controllers, execution."""
