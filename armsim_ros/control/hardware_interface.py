# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What controllers see of the joints: states to read, commands to write, properties."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.model.robot_model import JointType, RobotModel

POSITION = 'position'
VELOCITY = 'velocity'
ACCELERATION = 'acceleration'
EFFORT = 'effort'
COMMAND_INTERFACES = (POSITION, VELOCITY, ACCELERATION, EFFORT)


@dataclass(frozen=True, slots=True, eq=False)
class JointArrays:
    """
    A value per joint and interface, changed in place; NaN where there is none.

    :param position: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s].
    :param acceleration: (n,) [rad/s^2 or m/s^2].
    :param effort: (n,) [N*m or N].
    """

    position: Vector
    velocity: Vector
    acceleration: Vector
    effort: Vector

    @classmethod
    def filled(cls, count: int, value: float = np.nan) -> JointArrays:
        """Return arrays of length ``count``, each value ``value``."""
        return cls(*(np.full(count, value) for _ in range(4)))

    def of(self, interface: str) -> Vector:
        """Return the array of an interface by its name."""
        values: Vector = getattr(self, interface)
        return values


class UpdatePlan:
    """
    Position commands of updates ahead, from controllers that know them.

    :param position: (k, n) commands of each update [rad or m].
    :param velocity: (k, n) feed-forward that belongs to them [rad/s or m/s].
    :param acceleration: (k, n) the same [rad/s^2 or m/s^2].
    :param expected: (k, n) where the joints should be at each update [rad or m].
    :param weights: (n,) where the squares of these times the distances from ``expected`` add up
        to 1 or more, the updates from there on are not as planned.
    """

    __slots__ = ('acceleration', 'expected', 'position', 'velocity', 'weights')

    def __init__(
        self,
        position: Matrix,
        velocity: Matrix,
        acceleration: Matrix,
        expected: Matrix,
        weights: Vector,
    ) -> None:
        self.position, self.velocity, self.acceleration = position, velocity, acceleration
        self.expected, self.weights = expected, weights

    @classmethod
    def empty(cls, updates: int, joints: int) -> UpdatePlan:
        """Return a plan with room for so many updates."""
        tables = np.zeros((4, updates, joints))
        return cls(tables[0], tables[1], tables[2], tables[3], np.zeros(joints))

    def __len__(self) -> int:
        """Return for how many updates there is room."""
        return len(self.position)

    def window(self, place: slice) -> UpdatePlan:
        """Return the part of some joints."""
        return UpdatePlan(
            self.position[:, place],
            self.velocity[:, place],
            self.acceleration[:, place],
            self.expected[:, place],
            self.weights[place],
        )

    def begin(self, command: JointArrays, feedforward: JointArrays) -> None:
        """Forget what was planned: the present commands stay in effect."""
        self.position[:] = command.position
        self.velocity[:], self.acceleration[:] = feedforward.velocity, feedforward.acceleration
        self.expected[:] = 0.0
        self.weights[:] = 0.0


