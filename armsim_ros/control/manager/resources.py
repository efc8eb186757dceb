# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot's hardware as ros2_control presents it: components, each with a state of its own."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, HardwareInterface
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.control.manager.command_limits import CommandLimits
from armsim_ros.control.manager.manager_info import interface_infos, InterfaceInfo
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import HardwareSystem, RobotModel

_CONFIGURED = (LifecycleState.INACTIVE, LifecycleState.ACTIVE)


@dataclass(frozen=True, slots=True)
class HardwareComponentInfo:
    """A hardware component."""

    name: str
    type: str
    plugin_name: str
    state: str
    command_interfaces: tuple[InterfaceInfo, ...]
    state_interfaces: tuple[InterfaceInfo, ...]


class HardwareComponent:
    """
    A component; it starts active.

    :param system: what the URDF declares; None means all joints of a robot.
    """

    def __init__(self, name: str, system: HardwareSystem | None = None) -> None:
        self.name, self.system = name, system
        self.state = LifecycleState.ACTIVE

    @property
    def active(self) -> bool:
        """Whether commands reach its joints."""
        return self.state is LifecycleState.ACTIVE

    @property
    def configured(self) -> bool:
        """Whether its interfaces are available."""
        return self.state in _CONFIGURED

    def has(self, owner: str) -> bool:
        """Return whether a joint, sensor or gpio belongs to it."""
        if self.system is None:
            return True
        names = (*self.system.other_states, *self.system.other_commands)
        return any(joint.name == owner for joint in self.system.joints) or any(
            name.rpartition('/')[0] == owner for name in names)

    def set_state(self, state: str) -> None:
        """
        Change the state; steps in between are taken without being asked for.

        :raises ControllerError: an unknown state, or the component is finalized.
        """
        allowed = [member.value for member in LifecycleState]
        if state not in allowed:
            raise ControllerError(f"'{state}' is not a state; allowed: {', '.join(allowed)}")
        if self.state is LifecycleState.FINALIZED and state != self.state.value:
            raise ControllerError(f"hardware '{self.name}' is finalized, which is permanent")
        self.state = LifecycleState(state)


