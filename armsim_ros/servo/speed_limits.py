# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What slows a stream of commands: singularities, the bounds of joints, and near collisions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType, PairDistance
from armsim_ros.servo.commands import Finding, ServoStatus

AT_BOUND = 1e-3
"""From here on a joint counts as having come to its bound [rad or m]."""


@dataclass(frozen=True, slots=True, eq=False)
class JointBounds:
    """
    Bounds of m joints.

    :param lower: (m,) margins taken off [rad or m].
    :param upper: (m,) margins taken off [rad or m].
    :param velocity: (m,) infinite where there is no limit [rad/s or m/s].
    :param acceleration: (m,) [rad/s^2 or m/s^2].
    """

    names: tuple[str, ...]
    lower: Vector
    upper: Vector
    velocity: Vector
    acceleration: Vector

    def speed_factor(self, velocity: Vector, override: float) -> float:
        """
        Return the common factor, at most 1, with which no joint's limit forbids velocities (m,).

        :param override: factor of all velocities; below 0.01 it is off. The limits may make the
            common factor smaller.
        """
        excess = _greatest(np.abs(velocity) / self.velocity)
        return min(override if override >= 0.01 else 1.0, 1.0 / max(excess, 1.0))

    def limit_position(
        self, q: Vector, velocity: Vector, period: float, *, all_halt: bool
    ) -> tuple[Vector, Finding | None]:
        """
        Return velocities (m,) from which every joint can brake before its bound.

        :param q: (m,) positions [rad or m].
        :param all_halt: slow all joints as the joint at its bound, not that joint alone.
        :returns: the velocities, and findings where a joint has come to its bound.
        """
        distance, fastest = self._fastest(q, velocity, period)
        speed = np.abs(velocity)
        too_fast = speed > fastest
        if not too_fast.any():
            return velocity, None
        halted = np.flatnonzero(too_fast & (distance < AT_BOUND))
        finding = None
        if len(halted):
            joint = int(halted[0])
            bound, way = ((self.upper[joint], 'up') if velocity[joint] > 0.0
                          else (self.lower[joint], 'down'))
            finding = Finding(
                ServoStatus.JOINT_BOUND,
                f"joint '{self.names[joint]}' at {q[joint]:.4f}, allowed {way} to {bound:.4f}")
        if not all_halt:
            return np.copysign(np.minimum(speed, fastest), velocity), finding
        share = float(np.min(fastest[too_fast] / speed[too_fast]))
        return velocity * share, finding

    def accelerate(self, now: Vector, requested: Vector, period: float) -> Vector:
        """Return the velocities (m,) a cycle later; all joints approach by a common factor."""
        change = requested - now
        excess = _greatest(np.abs(change) / (self.acceleration * period))
        return now + change / excess if excess > 1.0 else requested

    def brake_in_time(self, q: Vector, now: Vector, velocity: Vector, period: float) -> Vector:
        """
        Return velocities (m,) of which none leads a joint past its bound.

        A joint that comes near its bound brakes as hard as it may, even where all others, and
        by that the common factor, are slower to change.

        :param q: (m,) positions [rad or m].
        :param now: (m,) velocities before [rad/s or m/s].
        :param velocity: (m,) those of the next cycle.
        """
        _, fastest = self._fastest(q, velocity, period)
        least = np.where(now * velocity > 0.0, np.abs(now) - self.acceleration * period, 0.0)
        return np.copysign(np.minimum(np.abs(velocity), np.maximum(fastest, least)), velocity)

    def _fastest(self, q: Vector, velocity: Vector, period: float) -> tuple[Vector, Vector]:
        """Return the distance to the bounds ahead (m,), and speeds that can be braked in it."""
        distance = np.maximum(np.where(velocity > 0.0, self.upper - q, q - self.lower), 0.0)
        braked = np.sqrt(2.0 * self.acceleration * distance)
        return distance, np.minimum(braked, distance / period)

    def braking_time(self, velocity: Vector) -> float:
        """Return how long the joints take to come to rest together [s]."""
        return _greatest(np.abs(velocity) / self.acceleration)


