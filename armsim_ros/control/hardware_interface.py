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
from armsim_ros.errors import SimulationError
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
        self, position: Matrix, velocity: Matrix, acceleration: Matrix, expected: Matrix,
        weights: Vector
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
            self.position[:, place], self.velocity[:, place], self.acceleration[:, place],
            self.expected[:, place], self.weights[place])

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
        self._motions = {
            f'{name}/{kind}': (name, kind) for name in joint_names for kind in COMMAND_INTERFACES}
        self.state = JointArrays.filled(len(joint_names), 0.0)
        self.command = JointArrays.filled(len(joint_names))
        self.feedforward = JointArrays.filled(len(joint_names))
        self.effort_bound = np.full(len(joint_names), np.inf)
        self.plan = UpdatePlan.empty(0, len(joint_names))
        #: Command interface of a sensor or gpio, or one beside a joint's motion -> the last
        #: command, NaN before the first.
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
        """Interface of a sensor or gpio, or one beside a joint's motion -> its value."""
        return self.given_states

    @property
    def resting(self) -> bool:
        """Whether no drive moves its joint, as far as that is known."""
        return False

    def commands_of(self, owner: str) -> tuple[str, ...]:
        """Return what a joint, sensor, gpio or controller's joint can be commanded by."""
        others = (*self.other_commands, *self.references)
        return (*self.command_interfaces.get(owner, ()), *_kinds_of(owner, others))

    def motion_of(self, interface: str) -> tuple[str, str] | None:
        """Return joint and kind of an interface of a joint's motion, None of any other."""
        return self._motions.get(interface)

    def store_of(self, interface: str) -> dict[str, float]:
        """Return where commands are kept that are not of a joint's motion."""
        return self.references if interface in self.references else self.other_commands

    def states_of(self, owner: str) -> tuple[str, ...]:
        """Return what can be read of a joint, sensor or gpio."""
        return (*self.state_interfaces.get(owner, ()), *_kinds_of(owner, self.other_states))

    def read_states(self, interfaces: Iterable[str]) -> Vector:
        """
        Return the value of each state interface (m,), NaN for those whose name is ''.

        :raises KeyError: an interface that is not there.
        """
        others: Mapping[str, float] | None = None
        values = []
        for interface in interfaces:
            if motion := self.motion_of(interface):
                joint, kind = motion
                values.append(self.state.of(kind)[self.index[joint]])
            elif interface:
                others = self.other_states if others is None else others  # sensors are computed
                values.append(others[interface])
            else:
                values.append(np.nan)
        return np.array(values)

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
            i for i, j in enumerate(joints) if j is not None and j.type is JointType.CONTINUOUS]
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
            tuple(names), np.array(turning, dtype=np.intp), lower, upper, velocity, tuple(units))


class SharedHardware:
    """
    Hands out the joints of robots, and keeps together what they claim.

    :param hardware: has the joints of all robots.
    """

    def __init__(self, hardware: HardwareInterface) -> None:
        self.hardware = hardware
        self._claims: dict[str, frozenset[str]] = {}

    def part(self, joint_names: Sequence[str], foreign: Collection[str] = ()) -> HardwarePart:
        """
        Return the view of a robot.

        :param joint_names: movable joints that follow each other in the hardware.
        :param foreign: sensors and gpios of the other robots, which this robot neither shows nor
            commands.
        :raises SimulationError: they do not.
        """
        return HardwarePart(self, tuple(joint_names), frozenset(foreign))

    def claim(self, joint_names: Sequence[str], claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Change what a robot claims; the others keep their claims.

        :raises SimulationError: as :meth:`HardwareInterface.perform_command_mode_switch`.
        """
        claims = {name: claim for name, claim in self._claims.items() if name not in joint_names}
        claims.update(claimed)
        self.hardware.perform_command_mode_switch(claims)
        self._claims = claims


class HardwarePart(HardwareInterface):
    """
    The joints of a robot; its arrays are windows into those of the whole.

    :param shared: the whole.
    :param joint_names: (n,) movable joints that follow each other in it.
    :param foreign: sensors and gpios of the other robots.
    """

    def __init__(
        self, shared: SharedHardware, joint_names: tuple[str, ...], foreign: frozenset[str]
    ) -> None:
        super().__init__(joint_names)
        self._foreign = foreign
        whole = shared.hardware
        start = whole.index.get(joint_names[0], 0) if joint_names else 0
        place = slice(start, start + len(joint_names))
        if whole.joint_names[place] != joint_names:
            raise SimulationError(
                f'the joints {", ".join(joint_names)} do not follow each other in the hardware '
                f'({", ".join(whole.joint_names)})')
        self.state = _window(whole.state, place)
        self.command = _window(whole.command, place)
        self.feedforward = _window(whole.feedforward, place)
        self.effort_bound = whole.effort_bound[place]
        self.plan = whole.plan.window(place)
        self.other_commands = whole.other_commands
        self.device_joints = whole.device_joints
        self.gravity_compensated = whole.gravity_compensated.intersection(joint_names)
        whole.given_states_of_parts.append(self.given_states)
        self._shared = shared
        self._command_interfaces = {name: whole.command_interfaces[name] for name in joint_names}
        self._state_interfaces = {name: whole.state_interfaces[name] for name in joint_names}

    @property
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be claimed, of the robot's joints."""
        return self._command_interfaces

    @property
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be read, of the robot's joints."""
        return self._state_interfaces

    @property
    def other_states(self) -> Mapping[str, float]:
        """Interface of a sensor or gpio -> its value, but for those of the other robots."""
        shown = {name: value for name, value in self._shared.hardware.other_states.items()
                 if name.rpartition('/')[0] not in self._foreign}
        return {**shown, **self.given_states}

    @property
    def sensor_links(self) -> Mapping[str, str]:
        """Sensor of forces and torques -> its link, but for those of the other robots."""
        return {name: link for name, link in self._shared.hardware.sensor_links.items()
                if name not in self._foreign}

    @property
    def resting(self) -> bool:
        """Whether no drive moves its joint, of any part."""
        return self._shared.hardware.resting

    def commands_of(self, owner: str) -> tuple[str, ...]:
        """Return what a joint, sensor, gpio or controller's joint of the robot can do."""
        return () if owner in self._foreign else super().commands_of(owner)

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """Take over a change of claims of this robot."""
        self._shared.claim(self.joint_names, claimed)

    def tare(self, foreign: Collection[str] = ()) -> None:
        """Zero the sensors of this robot."""
        self._shared.hardware.tare({*self._foreign, *foreign})

    def set_payload(self, link: str, mass: float, centre: Sequence[float]) -> None:
        """Pass a load on."""
        self._shared.hardware.set_payload(link, mass, centre)

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:
        """Pass gains on."""
        self._shared.hardware.set_gains(gains)


def _window(arrays: JointArrays, place: slice) -> JointArrays:
    return JointArrays(*(arrays.of(name)[place] for name in COMMAND_INTERFACES))
