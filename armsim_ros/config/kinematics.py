# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint limits of plans and inverse kinematics (``joint_limits.yaml``, ``kinematics.yaml``)."""

from __future__ import annotations

from pydantic import model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, Settings

#: Keys of a joint's block that others read -> why they have no effect here.
UNUSED_LIMIT_KEYS = {
    'has_effort_limits': "effort is bounded by the URDF's <limit effort>",
    'max_effort': "effort is bounded by the URDF's <limit effort>",
    'has_deceleration_limits': 'deceleration has the bound of acceleration',
    'max_deceleration': 'deceleration has the bound of acceleration',
    'has_soft_limits': '',
    'k_position': '',
    'k_velocity': '',
    'soft_lower_limit': '',
    'soft_upper_limit': '',
    'angle_wraparound': 'a continuous joint of the URDF turns without bounds',
}


class JointLimitOverrides(Settings):
    """
    Limits of a joint that replace those of the URDF in plans.

    Velocity, acceleration and jerk count only where their ``has_...`` is true. A bound of the
    position counts wherever it is given, each by itself, regardless of ``has_position_limits``.
    """

    has_position_limits: bool | None = parameter(None, 'not read, as in MoveIt')
    min_position: float | None = parameter(None, 'lower bound [rad or m]')
    max_position: float | None = parameter(None, 'upper bound [rad or m]')
    has_velocity_limits: bool | None = parameter(None, 'whether max_velocity counts')
    max_velocity: float | None = parameter(None, 'largest velocity [rad/s or m/s]', ge=0.0)
    has_acceleration_limits: bool | None = parameter(None, 'whether max_acceleration counts')
    max_acceleration: float | None = parameter(
        None, 'largest acceleration [rad/s^2 or m/s^2]', ge=0.0)
    has_jerk_limits: bool | None = parameter(None, 'whether max_jerk counts')
    max_jerk: float | None = parameter(None, 'largest jerk [rad/s^3 or m/s^3]', ge=0.0)

    @model_validator(mode='after')
    def _complete(self) -> Self:
        for kind in ('velocity', 'acceleration', 'jerk'):
            value = getattr(self, f'max_{kind}')
            if getattr(self, f'has_{kind}_limits') and value == 0.0:
                raise ValueError(
                    f"'max_{kind}' is 0 though has_{kind}_limits is true; give a value above 0, "
                    f'or set has_{kind}_limits to false')
        low, high = self.min_position, self.max_position
        if low is not None and high is not None and low > high:
            raise ValueError(f"'min_position' {low:g} is above max_position {high:g}")
        return self

    @property
    def velocity(self) -> float | None:
        """Bound that replaces the URDF's [rad/s or m/s]; None keeps it."""
        return self._bound('velocity')

    @property
    def acceleration(self) -> float | None:
        """Bound of the acceleration [rad/s^2 or m/s^2], None where there is none."""
        return self._bound('acceleration')

    @property
    def jerk(self) -> float | None:
        """Bound of the jerk [rad/s^3 or m/s^3], None where there is none."""
        return self._bound('jerk')

    def _bound(self, kind: str) -> float | None:
        value: float | None = getattr(self, f'max_{kind}')
        return value if getattr(self, f'has_{kind}_limits') else None


class JointLimitsSettings(Settings):
    """A file of joint limits."""

    default_velocity_scaling_factor: float = parameter(
        0.1, 'velocity scaling that clients use where their user gives none', gt=0.0, le=1.0)
    default_acceleration_scaling_factor: float = parameter(
        0.1, 'acceleration scaling that clients use where their user gives none', gt=0.0, le=1.0)
    joint_limits: dict[str, JointLimitOverrides] = parameter({}, 'joint -> limits')


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