def _greatest(values: Vector) -> float:
    """Return the greatest of values that are not negative, 0 of none."""
    return float(np.maximum.reduce(values, initial=0.0))


SLOWEST_WAY_OUT = 0.1
"""A motion away from a singularity keeps this share of its speed."""


@dataclass(frozen=True, slots=True)
class SingularityThresholds:
    """
    Condition numbers, see the parameters of servo.

    :param step: relative length of the step that finds the side of the singularity.
    """

    lower: float
    hard: float
    leaving: float
    step: float


def condition(jacobian: Matrix) -> tuple[float, Vector]:
    """Return greatest over smallest singular value, and the left vector (6,) of the smallest."""
    # Eigenvalues of J J^T are the squares of the singular values, in rising order.
    values, left = np.linalg.eigh(jacobian @ jacobian.T)
    place = max(0, 6 - jacobian.shape[1])
    smallest = float(values[place])
    if smallest <= 1e-14 * float(values[-1]):
        return math.inf, left[:, place]
    return math.sqrt(float(values[-1]) / smallest), left[:, place]


def surely_below(jacobian: Matrix, bound: float) -> bool:
    """
    Return True only where the condition number is not above a bound; quicker than to know it.

    Frobenius norms of a matrix and its inverse are no smaller than its greatest eigenvalue and
    the inverse of its smallest value.
    """
    few = jacobian.shape[1] < len(jacobian)
    squares = jacobian.T @ jacobian if few else jacobian @ jacobian.T
    try:
        inverse = np.linalg.inv(squares)
    except np.linalg.LinAlgError:
        return False
    return bool(np.vdot(squares, squares) * np.vdot(inverse, inverse) <= bound**4)


def singularity_factor(
    q: Vector, twist: Vector, jacobian: Matrix, jacobian_at: Callable[[Vector], Matrix],
    thresholds: SingularityThresholds
) -> tuple[float, Finding | None]:
    """
    Return the share of a motion's speed that a singularity leaves.

    :param q: (m,) the moving joints [rad or m].
    :param twist: (6,) requested of the tip, linear over angular, in the units of the Jacobian.
    :param jacobian: (6, m) there.
    :param jacobian_at: (m,) -> (6, m), for other positions.
    :returns: 0 to 1, and findings where it is less than 1.
    """
    if surely_below(jacobian, thresholds.lower):
        return 1.0, None
    number, direction = condition(jacobian)
    if number <= thresholds.lower:
        return 1.0, None
    step = np.linalg.pinv(jacobian, rcond=1e-6) @ (direction * thresholds.step)
    length = float(np.abs(step).max())
    if length > 0.1:  # next to the singularity a step in the tip's space is long in the joints'
        step *= 0.1 / length
    if condition(jacobian_at(q + step))[0] < number:
        direction = -direction
    detail = f'condition number {number:.1f}, allowed {thresholds.hard:g}'
    span = thresholds.hard - thresholds.lower
    if float(direction @ twist) > 0.0:
        if number >= thresholds.hard:
            return 0.0, Finding(ServoStatus.HALT_FOR_SINGULARITY, detail)
        return 1.0 - (number - thresholds.lower) / span, Finding(
            ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY, detail)
    factor = 1.0 - (number - thresholds.lower) / (span * thresholds.leaving)
    return max(factor, SLOWEST_WAY_OUT), Finding(
        ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY, detail)


