# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Information about controllers and interfaces."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.chains import Connections, connections, relative
from armsim_ros.model.robot_model import HardwareSystem


@dataclass(frozen=True, slots=True)
class ControllerInfo:
    """
    A loaded controller.

    :param claimed_interfaces: as ``joint/interface``; only while it is active.
    :param required_command_interfaces: only while it is inactive or active.
    :param required_state_interfaces: only while it is inactive or active.
    :param chainable: whether others can write to its references.
    :param chained: whether any does.
    :param exported_states: what others may read of it, without its name.
    :param references: what others may write to, without its name.
    :param connections: to which controllers it writes, and to which of their references.
    """

    name: str
    type: str
    state: str
    update_rate: int
    claimed_interfaces: tuple[str, ...]
    required_command_interfaces: tuple[str, ...]
    required_state_interfaces: tuple[str, ...]
    chainable: bool
    chained: bool
    exported_states: tuple[str, ...]
    references: tuple[str, ...]
    connections: Connections


@dataclass(frozen=True, slots=True)
class InterfaceInfo:
    """An interface of the hardware, as ``joint/interface``."""

    name: str
    is_available: bool
    is_claimed: bool


def controller_info(
    controller: Controller[Any], controllers: Iterable[Controller[Any]]
) -> ControllerInfo:
    """
    Return the information about a controller.

    :param controllers: all that are loaded.
    """
    known = controller.state in (LifecycleState.INACTIVE, LifecycleState.ACTIVE)
    commands = controller.required_command_interfaces
    return ControllerInfo(
        controller.name,
        controller.type,
        controller.state.value,
        controller.update_rate,
        commands if controller.active else (),
        commands if known else (),
        controller.required_state_interfaces if known else (),
        controller.chainable,
        controller.chained,
        tuple(map(relative, controller.exported_states)) if known else (),
        tuple(map(relative, controller.reference_interfaces)) if known else (),
        connections(controller, controllers) if known else {},
    )


def interface_infos(
    hardware: HardwareInterface,
    controllers: Iterable[Controller[Any]],
    systems: Sequence[HardwareSystem] = (),
    unavailable: Collection[str] = (),
) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
    """
    Return command interfaces and state interfaces.

    :param systems: the declared hardware, whose sensors and gpios have interfaces of their own.
    :param unavailable: joints, sensors and gpios of hardware that is not configured.
    """
    controllers = tuple(controllers)
    active = [controller for controller in controllers if controller.active]
    claimed = {interface for controller in active
               for interface in controller.required_command_interfaces}
    exported = {name for controller in active for name in controller.exported_states}
    own = {name for controller in controllers for name in controller.exported_states}
    commands = [*_names(hardware.command_interfaces.items()),
                *(name for system in systems for name in system.other_commands)]
    states = [*_names(hardware.state_interfaces.items()), *hardware.other_states]
    return (
        [InterfaceInfo(name, name.rpartition('/')[0] not in unavailable, name in claimed)
         for name in commands]
        + [InterfaceInfo(name, controller.active, name in claimed)
           for controller in controllers for name in controller.reference_interfaces
           if name in hardware.references],
        [InterfaceInfo(name, name in exported if name in own
                       else name.rpartition('/')[0] not in unavailable, False)
         for name in states],
    )


def _names(interfaces: Iterable[tuple[str, tuple[str, ...]]]) -> list[str]:
    return [f'{joint}/{kind}' for joint, kinds in interfaces for kind in kinds]
