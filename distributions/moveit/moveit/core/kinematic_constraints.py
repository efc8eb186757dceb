# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.kinematic_constraints``."""

from armsim_ros.moveit_py.kinematic_constraints import (
    construct_constraints_from_node,
    construct_joint_constraint,
    construct_link_constraint,
)

__all__ = [
    'construct_constraints_from_node',
    'construct_joint_constraint',
    'construct_link_constraint',
]
