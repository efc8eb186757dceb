# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Inverse kinematics of each planning group (``kinematics.yaml``)."""

from __future__ import annotations

from armsim_ros.config.base import parameter, Settings

_EXACT = 'pick_ik: a solution here is exact, or there is none'
_NEAREST = 'pick_ik: a solution here is the solution nearest to the seed'
_SEARCH = "pick_ik: the search here has no such steps; 'kinematics_solver_timeout' bounds it"
_PICK_IK = {
    **dict.fromkeys((
        'position_threshold', 'orientation_threshold', 'cost_threshold', 'approximate_solution_'
        'position_threshold', 'approximate_solution_orientation_threshold',
        'approximate_solution_joint_threshold', 'approximate_solution_cost_threshold'), _EXACT),
    **dict.fromkeys((
        'center_joints_weight', 'avoid_joint_limits_weight', 'minimal_displacement_weight',
        'stop_optimization_on_valid_solution'), _NEAREST),
    **dict.fromkeys((
        'mode', 'gd_step_size', 'gd_max_iters', 'gd_min_cost_delta', 'memetic_num_threads',
        'memetic_stop_on_first_solution', 'memetic_population_size', 'memetic_elite_size',
        'memetic_wipeout_fitness_tol', 'memetic_max_generations', 'memetic_gd_max_iters',
        'memetic_gd_max_time'), _SEARCH),
    'position_scale': 'pick_ik: the position always counts here',
}

#: Keys of solvers that the built-in solver replaces -> why they have no effect.
UNUSED_KINEMATICS_KEYS = {
    'kinematics_solver_ik_links': 'links of an old solver',
    'kinematics_solver_srv_name': 'no solver service is called',
    'solve_type': 'a setting of TRAC-IK',
    'link_prefix': 'a setting of an analytic solver',
    **_PICK_IK,
}


class JointWeight(Settings):
    """Weight of a joint in the solver of KDL."""

    weight: float = parameter(1.0, 'relative weight of the joint', gt=0.0)


class KinematicsSettings(Settings):
    """Solver of a planning group."""

    kinematics_solver: str = parameter(
        '', 'name of the solver plugin; the built-in solver does the work of each, without a name '
        'the group has none')
    kinematics_solver_search_resolution: float = parameter(
        0.1, 'step of the search of a redundant joint [rad or m]', ge=0.0)
    kinematics_solver_timeout: float = parameter(
        0.05, 'time per solution where a request gives none [s]', gt=0.0)
    kinematics_solver_attempts: int = parameter(3, 'ROS 1: has no effect', ge=0)
    max_solver_iterations: int = parameter(500, 'largest number of steps from a start', ge=0)
    epsilon: float = parameter(1e-5, 'largest error of a solution [m and rad]', gt=0.0)
    orientation_vs_position: float = parameter(
        1.0, 'weight of orientation against position; 0 is position only', ge=0.0)
    position_only_ik: bool = parameter(False, 'leave the orientation free')
    rotation_scale: float = parameter(
        0.5, 'of pick_ik: weight of the orientation; 0 leaves it free', ge=0.0)
    joints: tuple[str, ...] = parameter((), 'joints with a weight, a block of its name each')
    weights: dict[str, JointWeight] = parameter({}, 'joint -> its block')

    @property
    def leaves_orientation_free(self) -> bool:
        """Whether a solution need not have the orientation of its target."""
        is_pick_ik = self.kinematics_solver.startswith('pick_ik/')
        return (self.position_only_ik or self.orientation_vs_position == 0.0
                or (is_pick_ik and self.rotation_scale == 0.0))