class HardwareInterface(ABC):
    """
    The joints of a robot.

    ``state`` is refreshed before the controllers run; ``command`` is read after them. A
    position command is where the joint shall be a control period later; ``feedforward``
    (velocity, acceleration) may be given with it for the motion there, NaN where the
    controller gives none. ``plan`` takes position commands of the periods ahead from
    controllers that know them; it has no room where the hardware has no use for them.
    ``effort_bound`` is what a drive may give at most, beside its own limit [N*m or N].

    :param joint_names: (n,) all movable joints, mimic ones too; the order of all arrays.
    """

    def __init__(self, joint_names: tuple[str, ...]) -> None:
        """Make arrays for the joints; all commands are NaN (none)."""
        self.joint_names = joint_names
        self.index = {name: i for i, name in enumerate(joint_names)}
        self.state = JointArrays.filled(len(joint_names), 0.0)
        self.command = JointArrays.filled(len(joint_names))
        self.feedforward = JointArrays.filled(len(joint_names))
        self.effort_bound = np.full(len(joint_names), np.inf)
        self.plan = UpdatePlan.empty(0, len(joint_names))
        #: Command interface of a sensor or gpio -> the last command, NaN before the first.
        self.other_commands: dict[str, float] = {}
        #: Reference of a chainable controller, as ``controller/joint/interface`` -> the last
        #: value that a preceding controller wrote, NaN before the first.
        self.references: dict[str, float] = {}
        #: Joints that devices of a controller manager may command, whatever is declared.
        self.device_joints: set[str] = set()
        #: Joints whose drives add what holds them against gravity to efforts.
        self.gravity_compensated: frozenset[str] = frozenset()
        #: Other states that controllers set, such as the pace of trajectories -> value.
        self.given_states: dict[str, float] = {}
        #: The same of each robot that shares this hardware; the others do not see them.
        self.given_states_of_parts: list[dict[str, float]] = []

    @property
    @abstractmethod
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be claimed; a mimic joint has none."""

    @property
    @abstractmethod
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be read."""

    @property
    def sensor_links(self) -> Mapping[str, str]:
        """Sensor of forces and torques -> the link on which it sits."""
        return {}

    @property
    def other_states(self) -> Mapping[str, float]:
        """Interface of a sensor or gpio -> its value."""
        return self.given_states

    @property
    def resting(self) -> bool:
        """Whether no drive moves its joint, as far as that is known."""
        return False

    def commands_of(self, owner: str) -> tuple[str, ...]:
        """Return what a joint, sensor, gpio or controller's joint can be commanded by."""
        others = (*self.other_commands, *self.references)
        return self.command_interfaces.get(owner) or _kinds_of(owner, others)

    def store_of(self, interface: str) -> dict[str, float]:
        """Return where the commands of what is not a joint are kept."""
        return self.references if interface in self.references else self.other_commands

    def states_of(self, owner: str) -> tuple[str, ...]:
        """Return what can be read of a joint, sensor or gpio."""
        return self.state_interfaces.get(owner) or _kinds_of(owner, self.other_states)

    @abstractmethod
    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Take over a change of claims.

        :param claimed: joint -> interfaces claimed from now on; a joint that is not there is
            unclaimed and holds its position.
        :raises SimulationError: a set of interfaces that the joint cannot follow together.
        """

    def tare(self, foreign: Collection[str] = ()) -> None:  # noqa: B027 - optional
        """
        Have the forces and torques that sensors measure now read as 0 from now on.

        :param foreign: sensors that are left alone.
        """

    def set_payload(self, link: str, mass: float, centre: Sequence[float]) -> None:  # noqa: B027
        """
        Have the drives compensate a load that a client believes to be at a link.

        :param mass: [kg].
        :param centre: (3,) of mass, in the axes of the link [m].
        """

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:  # noqa: B027 - optional
        """
        Take over gains of position commands; hardware without drives of its own has no use.

        :param gains: joint -> gains that have changed.
        """


def _kinds_of(owner: str, interfaces: Iterable[str]) -> tuple[str, ...]:
    parts = (name.rpartition('/') for name in interfaces)
    return tuple(kind for name, _, kind in parts if name == owner)


@dataclass(frozen=True, slots=True, eq=False)
class JointProperties:
    """
    Types and limits of n joints; infinite limits where nothing is known.

    :param names: (n,).
    :param continuous: indices of the joints that turn without end.
    :param lower: (n,) [rad or m].
    :param upper: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s]; a URDF's 0 is no limit.
    :param units: (n,) ``rad`` or ``m``, '' where nothing is known.
    """

    names: tuple[str, ...]
    continuous: NDArray[np.intp]
    lower: Vector
    upper: Vector
    velocity: Vector
    units: tuple[str, ...]

    @classmethod
    def of(cls, names: Sequence[str], model: RobotModel | None) -> JointProperties:
        """Look the joints up; without a model, or for a joint that it lacks, nothing is known."""
        known = model.joints if model is not None else {}
        joints = [known.get(name) for name in names]
        turning = [
            i for i, j in enumerate(joints) if j is not None and j.type is JointType.CONTINUOUS
        ]
        lower, upper, velocity = (np.full(len(names), s * np.inf) for s in (-1.0, 1.0, 1.0))
        units = []
        for i, joint in enumerate(joints):
            if joint is None:
                units.append('')
                continue
            velocity[i] = joint.limits.velocity or np.inf
            units.append('m' if joint.type is JointType.PRISMATIC else 'rad')
            if i not in turning:
                lower[i], upper[i] = joint.limits.lower, joint.limits.upper
        return cls(
            tuple(names), np.array(turning, dtype=np.intp), lower, upper, velocity, tuple(units)
        )
