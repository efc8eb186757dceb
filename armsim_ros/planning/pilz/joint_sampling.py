# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Profiles along a path, and joint trajectories on it, checked against the limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.timing.limits import MotionLimits
from armsim_ros.quintic_motion import QuinticMotion

SAMPLING_TIME = 0.1
"""Time [s] between two points of a trajectory; the last interval may be shorter."""

_SHORTEST_INTERVAL = 1e-5


class TrapezoidalProfile:
    """
    The fastest motion over a distance with limited speed and acceleration, from rest to rest.

    :param distance: [m or rad], >= 0.
    :param speed: largest speed [m/s or rad/s].
    :param acceleration: largest acceleration and deceleration [m/s^2 or rad/s^2].
    """

    def __init__(self, distance: float, speed: float, acceleration: float) -> None:
        self._distance, self._acceleration = distance, acceleration
        self._peak = min(speed, math.sqrt(distance * acceleration))
        self._ramp = self._peak / acceleration
        cruise = (distance - self._peak * self._ramp) / self._peak if self._peak else 0.0
        #: Time to the end [s].
        self.duration = 2.0 * self._ramp + max(cruise, 0.0)

    def states(self, times: Vector) -> tuple[Vector, Vector, Vector]:
        """
        Return the covered distance, speed and acceleration at times (k,) [s].

        At both ends speed and acceleration are 0.
        """
        to_end = self.duration - times
        ramp, rate = self._ramp, self._acceleration
        rising, falling = times <= ramp, to_end < ramp
        place = np.where(
            rising, 0.5 * rate * times**2,
            np.where(falling, self._distance - 0.5 * rate * to_end**2,
                     self._peak * (times - 0.5 * ramp)))
        speed = np.where(rising, rate * times, np.where(falling, rate * to_end, self._peak))
        acceleration = np.where(rising, rate, np.where(falling, -rate, 0.0))
        acceleration[(times <= 0.0) | (to_end <= 0.0)] = 0.0
        return np.clip(place, 0.0, self._distance), np.maximum(speed, 0.0), acceleration


def sample_times(duration: float) -> Iterator[float]:
    """Yield the multiples of :data:`SAMPLING_TIME` before a duration [s], and the duration."""
    for k in range(math.ceil((duration - _SHORTEST_INTERVAL) / SAMPLING_TIME)):
        yield SAMPLING_TIME * k
    yield duration


def point_to_point(start: Vector, end: Vector, limits: MotionLimits) -> QuinticMotion:
    """
    Return a motion in which all joints start, cruise and stop together.

    Every joint has the smallest velocity and the smallest acceleration limit of all.

    :param start: (m,) at rest.
    :param end: (m,) at rest, not equal to the start.
    """
    way = end - start
    distance = float(np.abs(way).max())
    profile = TrapezoidalProfile(
        distance, float(limits.velocity.min()), float(limits.acceleration.min()))
    times = np.array(list(sample_times(profile.duration)))
    place, speed, rate = (values[:, None] / distance for values in profile.states(times))
    return QuinticMotion(times, start + place * way, speed * way, rate * way)


class JointSampler:
    """
    Solves inverse kinematics pose by pose, each from the solution before it.

    Velocities and accelerations are finite differences, which have to keep the limits that the
    joints have; between the poses nothing is checked.

    :param context: the robot and its solvers.
    :param validity: of the group that moves.
    :param frame: follows the poses; fixed to the tip of the group's solver.
    :param source: names the command in messages.
    :param check: called for every pose; raises where the request was cancelled.
    """

    def __init__(
        self, context: PlanningContext, validity: StateValidity, frame: Frame, source: str,
        check: Callable[[], None],
    ) -> None:
        self._context, self._validity, self._frame, self._source = context, validity, frame, source
        self._check = check
        self._fastest, self._hardest = given_limits(context.model.robot, validity.joint_names)

    def from_rest_to_rest(
        self, pose_at: Callable[[float], Matrix], duration: float, start: Vector
    ) -> QuinticMotion:
        """
        Return the motion of a frame over a time [s], at rest at both ends.

        :param pose_at: time [s] -> pose (4, 4).
        :param start: (m,) the group's values before the first pose.
        """
        times = sample_times(duration)
        first = self._solved(pose_at(next(times)), start)
        motion = QuinticMotion.at_rest(first)
        samples = ((time, pose_at(time)) for time in times)
        rest = self.followed(samples, first, np.zeros_like(first))
        if not len(rest.times):
            return motion
        rest.velocities[-1] = rest.accelerations[-1] = 0.0
        return motion.joined(rest, 0.0)

    def followed(
        self, samples: Iterable[tuple[float, Matrix]], values: Vector, velocity: Vector,
        step: float = SAMPLING_TIME,
    ) -> QuinticMotion:
        """
        Return the motion through poses (4, 4) at times [s] after 0.

        :param values: (m,) the group's values at time 0.
        :param velocity: (m,) before time 0.
        :param step: time [s] from each point to the next, but for the last.
        :raises PlanningError: NO_IK_SOLUTION for a pose without a solution; PLANNING_FAILED
            where a joint would exceed a limit.
        """
        rows: list[tuple[Vector, Vector, Vector]] = []
        times, before = [], 0.0
        for time, pose in samples:
            found = self._solved(pose, values)
            interval = time - before
            speed = (found - values) / interval
            rate = 2.0 * (speed - velocity) / (interval + step)
            self._check_limit('velocity', speed, self._fastest, time)
            self._check_limit('acceleration', rate, self._hardest, time)
            rows.append((found, speed, rate))
            times.append(time)
            values, velocity, before = found, speed, time
        states = np.array(rows).reshape(-1, 3, len(values))
        return QuinticMotion(np.array(times), states[:, 0], states[:, 1], states[:, 2])

    def _solved(self, pose: Matrix, start: Vector) -> Vector:
        """Return the state (m,) at a pose: near the start, or any other."""
        self._check()
        group, q = self._validity.group, self._validity.full(start)
        inverse = self._context.inverse(group)
        target = [IKTarget(self._frame.link, pose, self._frame.offset)]
        result = inverse.solve(target, q, IKOptions(max_starts=0))
        if result.q is None:
            result = inverse.solve(target, q)
        if result.q is None:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"{self._source}: '{self._frame.link}' cannot follow its path: {result.message}",
                self._source)
        return self._context.model.extract(result.q, group)

    def _check_limit(self, kind: str, found: Vector, allowed: Vector, time: float) -> None:
        share = np.abs(found) / allowed
        worst = int(np.argmax(share))
        if share[worst] > 1.0:
            raise PlanningError(
                MoveItErrorCode.PLANNING_FAILED,
                f'{self._source}: at {time:.3f} s the {kind} of joint '
                f"'{self._validity.joint_names[worst]}' would be {abs(found[worst]):.3f}, its "
                f'limit is {allowed[worst]:.3f}; set a lower max_velocity_scaling_factor or '
                'max_acceleration_scaling_factor, or avoid the singularity', self._source)


def given_limits(robot: RobotModel, joint_names: Sequence[str]) -> tuple[Vector, Vector]:
    """Return velocity and acceleration limits (m,) of joints, infinite where none is given."""
    limits = [robot.joints[name].limits for name in joint_names]
    given = np.array([[each.velocity, each.acceleration] for each in limits], dtype=np.float64)
    velocity, acceleration = np.where(np.isfinite(given) & (given > 0.0), given, np.inf).T
    return velocity, acceleration