class Resources:
    """
    All components of a robot: those that its URDF declares, else a component with all joints.

    :param model: gives names and declarations; without it the only component is ``hardware``.
    :param parameters: in which state components start, what inactive ones allow, and whether
        commands are limited.
    :param events: get a warning of each component that the parameters name and nothing declares.
    """

    def __init__(
        self, hardware: HardwareInterface, model: RobotModel | None,
        parameters: ControllerManagerParameters, events: EventQueue
    ) -> None:
        self.hardware = hardware
        self.systems = model.hardware if model is not None else ()
        name = model.name if model is not None and model.name else 'hardware'
        self.components = (tuple(HardwareComponent(system.name, system) for system in self.systems)
                           or (HardwareComponent(name),))
        self._allow_inactive = (
            parameters.defaults.allow_controller_activation_with_inactive_hardware)
        #: What limits the commands; None where nothing does.
        self.limits = (CommandLimits(hardware, model) if parameters.enforce_command_limits
                       else None)
        #: Joints of an arm that is stopped: no controller has them.
        self.halted: frozenset[str] = frozenset()
        self._held: tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]] | None = None
        #: Command of a gpio of hardware that is not active -> the last value that reached it.
        self._held_others: dict[str, float] = {}
        initial = parameters.hardware_components_initial_state
        for state, names in (('unconfigured', initial.unconfigured),
                             ('inactive', initial.inactive)):
            for name in filter(None, names):
                try:
                    self.set_state(name, state)
                except ControllerError as error:
                    events.warn(0, f'hardware_components_initial_state.{state}: {error}')

    @property
    def idle_joints(self) -> frozenset[str]:
        """Joints that follow no controller: idle hardware, or a stopped arm."""
        idle = [component for component in self.components if not component.active]
        if not idle:
            return self.halted
        return self.halted | frozenset(name for name in self.hardware.joint_names
                         if any(component.has(name) for component in idle))

    @property
    def holds(self) -> bool:
        """Whether there are such joints, or gpios."""
        return self._held is not None or bool(self._held_others)

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Have the hardware follow other interfaces; commands are limited from where it is now.

        :param claimed: joint -> the interfaces that it follows.
        :raises ArmsimError: the hardware refuses them.
        """
        self.hardware.perform_command_mode_switch(claimed)
        self._reset_limits()

    def hold_idle_joints(self) -> None:
        """Let no command reach hardware that is not active; once per update."""
        self.hardware.other_commands.update(self._held_others)
        if self._held is None:
            return
        places, positions = self._held
        for kind in COMMAND_INTERFACES:
            self.hardware.command.of(kind)[places] = np.nan
            self.hardware.feedforward.of(kind)[places] = np.nan
        self.hardware.command.position[places] = positions

    def set_state(self, name: str, state: str) -> None:
        """
        Change the state of a component, whichever controllers use it.

        :raises ControllerError: an unknown name or state.
        """
        known = {component.name: component for component in self.components}
        if name not in known:
            hint = nearest(name, tuple(known)) or f'known: {", ".join(known)}'
            raise ControllerError(f"no hardware component '{name}'; {hint}")
        known[name].set_state(state)
        self._hold(self._held_positions())

    def restart(self) -> None:
        """Hold idle joints, and limit commands, from the states that are measured now."""
        self._hold({})
        self._reset_limits()

    def inactive_owner(self, interfaces: Iterable[str]) -> str:
        """Return an inactive component that keeps a controller of these commands from starting."""
        if self._allow_inactive:
            return ''
        owners = {name.rpartition('/')[0] for name in interfaces
                  if name not in self.hardware.references}
        return next((component.name for component in self.components
                     if component.state is LifecycleState.INACTIVE
                     and any(map(component.has, owners))), '')

    def lack_of(self, controller: Controller[Any], active: Collection[str]) -> str:
        """
        Return which interface of a controller is not available, '' where all are.

        :param active: names of the controllers whose references and exported states count.
        """
        hardware = self.hardware
        for kind, required, offered in (
            ('command', controller.required_command_interfaces, cache(hardware.commands_of)),
            ('state', controller.required_state_interfaces, cache(hardware.states_of)),
        ):
            for interface in required:
                owner, _, quantity = interface.rpartition('/')
                need = f"'{controller.name}' needs the {kind} interface {interface}, which "
                if quantity not in offered(owner):
                    known = ', '.join(f'{owner}/{existing}'
                                      for existing in offered(owner)) or 'none'
                    return f"{need}does not exist; '{owner}' has: {known}"
                if interface in hardware.references and owner.partition('/')[0] not in active:
                    return f'{need}is not available: its controller is not active'
                idle = next((component for component in self.components
                             if not component.configured and component.has(owner)), None)
                if idle is not None and not (kind == 'state' and controller.reads_all_states):
                    return f"{need}is not available: hardware '{idle.name}' is {idle.state.value}"
        return ''

    def interfaces(self, controllers: Iterable[Controller[Any]]
                   ) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
        """Return command interfaces and state interfaces, as ``joint/interface``."""
        owners = {*self.hardware.joint_names,
                  *(name.rpartition('/')[0] for system in self.systems
                    for name in (*system.other_states, *system.other_commands))}
        missing = [component for component in self.components if not component.configured]
        unavailable = {owner for owner in owners
                       if any(component.has(owner) for component in missing)}
        return interface_infos(self.hardware, controllers, self.systems, unavailable)

    def info(self, controllers: Iterable[Controller[Any]]) -> list[HardwareComponentInfo]:
        """Return what there is to report about each component."""
        kind = self.hardware.__class__
        own = f'{kind.__module__.partition(".")[0]}/{kind.__qualname__}'
        command, state = self.interfaces(controllers)
        return [HardwareComponentInfo(
            component.name,
            component.system.type if component.system is not None else 'system',
            component.system.plugin if component.system is not None else own,
            component.state.value,
            tuple(info for info in command if component.has(info.name.rpartition('/')[0])),
            tuple(info for info in state if component.has(info.name.rpartition('/')[0])),
        ) for component in self.components]

    def _reset_limits(self) -> None:
        if self.limits is not None:
            self.limits.reset()

    def _held_positions(self) -> dict[int, float]:
        """Return place -> position of the joints that are held, and of the other commands."""
        commanded = self.hardware.command.position
        positions = {place: value for place, value in enumerate(commanded.tolist())
                     if np.isfinite(value)}
        if self._held is not None:
            places, held = self._held
            positions.update(zip(places.tolist(), held.tolist(), strict=True))
        return positions

    def _hold(self, positions: Mapping[int, float]) -> None:
        hardware = self.hardware
        places = [hardware.index[name] for name in self.idle_joints - self.halted]
        values = [positions.get(place, hardware.state.position[place]) for place in places]
        self._held = (np.array(places), np.array(values)) if places else None
        others = {name for component in self.components if not component.active
                  and component.system is not None
                  for name in component.system.other_commands}
        now = {**hardware.other_commands, **self._held_others}
        self._held_others = {name: now[name] for name in others if name in now}
