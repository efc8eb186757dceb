# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A hardware interface with the joints of several robots, seen by each robot's controllers."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.control.hardware_interface import (
    COMMAND_INTERFACES,
    HardwareInterface,
    JointArrays,
)
from armsim_ros.errors import SimulationError


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
                f'({", ".join(whole.joint_names)})'
            )
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
