# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Cycle by cycle, commands become joint positions that move within all bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ServoParameters
from armsim_ros.errors import PlanningError
from armsim_ros.servo.commands import (
    Command,
    Finding,
    InvalidCommandError,
    NOTHING,
    Twist,
    weightiest,
)
from armsim_ros.servo.smoothing import SmoothingFilter
from armsim_ros.servo.speed_limits import JointBounds, Proximity
from armsim_ros.servo.target_velocity import TargetVelocity

LOOKS_A_SECOND = 50.0
"""Minimum rate of collision checks [Hz]."""
SETTLED = 1e-6
"""Nearer to rest than this is at rest [rad or m, a cycle]."""
BLOCKED = 0.01
"""A twist of which the joints make less than this share of what their limits allow is blocked."""


@dataclass(frozen=True, slots=True, eq=False)
class StreamState:
    """
    Where a stream is, to go on from there another time.

    :param position: (m,) before the filter [rad or m].
    :param velocity: (m,) before the filter [rad/s or m/s].
    :param sent: (m,) behind it [rad or m].
    :param filter: what the filter remembers.
    """

    position: Vector
    velocity: Vector
    sent: Vector
    filter: Any


@dataclass(frozen=True, slots=True, eq=False)
class Cycle:
    """
    The result of a cycle.

    :param positions: (m,) to send [rad or m].
    :param velocities: (m,) with which they change [rad/s or m/s].
    :param at_rest: whether they have come to rest.
    :param findings: what to report.
    """

    positions: Vector
    velocities: Vector
    at_rest: bool
    findings: tuple[Finding, ...] = field(default=())


