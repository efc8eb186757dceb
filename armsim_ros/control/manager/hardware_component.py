# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot's hardware as ros2_control sees it: components, each with a state of its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.manager_info import interface_infos, InterfaceInfo
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import HardwareSystem, RobotModel


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
    One component; it starts active.

    :param system: what the URDF declares; None stands for all joints of a robot.
    """

    def __init__(self, name: str, system: HardwareSystem | None = None) -> None:
        self.name = name
        self.system = system
        self.state = LifecycleState.ACTIVE

    @property
    def active(self) -> bool:
        """Whether commands reach its joints."""
        return self.state is LifecycleState.ACTIVE

    def has(self, owner: str) -> bool:
        """Return whether a joint, sensor or gpio belongs to it."""
        if self.system is None:
            return True
        names = (*self.system.other_states, *self.system.other_commands)
        return any(joint.name == owner for joint in self.system.joints) or any(
            name.rpartition('/')[0] == owner for name in names)

    def set_state(self, state: str, users: Sequence[str]) -> None:
        """
        Change the state; steps in between are taken by themselves.

        :param users: names of active controllers that command its joints.
        :raises ControllerError: an unknown state, or there are users.
        """
        allowed = [one.value for one in LifecycleState]
        if state not in allowed:
            raise ControllerError(f"'{state}' is no state; allowed: {', '.join(allowed)}")
        if state != LifecycleState.ACTIVE.value and users:
            raise ControllerError(
                f"hardware '{self.name}' cannot become {state}: {', '.join(users)} command it; "
                'deactivate them first'
            )
        if self.state is LifecycleState.FINALIZED and state != self.state.value:
            raise ControllerError(f"hardware '{self.name}' is finalized and stays so")
        self.state = LifecycleState(state)


class Hardware:
    """
    All components of a robot: those that its URDF declares, else one with all joints.

    :param model: gives names and declarations; without it the one component is ``hardware``.
    """

    def __init__(self, hardware: HardwareInterface, model: RobotModel | None) -> None:
        self._hardware = hardware
        self.systems = model.hardware if model is not None else ()
        name = model.name if model is not None and model.name else 'hardware'
        self.components = (tuple(HardwareComponent(one.name, one) for one in self.systems)
                           or (HardwareComponent(name),))

    def idle_owner(self, interfaces: Iterable[str]) -> HardwareComponent | None:
        """Return a component that is not active and has one of the interfaces, None else."""
        owners = {interface.rpartition('/')[0] for interface in interfaces}
        return next((one for one in self.components if not one.active
                     and (one.system is None or any(map(one.has, owners)))), None)

    def set_state(self, name: str, state: str, controllers: Iterable[Controller[Any]]) -> None:
        """
        Change the state of one component.

        :param controllers: the active ones, of which those that command it keep it active.
        :raises ControllerError: an unknown name or state, or active controllers need it.
        """
        known = {one.name: one for one in self.components}
        if name not in known:
            hint = nearest(name, tuple(known)) or f'known: {", ".join(known)}'
            raise ControllerError(f"no hardware component '{name}'; {hint}")
        users = [one.name for one in controllers
                 if any(known[name].has(interface.rpartition('/')[0])
                        for interface in one.required_command_interfaces)]
        known[name].set_state(state, users)

    def interfaces(self, controllers: Iterable[Controller[Any]]
                   ) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
        """Return command interfaces and state interfaces, as ``joint/interface``."""
        owners = {*self._hardware.joint_names,
                  *(name.rpartition('/')[0] for one in self.systems
                    for name in (*one.other_states, *one.other_commands))}
        resting = [one for one in self.components if not one.active]
        idle = {owner for owner in owners if any(one.has(owner) for one in resting)}
        return interface_infos(self._hardware, controllers, self.systems, idle)

    def info(self) -> list[HardwareComponentInfo]:
        """Return what there is to tell about each component."""
        kind = self._hardware.__class__
        own = f'{kind.__module__.partition(".")[0]}/{kind.__qualname__}'
        command, state = self.interfaces(())
        return [HardwareComponentInfo(
            one.name,
            one.system.type if one.system is not None else 'system',
            one.system.plugin if one.system is not None else own,
            one.state.value,
            tuple(info for info in command if one.has(info.name.rpartition('/')[0])),
            tuple(info for info in state if one.has(info.name.rpartition('/')[0])),
        ) for one in self.components]
