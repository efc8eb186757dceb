# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Limits of plans, laid over those of the URDF (``joint_limits.yaml``)."""

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
