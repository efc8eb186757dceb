# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far joints may be from their reference, on the way and at the goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.errors import nearest

QUANTITIES = ('position', 'velocity', 'acceleration')
ERASE = -1.0
ROUNDING = 1.2e-7
"""So near to -1 a goal's tolerance counts as that; FLT_EPSILON upstream."""


@dataclass(frozen=True, slots=True)
class JointTolerance:
    """A goal's own tolerance of a joint: 0 keeps the default, -1 takes it away."""

    name: str
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class SegmentTolerances:
    """
    Tolerances of a trajectory; infinite is unchecked.

    :param path: (3, n) of position, velocity, acceleration on the way.
    :param goal: (3, n) of the same at the goal.
    :param goal_time: after the last waypoint, 0 is no bound [s].
    """

    path: Matrix
    goal: Matrix
    goal_time: float

    @classmethod
    def of(cls, parameters: JointTrajectoryControllerParameters) -> SegmentTolerances:
        """Return the defaults that the parameters give."""
        constraints = parameters.constraints
        path, goal = (np.full((3, len(parameters.joints)), np.inf) for _ in range(2))
        for i, joint in enumerate(parameters.joints):
            path[0, i] = _checked(constraints.joints[joint].trajectory)
            goal[0, i] = _checked(constraints.joints[joint].goal)
        goal[1] = _checked(constraints.stopped_velocity_tolerance)
        return cls(path, goal, constraints.goal_time)

    def overridden(
        self, joints: Sequence[str], path: Sequence[JointTolerance],
        goal: Sequence[JointTolerance], goal_time: float
    ) -> tuple[SegmentTolerances, str]:
        """
        Lay a goal's own tolerances over these defaults.

        :param goal_time: 0 keeps the default, -1 takes it away [s].
        :returns: the tolerances, and a text. Where it is not empty it is the error in
            the goal's tolerances, and the defaults are returned unchanged.
        """
        tables = []
        for kind, default, given in (('path', self.path, path), ('goal', self.goal, goal)):
            table = default.copy()
            for tolerance in given:
                if tolerance.name not in joints:
                    hint = nearest(tolerance.name, joints)
                    return self, (
                        f"{kind} tolerance for '{tolerance.name}', which is not a joint of the "
                        f'controller{"; " if hint else ""}{hint}')
                column = joints.index(tolerance.name)
                for row, quantity in enumerate(QUANTITIES):
                    value = getattr(tolerance, quantity)
                    if not _legal(value):
                        return self, (
                            f"{kind} tolerance {value:g} for the {quantity} of '{tolerance.name}';"
                            ' allowed: a positive number, 0 for the default, -1 for none')
                    if value:
                        table[row, column] = np.inf if _erases(value) else value
            tables.append(table)
        if not _legal(goal_time):
            return self, (
                f'goal time tolerance {goal_time:g} s; allowed: a positive number, 0 for the '
                'default, -1 for none')
        seconds = self.goal_time if goal_time == 0.0 else max(goal_time, 0.0)
        return SegmentTolerances(tables[0], tables[1], seconds), ''


def _checked(tolerance: float) -> float:
    """Return a parameter's tolerance, infinite where it is not above 0."""
    return tolerance if tolerance > 0.0 else np.inf


def _erases(value: float) -> bool:
    return abs(value - ERASE) < ROUNDING


def _legal(value: float) -> bool:
    return value >= 0.0 or _erases(value)


@dataclass(frozen=True, slots=True)
class Violation:
    """The joint that is furthest outside its tolerance."""

    joint: str
    quantity: str
    error: float
    limit: float

    def __str__(self) -> str:
        """Return joint, error and limit in words."""
        return (
            f"joint '{self.joint}' {self.quantity} error {self.error:.6f} exceeds {self.limit:g}")


class ToleranceCheck:
    """
    A table of tolerances, checked in every update.

    :param joints: (n,) names for the messages.
    :param limits: (3, n) as in :class:`SegmentTolerances`.
    :param computed: which of position, velocity, acceleration have an error to check.
    """

    __slots__ = ('_joints', '_limits', '_rows', '_shares', '_weights', 'checks')

    def __init__(self, joints: Sequence[str], limits: Matrix, computed: Sequence[bool]) -> None:
        self._joints = joints
        used = limits.copy()
        used[[not known for known in computed]] = np.inf
        finite = np.flatnonzero(np.isfinite(used).any(axis=1))
        self._rows = int(finite[-1]) + 1 if len(finite) else 0
        self._limits = used[: self._rows]
        with np.errstate(divide='ignore'):
            self._weights = 1.0 / self._limits
        self._shares = np.empty_like(self._limits)
        self.checks = self._rows > 0

    def violated(self, errors: Matrix) -> bool:
        """Return whether any of the (3, n) errors is outside."""
        if not self._rows:
            return False
        # Where the squares of all shares do not add up to one, no share is above it.
        shares = self._shares
        np.multiply(errors[: self._rows], self._weights, out=shares)
        if float(np.vdot(shares, shares)) < 1.0:
            return False
        return bool((np.abs(errors[: self._rows]) > self._limits).any())

    @property
    def weights(self) -> Vector | None:
        """Return 1 by tolerance (n,) of the positions, None where there are others, too."""
        if self._rows > 1:
            return None
        return self._weights[0] if self._rows else np.zeros(len(self._joints))

    def worst(self, errors: Matrix) -> Violation:
        """Return the violation with the largest ratio of error to limit."""
        ratio = np.abs(errors[: self._rows]) / self._limits
        row, column = divmod(int(np.nanargmax(ratio)), ratio.shape[1])
        return Violation(
            self._joints[column], QUANTITIES[row], float(errors[row, column]),
            float(self._limits[row, column]))
