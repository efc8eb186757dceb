# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot's hardware as ros2_control sees it: one component with a state of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from armsim_ros.control.controller import LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager_info import interface_infos, InterfaceInfo
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel


@dataclass(frozen=True, slots=True)
class HardwareComponentInfo:
    """One hardware component."""

    name: str
    type: str
    plugin_name: str
    state: str
    command_interfaces: tuple[InterfaceInfo, ...]
    state_interfaces: tuple[InterfaceInfo, ...]


class HardwareComponent:
    """
    All joints of a robot, as a component of type ``system`` that starts active.

    :param model: gives the name; without it the name is ``hardware``.
    """

    def __init__(self, hardware: HardwareInterface, model: RobotModel | None) -> None:
        """Start active."""
        self.name = model.name if model is not None and model.name else 'hardware'
        self.state = LifecycleState.ACTIVE
        self._hardware = hardware

    @property
    def active(self) -> bool:
        """Whether commands reach the joints."""
        return self.state is LifecycleState.ACTIVE

    def set_state(self, name: str, state: str, users: Sequence[str]) -> None:
        """
        Change the state; steps in between are taken by themselves.

        :param users: names of active controllers that command the joints.
        :raises ControllerError: another name, an unknown state, or there are users.
        """
        if name != self.name:
            raise ControllerError(f"no hardware component '{name}'; known: {self.name}")
        allowed = [one.value for one in LifecycleState]
        if state not in allowed:
            raise ControllerError(f"'{state}' is no state; allowed: {', '.join(allowed)}")
        if state != LifecycleState.ACTIVE.value and users:
            raise ControllerError(
                f"hardware '{name}' cannot become {state}: {', '.join(users)} command it; "
                'deactivate them first'
            )
        if self.state is LifecycleState.FINALIZED and state != self.state.value:
            raise ControllerError(f"hardware '{name}' is finalized and stays so")
        self.state = LifecycleState(state)

    def info(self) -> HardwareComponentInfo:
        """Return what there is to tell about the component."""
        command, state = interface_infos(self._hardware, (), self.active)
        kind = self._hardware.__class__
        return HardwareComponentInfo(
            self.name,
            'system',
            f'{kind.__module__.partition(".")[0]}/{kind.__qualname__}',
            self.state.value,
            tuple(command),
            tuple(state),
        )
