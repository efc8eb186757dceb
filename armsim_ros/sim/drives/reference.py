# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Commands of the control rate as references at the rate of the physics; bounds of the joints.

A long control period is computed at once: all that a cubic requires is linear in a few rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.sim.physics.robot_spec import bound_or_infinite


class CommandInterpolator:
    """
    Splines through the position commands of successive control periods.

    A segment runs from the last command to the new command. It is quintic where velocities and
    accelerations are known at both ends, else cubic; a velocity that is not given is the
    difference of the two commands. With a step per period the command itself is the reference.

    :param positions: (n,) where the joints are [rad or m].
    """

    def __init__(self, positions: Vector) -> None:
        self._end = positions.copy()
        self._end_velocity = np.zeros(len(positions))
        self._end_acceleration = np.zeros(len(positions))
        self._ends = (self._end[None],) * 3
        self._unknown = np.full((1, len(positions)), np.nan)

    def restart(self, positions: Vector, which: Mask) -> None:
        """
        Forget the commands of some joints and let them rest.

        :param positions: (n,) where they rest; entries of other joints are not read.
        :param which: (n,) the joints that are meant.
        """
        self._end = np.where(which, positions, self._end)
        self._end_velocity = np.where(which, 0.0, self._end_velocity)
        self._end_acceleration = np.where(which, 0.0, self._end_acceleration)

    def command(
        self, target: Vector, velocity: Vector, acceleration: Vector, steps: int, period: float
    ) -> Matrix:
        """
        Return the references of a control period (steps, n), the last is the command.

        :param target: (n,) where to be at its end [rad or m].
        :param velocity: (n,) at its end, NaN where not known [rad/s or m/s].
        :param acceleration: (n,) at its end, NaN where not known [rad/s^2 or m/s^2].
        :param steps: physics steps in the period.
        :param period: time of the period [s].
        """
        if steps == 1:
            self._end = target
            return target[None]
        rows = self.preview(target[None], velocity[None], acceleration[None], steps, period)
        self.go_on(1)
        return rows

    def preview(
        self, targets: Matrix, velocities: Matrix, accelerations: Matrix, steps: int, period: float
    ) -> Matrix:
        """
        Return the references of some control periods (k * steps, n); ``go_on`` follows them.

        :param targets: (k, n) where to be at the end of each; the others as for ``command``.
        """
        if steps == 1:
            self._ends = (targets, targets[:0], targets[:0])
            return targets
        starts = np.concatenate((self._end[None], targets[:-1]))
        distance = targets - starts
        end_velocity = np.where(np.isfinite(velocities), velocities, distance / period)
        coefficients = _segment(
            starts,
            distance,
            np.concatenate((self._end_velocity[None], end_velocity[:-1])) * period,
            end_velocity * period,
            np.concatenate((self._end_acceleration[None], accelerations[:-1])) * period**2,
            accelerations * period**2)
        self._ends = (targets, end_velocity, accelerations)
        # (step, period, joint): long rows for numpy.
        s = (np.arange(1, steps + 1) / steps)[:, None, None]
        # What a cubic has not is left out; a zero stays a positive zero, as if it were added.
        highest = 5 if coefficients[4:].any() else 3
        rows: Matrix = s * (coefficients[highest] + 0.0)
        for power in range(highest - 1, 0, -1):
            rows += coefficients[power]
            rows *= s
        rows += coefficients[0]
        rows[-1] = targets
        return rows.transpose(1, 0, 2).reshape(-1, targets.shape[1])

    def cubic(self, target: Vector, start: Vector, velocity: Vector, period: float) -> Matrix:
        """
        Return what ``preview`` does for one period with an end velocity that is not known.

        ``go_on`` follows it, too.

        :param start: (n,) the reference now [rad or m].
        :param velocity: (n,) its velocity [rad/s or m/s].
        :returns: (5, n) features as for ``PeriodBasis``.
        """
        way, first = target - self._end, self._end_velocity * period
        features = np.empty((5, len(target)))
        features[0], features[1], features[3], features[4] = start, first, first - way, velocity
        np.multiply(-2.0, features[3], out=features[2])
        self._ends = (target[None], (way / period)[None], self._unknown)
        return features

    def go_on(self, periods: int) -> None:
        """Be at the end of so many of the periods of the last ``preview``."""
        targets, velocities, accelerations = self._ends
        self._end = targets[periods - 1].copy()
        if len(velocities):
            self._end_velocity = velocities[periods - 1].copy()
            self._end_acceleration = accelerations[periods - 1].copy()


