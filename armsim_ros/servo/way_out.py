# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The directions in which an arm can move that a singularity, a bound or a contact holds."""

from __future__ import annotations

from collections.abc import Iterator
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ServoParameters
from armsim_ros.errors import PlanningError
from armsim_ros.servo.commands import InvalidCommandError, Twist
from armsim_ros.servo.speed_limits import JointBounds, Proximity
from armsim_ros.servo.target_velocity import TargetVelocity

DISTANCE = 0.025
"""The tip can move this far along a direction that is reported as free [m]."""
TURN = 0.3
"""A joint that is reported as free can turn this far [rad or m]."""
_PATIENCE = 12
"""
So many cycles have to be blocked before a direction is evaluated.

More than are made at once where a command takes effect on points that were already sent.
"""
_FIRST, _LAST = 2e-5, 2.5e-3
"""Steps in which that is tried, from the first on twice as long as the one before [m]."""
_SLOWEST = 0.03
"""A step slower than this share of the command does not count as a motion."""
_LONGEST = 0.2
"""A step that turns a joint farther than this is too near to a singularity [rad or m]."""
_FACTOR = 0.3
_AXES = {'+x': (1, 0, 0), '-x': (-1, 0, 0), '+y': (0, 1, 0), '-y': (0, -1, 0),
         '+z': (0, 0, 1), '-z': (0, 0, -1)}


class WayOut:
    """
    Evaluates a direction per cycle, so that no cycle takes long.

    First the six axes of the command's frame; where the tip cannot move along any of them, or is
    in a singularity, each joint in both directions: the joint that leaves the singularity
    farthest behind is the way.

    :param target: the velocities that directions ask for.
    :param bounds: of the group's joints.
    :param proximity: knows what is near.
    """

    def __init__(self, target: TargetVelocity, bounds: JointBounds, proximity: Proximity) -> None:
        """Know no direction yet."""
        self._target = target
        self._bounds = bounds
        self._proximity = proximity
        self.forget()

    def forget(self) -> None:
        """Begin anew: the arm has moved."""
        self._frame: str | None = None
        self._search: Iterator[str] = iter(())
        self._text = ''

    def advance(self, frame: str, q: Vector, parameters: ServoParameters) -> str:
        """
        Evaluate a direction, and return what is known, '' before all were evaluated.

        :param frame: the directions are those of its axes.
        :param q: (n,) the robot at rest.
        """
        if frame != self._frame:
            self.forget()
            self._frame, self._search = frame, self._evaluate(frame, q.copy(), parameters)
        self._text = next(self._search, self._text)
        return self._text

    def _evaluate(self, frame: str, q: Vector, parameters: ServoParameters) -> Iterator[str]:
        for _ in range(_PATIENCE):
            yield ''
        free = []
        # In the singularity itself, rounding decides which directions lead away from it.
        axes = {} if self._target.singularity(q)[0] else _AXES
        for name, axis in axes.items():
            if self._tip_moves(Twist(frame, np.array(axis, float), np.zeros(3)), q, parameters):
                free.append(name)
            yield ''
        if free:
            yield f'free: {", ".join(free)} of {frame}'
            return
        best: tuple[float, float] = (math.inf, math.inf)
        way = 'no axis and no joint is free; plan a motion away from here'
        for joint, name in enumerate(self._target.names):
            for sign, word in ((1.0, 'up'), (-1.0, 'down')):
                left = self._turned(joint, sign, q, parameters)
                if left is not None and left < best:
                    best, way = left, f"free: turn '{name}' {word}"
                yield ''
        yield way

    def _tip_moves(self, twist: Twist, q: Vector, parameters: ServoParameters) -> bool:
        target, here = self._target, q.copy()
        way, length = 0.0, _FIRST
        try:
            while way < DISTANCE:
                velocity = target.wanted(twist, here, parameters).velocity
                share, speed = target.progress(twist, here, velocity, parameters)
                if share < _SLOWEST:
                    return False
                step = velocity * (length / speed)
                if np.abs(step).max() > _LONGEST:
                    return False
                here[target.indices] += step
                here = target.complete(here)
                if not self._bounded(here, q):
                    return False
                way, length = way + length, min(2.0 * length, _LAST)
        except (InvalidCommandError, PlanningError):
            return False
        return self._is_clear(q, here, parameters)

    def _turned(self, joint: int, sign: float, q: Vector, parameters: ServoParameters
                ) -> tuple[int, float] | None:
        """Return how singular the arm is after a joint has turned; None where it cannot."""
        target, there = self._target, q.copy()
        if target.names[joint] not in target.moving_names:
            return None
        there[target.indices[joint]] += sign * TURN
        there = target.complete(there)
        if not self._bounded(there, q) or not self._is_clear(q, there, parameters):
            return None
        return target.singularity(there)

    def _bounded(self, q: Vector, start: Vector) -> bool:
        """Return whether no joint has gone past its bounds, or farther past them than it was."""
        values, before = q[self._target.indices], start[self._target.indices]
        return bool(((values <= np.maximum(self._bounds.upper, before) + 1e-9)
                     & (values >= np.minimum(self._bounds.lower, before) - 1e-9)).all())

    def _is_clear(self, q: Vector, there: Vector, parameters: ServoParameters) -> bool:
        if not parameters.check_collisions:
            return True
        return all(self._proximity.factor(q, q + share * (there - q))[0] >= _FACTOR
                   for share in (0.1, 0.5, 1.0))
