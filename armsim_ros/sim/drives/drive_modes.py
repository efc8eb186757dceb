# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the drive of a joint follows, by claims and mock hardware, and its gains as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    JointArrays,
    POSITION,
    VELOCITY,
)
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import HardwareJoint, RobotModel

#: While the reference moves, the damping follows the joints' inertias so often [steps].
TUNING_STEPS = 20
#: The default p is at least so many times the robot's weight on the joint, per radian or metre.
WEIGHT_SHARE = 5.0


class DriveGains:
    """
    What each drive makes of its error: p, i, d, the bounds of the integral part.

    The simulation's own gains win over a controller's; a block without any gain counts as none.

    :param joint_names: (n,) the driven joints.
    :param settings: timestep, integrator, servo.
    :param gains: joint -> gains of its controller.
    :param weights: (n,) the robot's greatest weight on each joint [N*m or N].
    """

    def __init__(
        self, joint_names: tuple[str, ...], settings: SimulationSettings,
        gains: Mapping[str, PidGains], weights: Vector
    ) -> None:
        self._joint_names, self._settings = joint_names, settings
        self._weights = dict(zip(joint_names, weights.tolist(), strict=True))
        self._given = dict(gains)
        self._factor = 1.0
        #: Whether the integrator takes the derivative part at the end of its step.
        self.implicit = settings.integrator != 'euler'
        self.change({})

    def scale(self, factor: float) -> None:
        """Have p, i and d multiplied by a factor."""
        self._factor = factor
        self.change({})

    def change(self, gains: Mapping[str, PidGains]) -> None:
        """Take over what a controller gives anew for some of its joints."""
        self._given.update(gains)
        chosen = [self._chosen(name) for name in self._joint_names]
        self.p = np.array([block.p for block in chosen], dtype=np.float64)
        self.i = np.array([block.i for block in chosen], dtype=np.float64)
        self.d = np.array([block.d for block in chosen], dtype=np.float64)
        if self._factor != 1.0:
            for values in (self.p, self.i, self.d):
                values *= self._factor
        self._springs = np.maximum(self.p, 0.0)
        bounds = np.array([block.integral_bounds for block in chosen], dtype=np.float64)
        self.integral_low, self.integral_high = bounds.reshape(-1, 2).T
        wound = (self.i != 0.0) & (self.integral_low < self.integral_high)
        self.integrate = bool(wound.any())

    def damping(self, inertias: Matrix) -> Matrix:
        """
        Return d, raised to the damping ratio asked for (k, n).

        :param inertias: (k, n) of each joint by itself, at some times [kg*m^2 or kg].
        """
        ratio = self._settings.servo.damping_ratio
        if ratio == 0.0:
            return np.broadcast_to(self.d, inertias.shape)
        requested = 2.0 * ratio * np.sqrt(self._springs * inertias)
        raised: Matrix = np.maximum(
            self.d, np.minimum(requested, inertias / self._settings.timestep))
        return raised

    def stiffness_warnings(self, inertia: Vector) -> list[str]:
        """
        Return a line for each joint whose gains are too high for the timestep.

        :param inertia: (n,) of each joint by itself [kg*m^2 or kg].
        """
        h = self._settings.timestep
        stable_p = (inertia + (0.5 * h * self.d if self.implicit else 0.0)) / h**2
        stable_d = np.full_like(inertia, np.inf) if self.implicit else 2.0 * inertia / h
        lines = []
        for i, name in enumerate(self._joint_names):
            if self.p[i] > stable_p[i] or self.d[i] > stable_d[i]:
                allowed = f'p below {stable_p[i]:.3g}'
                if not self.implicit:
                    allowed += f' and d below {stable_d[i]:.3g}'
                lines.append(
                    f"the gains of joint '{name}' (p {self.p[i]:g}, d {self.d[i]:g}) are too "
                    f'high for a timestep of {h:g} s and an inertia of {inertia[i]:.3g}; stable: '
                    f'{allowed}')
        return lines

    def _chosen(self, name: str) -> PidGains:
        servo = self._settings.servo
        block = servo.gains.get(name) or self._given.get(name)
        if block is None or not (block.p or block.i or block.d):
            block = servo.default_gains
            if 'default_gains' not in servo.model_fields_set:
                # A heavy robot that was disturbed would fall.
                least = WEIGHT_SHARE * self._weights[name]
                block = block.model_copy(update={'p': max(block.p, least)})
        return block


def count_moving(velocities: Matrix, count: int, steps: int) -> tuple[list[int], list[int]]:
    """
    Count the steps that move a joint since the actuators' gains were set.

    :param velocities: (k, n) in each step [rad/s or m/s].
    :param count: such steps before the first of them.
    :param steps: in a control period; only between periods gains are set.
    :returns: (k + 1,) the count before each step and after the last, as if gains were not set
        any more, and the steps before which they have to be.
    """
    moving = (velocities.T.copy() != 0.0).any(axis=0)
    counts = list(accumulate(moving.tolist(), initial=count))
    before, tuned = 0, []
    for row in range(steps, len(moving), steps):
        if counts[row] - before >= TUNING_STEPS:
            tuned.append(row)
            before = counts[row]
    return counts, tuned


_FOLLOWING = (POSITION, VELOCITY, ACCELERATION)
_DRIVEN = (*_FOLLOWING, EFFORT)


def offered_commands(model: RobotModel, joint: str) -> tuple[str, ...]:
    """Return what a joint can be commanded by: what its hardware declares, else everything."""
    if not model.joints[joint].active:
        return ()
    if not model.hardware:
        return COMMAND_INTERFACES
    declared = model.hardware_joints.get(joint, HardwareJoint(joint)).commands
    return tuple(kind for kind in declared if kind in COMMAND_INTERFACES)


