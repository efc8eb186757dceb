# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The speed and acceleration that a motion may have."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.log import Log
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.request import CartesianRequest, MotionPlanRequest

SpeedLimit = Callable[[Vector, Vector], Vector]
"""Positions (k, n) and slopes (k, n) of a path -> its largest path speed (k,)."""

DEFAULT_VELOCITY = 1.0
"""Speed limit of a joint that has none [rad/s or m/s]."""

DEFAULT_ACCELERATION = 1.0
"""Acceleration limit of a joint that has none [rad/s^2 or m/s^2]."""

LEAST_SCALING = 1e-9
"""Smaller scaling factors count as this value: every motion lasts for years with both."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionLimits:
    """
    Limits of a group's joints, all finite but jerk.

    :param velocity: (n,) [rad/s or m/s].
    :param acceleration: (n,) [rad/s^2 or m/s^2].
    :param jerk: (n,) [rad/s^3 or m/s^3], infinite where there is none.
    """

    velocity: Vector
    acceleration: Vector
    jerk: Vector

    def scaled(self, velocity: float, acceleration: float) -> MotionLimits:
        """
        Return slower limits.

        :param velocity: factor in (0, 1].
        :param acceleration: factor in (0, 1].
        """
        return MotionLimits(
            self.velocity * velocity, self.acceleration * acceleration, self.jerk)


def scaling_factor(value: float, name: str, log: Log) -> float:
    """
    Return a scaling factor that can be used: values outside (0, 1] count as 1.

    :param value: what the client gave.
    :param name: how the client calls it.
    """
    if 0.0 < value <= 1.0:
        return max(value, LEAST_SCALING)
    log.warning(f'{name} is {value:g}, which is not in (0, 1]: using 1.0')
    return 1.0


class LimitTable:
    """
    Speed and acceleration limits of every joint, with defaults where the files give none.

    :param robot: the robot.
    :param log: hears once a joint of a limit that had to be assumed.
    """

    def __init__(self, robot: RobotModel, log: Log) -> None:
        self._robot, self._log = robot, log
        self._reported: set[str] = set()

    def limits(self, joint_names: Iterable[str]) -> MotionLimits:
        """Return the limits of these joints, in this order."""
        names = tuple(joint_names)
        found = [self._robot.joints[name].limits for name in names]
        velocity = [self._usable(each.velocity, DEFAULT_VELOCITY) for each in found]
        acceleration = [self._usable(each.acceleration, DEFAULT_ACCELERATION) for each in found]
        self._tell(names, 'velocity', [each.velocity for each in found], DEFAULT_VELOCITY)
        self._tell(
            names, 'acceleration', [each.acceleration for each in found], DEFAULT_ACCELERATION)
        jerk = [each.jerk if each.jerk > 0.0 else math.inf for each in found]
        return MotionLimits(np.array(velocity), np.array(acceleration), np.array(jerk))

    def requested(
        self, joint_names: Iterable[str], request: MotionPlanRequest | CartesianRequest
    ) -> MotionLimits:
        """Return the limits of these joints times a request's scaling factors."""
        return self.limits(joint_names).scaled(*(
            scaling_factor(getattr(request, name), name, self._log)
            for name in ('max_velocity_scaling_factor', 'max_acceleration_scaling_factor')))

    @staticmethod
    def _usable(value: float, default: float) -> float:
        return value if math.isfinite(value) and value > 0.0 else default

    def _tell(
        self, names: Sequence[str], kind: str, values: Sequence[float], default: float
    ) -> None:
        lacking = [
            name
            for name, value in zip(names, values, strict=True)
            if self._usable(value, -1.0) < 0.0 and f'{kind} {name}' not in self._reported
        ]
        if lacking:
            self._reported.update(f'{kind} {name}' for name in lacking)
            what = 'joint has' if len(lacking) == 1 else 'joints have'
            self._log.warning(
                f'{what} no {kind} limit: {", ".join(lacking)}; assuming {default:g}. Give '
                f'has_{kind}_limits: true and max_{kind} of each in joint_limits.yaml')


def link_speed_limit(
    model: KinematicModel, validity: StateValidity, request: MotionPlanRequest | CartesianRequest
) -> SpeedLimit | None:
    """
    Return the largest path speed at which a link keeps a request's ``max_cartesian_speed``.

    :returns: None where no speed above 0 is asked for.
    :raises PlanningError: INVALID_LINK_NAME for an unknown link.
    """
    group, speed = validity.group, request.max_cartesian_speed
    if not speed > 0.0:
        return None
    name = (request.cartesian_speed_limited_link
            or model.robot.semantic.groups[group].links[-1])
    model.frame_index(name)

    def limit(positions: Vector, slopes: Vector) -> Vector:
        rates = [
            float(np.linalg.norm(model.jacobian(validity.full(q), name, group)[:3] @ slope))
            for q, slope in zip(positions, slopes, strict=True)
        ]
        fastest: Vector = speed / np.maximum(np.array(rates), 1e-9)
        return fastest

    return limit
