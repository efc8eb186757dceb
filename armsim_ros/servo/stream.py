# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Cycle by cycle, commands become joint positions that move within all bounds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ServoParameters
from armsim_ros.servo.commands import Command, Finding, NOTHING, Twist, weightiest
from armsim_ros.servo.smoothing import SmoothingFilter
from armsim_ros.servo.speed_limits import JointBounds, Proximity
from armsim_ros.servo.target_velocity import TargetVelocity
from armsim_ros.servo.way_out import WayOut

LOOKS_A_SECOND = 50.0
"""Minimum rate of collision checks [Hz]."""
SETTLED = 1e-6
"""Nearer to rest than this is at rest [rad or m, a cycle]."""
BLOCKED = 0.01
"""A twist of which the joints make a smaller share than this does not move the tip."""


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
        self.target = target
        self.bounds = bounds
        self._smoothing = smoothing
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
        if command is not None:
            requested = self.target.wanted(command, q, parameters)
            findings += requested.findings
            velocity = self._bounded(
                requested.velocity, requested.cartesian, q, parameters, findings)
        period = parameters.publish_period
        coming = self.bounds.accelerate(self._velocity, velocity, period)
        self._velocity = self.bounds.brake_in_time(self._position, self._velocity, coming, period)
        if isinstance(command, Twist):
            self._add_way_out(command, q, parameters, velocity, findings)
        self._position = self._position + self._velocity * period
        before, self._sent = self._sent, self._smoothing.smooth(self._position)
        moved = self._sent - before
        at_rest = not self._velocity.any() and bool(
            np.abs(moved).max(initial=0.0) < SETTLED
            and np.abs(self._sent - self._position).max(initial=0.0) < 10.0 * SETTLED)
        return Cycle(self._sent, moved / period, at_rest, tuple(findings))

    def _add_way_out(self, command: Twist, q: Vector, parameters: ServoParameters,
                     velocity: Vector, findings: list[Finding]) -> None:
        """Add to the findings about a twist that moves nothing which directions are free."""
        if not command.moves or any(
                self.target.progress(command, q, each, parameters)[0] > BLOCKED
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
        velocity = self.bounds.limit_speed(velocity, parameters.override_velocity_scaling_factor)
        all_halt = (
            parameters.halt_all_joints_in_cartesian_mode
            if cartesian
            else parameters.halt_all_joints_in_joint_mode
        )
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
            coasting + share * velocity * period * (2 + self._cycles_to_look)
        )
        self._factor, self._collision = self._proximity.factor(q, self.target.complete(ahead))
        return self._factor

    def _forget_collisions(self) -> None:
        self._factor = 1.0
        self._collision = None
        self._cycles_to_look = 0