class ServoStream:
    """
    Integrates joint velocities from where the controller's reference is.

    :param target: turns commands into velocities.
    :param bounds: of the group's joints.
    :param smoothing: the filter of what is sent.
    :param proximity: slows motion down near collisions.
    """

    def __init__(
        self, target: TargetVelocity, bounds: JointBounds, smoothing: SmoothingFilter,
        proximity: Proximity
    ) -> None:
        """Start idle."""
        self.target, self.bounds, self._smoothing = target, bounds, smoothing
        self._proximity = proximity
        self._way_out = WayOut(target, bounds, proximity)
        self.streaming = False
        self._halting = False
        self._factor = 1.0
        self._collision: Finding | None = None
        self._cycles_to_look = 0

    def warm_up(self, q: Vector, parameters: ServoParameters) -> None:
        """Do once what takes long the first time: tables of collisions, linear algebra."""
        twist = Twist(self.target.base, np.array([0.01, 0.0, 0.0]), np.zeros(3))
        self.start(q[self.target.indices])
        self.step(twist, q, parameters)
        self._proximity.factor(q, q)
        self.stop()

    def start(self, reference: Vector) -> None:
        """Begin at rest at the controller's reference (m,) [rad or m]."""
        self._position = reference.copy()
        self._velocity = np.zeros(len(reference))
        self._sent = reference.copy()
        self._smoothing.restart(reference)
        self._forget_collisions()
        self._way_out.forget()
        self._halting = False
        self.streaming = True

    def stop(self) -> None:
        """Send nothing more."""
        self.streaming = False

    @property
    def state(self) -> StreamState:
        """Where the stream is now."""
        return StreamState(self._position, self._velocity, self._sent, self._smoothing.saved())

    def restore(self, state: StreamState) -> None:
        """Go on from where the stream was once."""
        self._position, self._velocity = state.position, state.velocity
        self._sent = state.sent
        self._smoothing.restore(state.filter)

    def take_over(self, other: ServoStream) -> None:
        """Go on from where a stream of other parameters is, with the same joints and filter."""
        self.start(other.state.sent)
        self.restore(other.state)
        self._halting, self.streaming = other._halting, other.streaming

    def turns(self, command: Command | None) -> bool:
        """Return whether a command ends the motion, or resumes it, unlike the command before."""
        before, self._halting = self._halting, command is None or not command.moves
        return self._halting is not before

    def step(self, command: Command | None, q: Vector, parameters: ServoParameters) -> Cycle:
        """
        Advance by a period.

        :param command: None brings the arm to rest.
        :param q: (n,) the robot; the group's joints are taken from the stream itself.
        :raises InvalidCommandError: the command makes no sense; nothing has changed.
        """
        q = q.copy()
        q[self.target.indices] = self._position
        velocity = np.zeros_like(self._velocity)
        findings: list[Finding] = []
        factor = 1.0
        if command is not None:
            requested = self.target.wanted(command, q, parameters)
            findings += requested.findings
            factor = self.bounds.speed_factor(
                requested.velocity, parameters.override_velocity_scaling_factor)
            velocity = self._bounded(
                factor * requested.velocity, requested.cartesian, q, parameters, findings)
        period = parameters.publish_period
        coming = self.bounds.accelerate(self._velocity, velocity, period)
        self._velocity = self.bounds.brake_in_time(self._position, self._velocity, coming, period)
        if isinstance(command, Twist):
            self._add_way_out(command, q, parameters, velocity, factor * BLOCKED, findings)
        self._position = self._position + self._velocity * period
        before, self._sent = self._sent, self._smoothing.smooth(self._position)
        moved = self._sent - before
        at_rest = not self._velocity.any() and bool(
            np.abs(moved).max(initial=0.0) < SETTLED
            and np.abs(self._sent - self._position).max(initial=0.0) < 10.0 * SETTLED)
        return Cycle(self._sent, moved / period, at_rest, tuple(findings))

    def _add_way_out(self, command: Twist, q: Vector, parameters: ServoParameters,
                     velocity: Vector, least: float, findings: list[Finding]) -> None:
        """Add to the findings about a twist that moves nothing which directions are free."""
        if not command.moves or any(
                self.target.progress(command, q, each, parameters)[0] > least
                for each in (velocity, self._velocity)):
            self._way_out.forget()
            return
        text = self._way_out.advance(command.frame, q, parameters)
        if text:
            found = weightiest(findings)
            detail = f'{found.detail}; {text}' if found.detail else text
            if found.code is NOTHING.code:
                detail = f'the arm cannot move the tip this way here; {text}'
            findings.insert(0, Finding(found.code, detail))

    def _bounded(
        self, velocity: Vector, cartesian: bool, q: Vector, parameters: ServoParameters,
        findings: list[Finding]
    ) -> Vector:
        all_halt = (
            parameters.halt_all_joints_in_cartesian_mode
            if cartesian
            else parameters.halt_all_joints_in_joint_mode)
        velocity, finding = self.bounds.limit_position(
            self._position, velocity, parameters.publish_period, all_halt=all_halt)
        if finding is not None:
            findings.append(finding)
        if parameters.check_collisions and velocity.any():
            factor = self._collision_factor(velocity, q, parameters)
            if self._collision is not None:
                findings.append(self._collision)
            velocity = velocity * factor
        return velocity

    def _collision_factor(self, velocity: Vector, q: Vector, parameters: ServoParameters) -> float:
        """Look every few cycles at where the arm would come to rest."""
        period = parameters.publish_period
        if self._cycles_to_look > 0:
            self._cycles_to_look -= 1
            return self._factor
        rate = max(LOOKS_A_SECOND, parameters.collision_check_rate)
        self._cycles_to_look = max(0, int(1.0 / (rate * period) + 1e-9) - 1)
        # What it does anyhow until it has braked, and what it would do until the next look.
        coasting = 0.5 * self.bounds.braking_time(self._velocity) * self._velocity
        share = max(self._factor, 0.05)
        ahead = q.copy()
        ahead[self.target.indices] += (
            coasting + share * velocity * period * (2 + self._cycles_to_look))
        self._factor, self._collision = self._proximity.factor(q, self.target.complete(ahead))
        return self._factor

    def _forget_collisions(self) -> None:
        self._factor = 1.0
        self._collision = None
        self._cycles_to_look = 0


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
        self._target, self._bounds, self._proximity = target, bounds, proximity
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
                if share < _SLOWEST or speed <= 0.0:
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