MARGIN = 0.1
"""What is farther from its threshold than this is not checked singly [m]."""
_STEEPNESS = math.log(1000.0)
_GAIN = 1e-7
"""A motion gains distance that gains more than this [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class ClearStates:
    """
    States that are known to be clear because one of them was checked.

    No pair can come nearer than the joints move what they carry.

    :param q: (n,) the state that was checked.
    :param edits: of the scene, up to then.
    :param weights: (k, n) motion of bodies against each other [m/rad or m/m].
    :param margin: (k,) from their distance to the threshold [m].
    """

    q: Vector
    edits: int
    weights: Matrix
    margin: Vector

    def include(self, q: Vector, edits: int) -> bool:
        """Return whether a state (n,) is one of them."""
        return edits == self.edits and bool(
            (self.weights @ np.abs(q - self.q) < self.margin).all())


class Proximity:
    """
    Slows motions down that come near to a collision.

    :param checker: follows the planning scene.
    :param group: the planning group that moves.
    :param self_threshold: the robot slows down this near to itself [m].
    :param scene_threshold: and this near to all else [m].
    """

    def __init__(
        self, checker: CollisionChecker, group: str, self_threshold: float, scene_threshold: float
    ) -> None:
        """Keep the thresholds."""
        self._checker, self._group, self._self_threshold = checker, group, self_threshold
        self._scene_threshold = scene_threshold
        self._clear: ClearStates | None = None
        self._slowed = False

    def factor(self, q: Vector, ahead: Vector) -> tuple[float, Finding | None]:
        """
        Return the share of a motion's speed that is left.

        Motion that gains distance keeps all of it, so that there is always a way out.

        :param q: (n,) the robot now.
        :param ahead: (n,) the robot when it has come to rest after the next step.
        :returns: 0 to 1, and findings where it is less than 1.
        """
        edits = self._checker.edits
        if self._clear is not None and self._clear.include(ahead, edits):
            return 1.0, None
        near = self._near(ahead, edits)
        if not near:
            return 1.0, None
        within = 2.0 * self._scene_threshold
        now = _shortest(self._checker.pair_distances(q, within, self._group))
        worst, culprit = 1.0, None
        for pair in near:
            if pair.distance > now.get(pair.names, math.inf) + _GAIN:
                continue
            factor = 0.0
            if pair.distance > 0.0:
                threshold = self._threshold(pair)
                factor = math.exp(-_STEEPNESS * (threshold - pair.distance) / threshold)
            if factor < worst:
                worst, culprit = factor, pair
        if culprit is None:
            return 1.0, None
        if worst == 0.0:
            return 0.0, Finding(ServoStatus.HALT_FOR_COLLISION, culprit.phrase)
        detail = f'{culprit.phrase}, {1000.0 * culprit.distance:.1f} mm apart'
        return worst, Finding(ServoStatus.DECELERATE_FOR_COLLISION, detail)

    def _near(self, q: Vector, edits: int) -> list[PairDistance]:
        """Return the pairs that slow down in a state (n,); and note which states are clear."""
        margin = 0.0 if self._slowed else MARGIN
        pairs = self._checker.pair_distances(
            q, self._scene_threshold + margin, self._group, exact=False)
        near = [pair for pair in pairs if self._slows(pair)]
        relative = self._checker.relative_motion
        moving = [pair for pair in pairs if pair.joints[0] != pair.joints[1]]
        weights = [relative[pair.joints] for pair in moving]
        margins = [pair.distance - self._threshold(pair) for pair in moving]
        self._clear = None if near else ClearStates(
            q, edits, np.array([relative.max(axis=(0, 1)), *weights]),
            np.array([margin, *margins]))
        if near and self._checker.has_hulls:
            pairs = self._checker.pair_distances(q, self._scene_threshold, self._group)
            near = [pair for pair in pairs if self._slows(pair)]
        self._slowed = bool(near)
        return near

    def _slows(self, pair: PairDistance) -> bool:
        """Return whether two bodies are too near; on the same joint, whether they touch."""
        apart = pair.joints[0] != pair.joints[1] and pair.distance >= self._threshold(pair)
        rigid = pair.joints[0] == pair.joints[1] and pair.distance > 0.0
        return not (apart or rigid)

    def _threshold(self, pair: PairDistance) -> float:
        world = BodyType.WORLD_OBJECT in pair.types
        return self._scene_threshold if world else self._self_threshold


def _shortest(pairs: Iterable[PairDistance]) -> dict[tuple[str, str], float]:
    shortest: dict[tuple[str, str], float] = {}
    for pair in pairs:
        shortest[pair.names] = min(pair.distance, shortest.get(pair.names, math.inf))
    return shortest
