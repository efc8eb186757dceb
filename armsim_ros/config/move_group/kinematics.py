# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Inverse kinematics of each planning group (``kinematics.yaml``)."""

from __future__ import annotations

from armsim_ros.config.base import parameter, Settings

#: Keys of solvers that the built-in one stands in for -> why they have no effect.
UNUSED_KINEMATICS_KEYS = {
    'kinematics_solver_ik_links': 'links of an old solver',
    'kinematics_solver_srv_name': 'no solver service is called',
    'solve_type': 'a setting of TRAC-IK',
    'mode': 'a setting of pick_ik',
    'gd_step_size': 'a setting of pick_ik',
    'position_scale': 'a setting of pick_ik',
    'rotation_scale': 'a setting of pick_ik',
    'position_threshold': 'a setting of pick_ik',
    'orientation_threshold': 'a setting of pick_ik',
    'cost_threshold': 'a setting of pick_ik',
    'minimal_displacement_weight': 'a setting of pick_ik',
    'link_prefix': 'a setting of an analytic solver',
}


class JointWeight(Settings):
    """Weight of one joint in the solver of KDL."""

    weight: float = parameter(1.0, 'relative weight of the joint', gt=0.0)


class KinematicsSettings(Settings):
    """Solver of one planning group."""

    kinematics_solver: str = parameter(
        '', 'name of the solver plugin; the built-in solver does the work of each, without a name '
        'the group has none')
    kinematics_solver_search_resolution: float = parameter(
        0.1, 'step of the search of a redundant joint [rad or m]', ge=0.0)
    kinematics_solver_timeout: float = parameter(
        0.05, 'time for one solution where a request gives none [s]', gt=0.0)
    kinematics_solver_attempts: int = parameter(3, 'ROS 1: has no effect', ge=0)
    max_solver_iterations: int = parameter(500, 'largest number of steps from one start', ge=0)
    epsilon: float = parameter(1e-5, 'largest error of a solution [m and rad]', gt=0.0)
    orientation_vs_position: float = parameter(
        1.0, 'weight of orientation against position; 0 is position only', ge=0.0)
    position_only_ik: bool = parameter(False, 'leave the orientation free')
    joints: tuple[str, ...] = parameter((), 'joints with a weight, a block of its name each')
    weights: dict[str, JointWeight] = parameter({}, 'joint -> its block')
