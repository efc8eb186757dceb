# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a controller manager tells about controllers and interfaces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface


@dataclass(frozen=True, slots=True)
class ControllerInfo:
    """
    One loaded controller.

    :param claimed_interfaces: as ``joint/interface``; only while it is active.
    :param required_command_interfaces: only while it is inactive or active.
    :param required_state_interfaces: only while it is inactive or active.
    """

    name: str
    type: str
    state: str
    update_rate: int
    claimed_interfaces: tuple[str, ...]
    required_command_interfaces: tuple[str, ...]
    required_state_interfaces: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InterfaceInfo:
    """One interface of the hardware, as ``joint/interface``."""

    name: str
    is_available: bool
    is_claimed: bool


def controller_info(controller: Controller[Any]) -> ControllerInfo:
    """Return what there is to tell about a controller."""
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
    )


def interface_infos(
    hardware: HardwareInterface, controllers: Iterable[Controller[Any]], available: bool
) -> tuple[list[InterfaceInfo], list[InterfaceInfo]]:
    """
    Return command interfaces and state interfaces.

    :param available: whether the hardware is active.
    """
    claimed = {
        interface
        for controller in controllers
        if controller.active
        for interface in controller.required_command_interfaces
    }
    command = [
        InterfaceInfo(name, available, name in claimed)
        for name in _names(hardware.command_interfaces.items())
    ]
    state = [InterfaceInfo(n, True, False) for n in _names(hardware.state_interfaces.items())]
    return command, state


def _names(interfaces: Iterable[tuple[str, tuple[str, ...]]]) -> list[str]:
    return [f'{joint}/{kind}' for joint, kinds in interfaces for kind in kinds]