def _segment(p0: Vector, d: Vector, v0: Vector, v1: Vector, a0: Vector, a1: Vector) -> Vector:
    """
    Return polynomial coefficients (6, n) or (6, k, n) over s in 0..1.

    Quintic Hermite where both accelerations are finite, else cubic Hermite; derivatives are by
    s.
    """
    c = np.zeros((6, *p0.shape))
    c[0], c[1] = p0, v0
    quintic = np.isfinite(a0 + a1)
    if quintic.all():
        c[2] = 0.5 * a0
        c[3] = 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
        c[4] = -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
        c[5] = 6 * d - 3 * (v0 + v1) - 0.5 * a0 + 0.5 * a1
        return c
    c[2] = 3 * d - 2 * v0 - v1
    c[3] = v0 + v1 - 2 * d
    if quintic.any():
        some = (part[quintic] for part in (p0, d, v0, v1, a0, a1))
        c[:, quintic] = _segment(*some)
    return c


#: A servo follows references this much faster than the joint's rated velocity, so that a
#: trajectory at the limit does not fall behind where its splines swing over it.
VELOCITY_HEADROOM = 1.1


@dataclass(frozen=True, slots=True, eq=False)
class DrivenLimits:
    """
    Bounds of all joints with a motor; infinite where there is none.

    :param lower: (n,) [rad or m].
    :param upper: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s], with the headroom.
    :param effort: (n,) [N*m or N].
    """

    lower: Vector
    upper: Vector
    velocity: Vector
    effort: Vector

    @classmethod
    def of(cls, model: RobotModel) -> DrivenLimits:
        """Return the limits of a robot's active joints, in their order."""
        joints = [model.joints[name] for name in model.active_joints]
        endless = [joint.type is JointType.CONTINUOUS for joint in joints]
        lower = np.array([joint.limits.lower for joint in joints], dtype=np.float64)
        upper = np.array([joint.limits.upper for joint in joints], dtype=np.float64)
        lower[endless], upper[endless] = -np.inf, np.inf
        velocity = [bound_or_infinite(joint.limits.velocity) for joint in joints]
        effort = [bound_or_infinite(joint.limits.effort) for joint in joints]
        return cls(lower, upper, VELOCITY_HEADROOM * np.array(velocity), np.array(effort))

    def bounded(self, start: Vector, requested: Matrix, longest: Vector, weights: Vector
                ) -> Matrix:
        """
        Return a reference to the requested positions, as far as the limits allow.

        :param start: (n,) where it is now [rad or m].
        :param requested: (k, n) positions after each step.
        :param longest: (n,) ways in a step [rad or m].
        :param weights: (n,) 1 by ``longest``.
        :returns: (k + 1, n), the start first.
        """
        references = np.empty((len(requested) + 1, requested.shape[1]))
        references[0] = start
        np.maximum(requested, self.lower, out=references[1:])
        np.minimum(references[1:], self.upper, out=references[1:])
        shares = (references[1:] - references[:-1]) * weights
        # Where the squares of all shares do not add up to one, none is above it.
        if float(np.vdot(shares, shares)) < 1.0 or not (np.abs(shares) > 1.0).any():
            return references
        for i in range(1, len(references)):
            way = references[i] - references[i - 1]
            if (np.abs(way * weights) > 1.0).any():
                references[i] = references[i - 1] + np.clip(way, -longest, longest)
        return references


def fingers_driven(model: RobotModel) -> Vector:
    """
    Return for how many fingers each active joint has force (n,), in their order; 1 for most.

    Sliding joints that mimic a sliding joint are fingers of a gripper. Each presses with the
    requested effort, as if it had its own drive; a common motor would share it.
    """
    counts = dict.fromkeys(model.active_joints, 1.0)
    for joint in model.joints.values():
        leader, multiplier, _ = model.driver_of(joint.name)
        if leader is not joint and _slides(joint) and _slides(leader) and leader.name in counts:
            counts[leader.name] += abs(multiplier)
    return np.array(list(counts.values()))


