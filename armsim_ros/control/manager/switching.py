# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a switch request may do: who starts, who stops, who gets which command interface.

A plan is made before anything is touched. STRICT refuses a request of which any part is wrong;
BEST_EFFORT leaves the wrong parts out.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.chains import broken_by_start, broken_by_stop
from armsim_ros.errors import ControllerError, nearest


class Strictness(IntEnum):
    """Values of ``controller_manager_msgs/srv/SwitchController``; the last two are best effort."""

    BEST_EFFORT = 1
    STRICT = 2
    AUTO = 3
    FORCE_AUTO = 4


@dataclass(frozen=True, slots=True)
class SwitchResult:
    """What became of a switch request; the message tells it in a sentence."""

    ok: bool
    message: str


@dataclass(frozen=True, slots=True)
class SwitchPlan:
    """Controllers to stop and to start, by name, and what was wrong with the request."""

    deactivate: tuple[str, ...]
    activate: tuple[str, ...]
    problems: tuple[str, ...]


def plan_switch(
    controllers: Mapping[str, Controller[Any]],
    hardware: HardwareInterface,
    activate: Sequence[str],
    deactivate: Sequence[str],
) -> SwitchPlan:
    """Return what of a request can be done, and all that cannot."""
    problems: list[str] = []
    stopping: list[str] = []
    for name in dict.fromkeys(deactivate):
        if name not in controllers:
            problems.append(_unknown(name, controllers))
        elif not controllers[name].active:
            state = controllers[name].state.value
            problems.append(f"'{name}' cannot be deactivated: it is {state}")
        else:
            stopping.append(name)
    problems += broken_by_stop(controllers, stopping)
    owners = {
        interface: name
        for name, controller in controllers.items()
        if controller.active and name not in stopping
        for interface in controller.required_command_interfaces
    }
    starting: list[str] = []
    for name in dict.fromkeys(activate):
        problem = _obstacle(name, controllers, hardware, stopping, owners)
        if problem:
            problems.append(problem)
            continue
        starting.append(name)
        for interface in controllers[name].required_command_interfaces:
            owners[interface] = name
    problems += broken_by_start(controllers, starting, stopping)
    return SwitchPlan(tuple(stopping), tuple(starting), tuple(problems))


def claimed_joints(controllers: Sequence[Controller[Any]], joints: Collection[str]
                   ) -> dict[str, frozenset[str]]:
    """
    Return joint -> claimed interfaces of controllers that are or will be active.

    :param joints: of the hardware; sensors and gpios have nothing to switch.
    """
    claims: dict[str, set[str]] = {}
    for controller in controllers:
        for interface in controller.required_command_interfaces:
            joint, _, kind = interface.rpartition('/')
            if joint in joints:
                claims.setdefault(joint, set()).add(kind)
    return {joint: frozenset(kinds) for joint, kinds in claims.items()}


def find_controller(controllers: Mapping[str, Controller[Any]], name: str) -> Controller[Any]:
    """Return a controller by its name; ControllerError names those that are loaded."""
    try:
        return controllers[name]
    except KeyError:
        raise ControllerError(_unknown(name, controllers)) from None


def require_state(controller: Controller[Any], verb: str, *states: LifecycleState) -> None:
    """Raise ControllerError unless the controller is in one of the states."""
    if controller.state not in states:
        raise ControllerError(
            f"'{controller.name}' is {controller.state.value} and cannot be {verb}; allowed: "
            f'{" or ".join(state.value for state in states)}'
        )


def _obstacle(
    name: str,
    controllers: Mapping[str, Controller[Any]],
    hardware: HardwareInterface,
    stopping: Sequence[str],
    owners: Mapping[str, str],
) -> str:
    controller = controllers.get(name)
    if controller is None:
        return _unknown(name, controllers)
    if controller.active and name not in stopping:
        return f"'{name}' is active already"
    if controller.state not in (LifecycleState.ACTIVE, LifecycleState.INACTIVE):
        return f"'{name}' cannot be activated: it is {controller.state.value}, configure it first"
    for kind, required, offered in (
        ('command', controller.required_command_interfaces, hardware.commands_of),
        ('state', controller.required_state_interfaces, hardware.states_of),
    ):
        for interface in required:
            joint, _, quantity = interface.rpartition('/')
            if quantity not in offered(joint):
                known = ', '.join(f'{joint}/{one}' for one in offered(joint)) or 'none'
                return (f"'{name}' needs the {kind} interface {interface}, which the hardware "
                        f"lacks; '{joint}' has: {known}")
    for interface in controller.required_command_interfaces:
        if interface in owners:
            return f"'{name}' needs {interface}, which '{owners[interface]}' has claimed"
    return ''


def _unknown(name: str, controllers: Mapping[str, Controller[Any]]) -> str:
    known = tuple(controllers)
    hint = nearest(name, known) or f'loaded: {", ".join(known) or "none"}'
    return f"no controller '{name}' is loaded; {hint}"