def offered_states(model: RobotModel, joint: str) -> tuple[str, ...]:
    """Return what can be read of a joint: what its hardware declares, else everything."""
    measured = _DRIVEN if model.joints[joint].active else _FOLLOWING
    if not model.hardware:
        return measured
    declared = model.hardware_joints.get(joint, HardwareJoint(joint)).states
    return tuple(kind for kind in declared if kind in measured)


@dataclass(frozen=True, slots=True, eq=False)
class MockCommands:
    """
    Commands that are shifted, or that do not arrive.

    :param deaf: (m,) which drives get none, so that they hold.
    :param offset: (m,) added to positions [rad or m].
    """

    deaf: NDArray[np.bool_]
    offset: Vector

    @classmethod
    def of(cls, model: RobotModel) -> MockCommands | None:
        """Return those that the robot's hardware asks for, None where all arrive as they are."""
        if not any(system.deaf or system.offset for system in model.hardware):
            return None
        joints = {joint.name: system for system in model.hardware for joint in system.joints}
        systems = [joints.get(name) for name in model.active_joints]
        return cls(np.array([system is not None and system.deaf for system in systems]),
                   np.array([system.offset if system is not None else 0.0 for system in systems]))

    def arriving(self, given: JointArrays) -> JointArrays:
        """Return what arrives of commands, or of their feed-forward (m,)."""
        arrays = JointArrays(*(np.where(self.deaf, np.nan, given.of(kind))
                               for kind in COMMAND_INTERFACES))
        arrays.position[:] += self.offset
        return arrays


class Mode(IntEnum):
    """What a drive follows."""

    HOLD = 0
    POSITION = 1
    VELOCITY = 2
    EFFORT = 3


#: Interfaces that can be claimed together, and what the drive then follows.
MODES: dict[frozenset[str], Mode] = {
    frozenset(): Mode.HOLD,
    frozenset({POSITION}): Mode.POSITION,
    frozenset({POSITION, VELOCITY}): Mode.POSITION,
    frozenset({POSITION, VELOCITY, ACCELERATION}): Mode.POSITION,
    frozenset({POSITION, EFFORT}): Mode.POSITION,
    frozenset({VELOCITY}): Mode.VELOCITY,
    frozenset({EFFORT}): Mode.EFFORT,
}


def mode_of(joint: str, claim: frozenset[str]) -> Mode:
    """
    Return what a joint's drive follows.

    :param claim: interfaces that are claimed of it.
    :raises SimulationError: they cannot be followed together.
    """
    if claim in MODES:
        return MODES[claim]
    legal = ', '.join(
        '[' + ', '.join(name for name in COMMAND_INTERFACES if name in option) + ']'
        for option in MODES
        if option)
    names = ', '.join(sorted(claim))
    raise SimulationError(f"joint '{joint}' cannot follow [{names}] together; allowed: {legal}")


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """
    What the drives of n joints follow.

    :param claims: (n,) claimed interfaces.
    :param position: (n,) those that follow positions; ``velocity`` and ``effort`` likewise.
    :param velocity_given: (n,) whose velocities are claimed, beside positions or alone.
    :param effort_added: (n,) whose effort adds to the torque of following positions.
    :param only_positions: whether all follow positions.
    :param only_references: whether nothing but positions is claimed, so that what else is known
        of the reference comes as feed-forward.
    """

    claims: tuple[frozenset[str], ...]
    position: Mask
    velocity: Mask
    effort: Mask
    velocity_given: Mask
    effort_added: Mask
    only_positions: bool
    only_references: bool

    @classmethod
    def of(cls, joints: Sequence[str], claimed: Mapping[str, frozenset[str]]) -> Followed:
        """
        Return what the drives of joints follow; an unclaimed joint holds.

        :raises SimulationError: interfaces that cannot be followed together.
        """
        claims = tuple(claimed.get(name, frozenset()) for name in joints)
        modes = np.array([mode_of(*pair) for pair in zip(joints, claims, strict=True)],
                         dtype=np.int64)
        position = modes == Mode.POSITION
        velocity_given = np.array([VELOCITY in claim for claim in claims], dtype=np.bool_)
        effort_added = np.array([claim == {POSITION, EFFORT} for claim in claims], dtype=np.bool_)
        return cls(
            claims, position, modes == Mode.VELOCITY, modes == Mode.EFFORT, velocity_given,
            effort_added, bool(position.all()), bool(position.all() and not velocity_given.any()))

    def references(
        self, command: JointArrays, feedforward: JointArrays, target: Vector, steps: int
    ) -> tuple[Vector, Vector, Vector]:
        """
        Return positions, velocities and accelerations at the end of a period, NaN where not known.

        :param target: (n,) for joints without a position command [rad or m].
        :param steps: physics steps in the period; for a single one only the position counts.
        """
        requested, follows = command.position, self.position
        if self.only_positions and float(requested.dot(requested)) < np.inf:
            target = requested.copy()
            if self.only_references:
                return target, feedforward.velocity, feedforward.acceleration
        else:
            follows = follows & np.isfinite(requested)
            target = np.where(follows, requested, target)
        if steps == 1:
            return target, feedforward.velocity, feedforward.acceleration
        velocity, acceleration = (
            np.where(follows, np.where(self.velocity_given, given, known), np.nan)
            for given, known in ((command.velocity, feedforward.velocity),
                                 (command.acceleration, feedforward.acceleration)))
        return target, velocity, acceleration

    def changed(self, other: Followed) -> Mask:
        """Return which joints (n,) have other claims than there."""
        pairs = zip(self.claims, other.claims, strict=True)
        return np.array([first != two for first, two in pairs], dtype=np.bool_)