def _slides(joint: Joint) -> bool:
    return joint.type is JointType.PRISMATIC


#: From a cubic's factors to Bernstein's coefficients of its velocity, then of itself.
_BERNSTEIN = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 1.0, 2.0, 3.0],
                       [1.0, 1 / 3, 0.0, 0.0], [1.0, 2 / 3, 1 / 3, 0.0], [1.0, 1.0, 1.0, 1.0]])


class PeriodBasis:
    """
    What the steps of a period make of its features.

    Features are rows (5, n): the reference at its start, the factors of s, s^2 and s^3 with s from
    0 to 1 over the period, and the velocity before its first step. Velocities and accelerations
    are the differences of the references. All products are MuJoCo's: the bytes of numpy's differ
    between its versions.

    :param steps: physics steps in the period.
    :param timestep: of each [s].
    :param limits: of the joints.
    :param implicit: whether damping counts the velocity at a step's end, not at its start.
    """

    def __init__(
        self, steps: int, timestep: float, limits: DrivenLimits, *, implicit: bool
    ) -> None:
        self.steps = steps
        self._limits, self._timestep = limits, timestep
        self._longest_step = timestep * limits.velocity
        farthest = steps * timestep * limits.velocity
        #: Between these rows those of ``_BERNSTEIN`` are within the limits.
        self._least = np.stack((*[-farthest] * 3, *[limits.lower] * 3))
        self._most = np.stack((*[farthest] * 3, *[limits.upper] * 3))
        s = np.arange(steps + 1) / steps
        self._share = s[:-1]
        powers = np.stack((np.ones_like(s), s, s * s, s * s * s, np.zeros_like(s)), axis=1)
        velocities = np.empty_like(powers)
        velocities[0] = 0.0, 0.0, 0.0, 0.0, 1.0
        velocities[1:] = np.diff(powers, axis=0) / timestep
        self._accelerations = np.diff(velocities, axis=0) / timestep
        self._motion = np.concatenate((powers, velocities))
        damped = velocities[1:] if implicit else velocities[:-1]
        forced = self._accelerations[:, 1:]
        share = self._share[:, None]
        self._inputs = np.ascontiguousarray(np.concatenate(
            (forced, share * forced, powers[:-1, :4], damped[:, 1:], powers[:-1, :2]), axis=1))

    def motion(self, features: Matrix) -> tuple[Matrix, Matrix]:
        """Return references (k + 1, n) and velocities (k + 1, n) before each step, and after."""
        found = product(self._motion, features)
        return found[:self.steps + 1], found[self.steps + 1:]

    def allows(self, features: Matrix, references: Matrix, velocities: Matrix) -> bool:
        """Return whether a motion is within the limits."""
        # Bernstein's coefficients bound a polynomial; that is enough mostly.
        bounds = product(_BERNSTEIN, features[:4])
        if ((bounds >= self._least) & (bounds <= self._most)).all():
            return True
        limits = self._limits
        return bool((np.abs(velocities[1:]) * self._timestep <= self._longest_step).all()
                    and (references >= limits.lower).all()
                    and (references <= limits.upper).all())

    def accelerations(self, features: Matrix) -> Matrix:
        """Return the accelerations of each step (k, n)."""
        return product(self._accelerations, features)

    def inputs(
        self, features: Matrix, first: Matrix, change: Matrix, bias: Matrix, stiffness: Vector,
        damping: Vector,
    ) -> Matrix:
        """
        Return the actuators' inputs in each step (k, n).

        :param features: (5, n).
        :param first: (4, n) the features but the first, times the inertia at the start.
        :param change: (4, n) times the inertia at the end less that at the start.
        :param bias: (2, n) the other forces at the start, and their change.
        :param stiffness: (n,) of the actuators.
        :param damping: (n,) of the actuators.
        """
        return product(self._inputs, np.concatenate(
            (first, change, features[:4] * stiffness, features[1:] * damping, bias)))


def product(left: Matrix, right: Matrix) -> Matrix:
    """Return the product of two matrices, with the same bytes everywhere."""
    found = np.empty((left.shape[0], right.shape[1]))
    mujoco.mju_mulMatMat(found, np.ascontiguousarray(left), right)
    return found
