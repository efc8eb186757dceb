# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a switch request may do: which controllers start and stop, and which interfaces they get.

A plan is made before anything is touched. A wrong name or state refuses a STRICT request, and
BEST_EFFORT leaves it out; interfaces that a controller cannot have refuse a request of any
strictness.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.manager_info import dependents, start_obstacle, stop_obstacle
from armsim_ros.control.manager.resources import Resources
from armsim_ros.errors import ControllerError, nearest


def fallbacks_of(
    name: str, parameters: ControllerManagerParameters, given: Sequence[str] | None
) -> tuple[str, ...]:
    """
    Return the fallback controllers of a controller.

    :param given: None takes those of the manager's parameters.
    :raises ControllerError: it is among them itself.
    """
    entry = parameters.controllers.get(name)
    if given is None:
        given = entry.fallback_controllers if entry is not None else ()
    if name in given:
        raise ControllerError(f"'{name}' cannot be its own fallback controller")
    return tuple(given)


def fallback_obstacle(
    controller: Controller[Any], controllers: Mapping[str, Controller[Any]], resources: Resources
) -> str:
    """Return why a controller's fallback controllers could not take over, '' where they could."""
    names = controller.fallback_controllers
    active = {controller.name for controller in controllers.values()
              if controller.active}.union(names)
    for name in names:
        fallback = controllers.get(name)
        text = f"'{controller.name}' cannot be activated: its fallback controller '{name}' "
        if fallback is None:
            return f'{text}is not loaded'
        if fallback.state not in (LifecycleState.INACTIVE, LifecycleState.ACTIVE):
            return f'{text}is {fallback.state.value}, configure it first'
        if lack := resources.lack_of(fallback, active):
            return f'{text}could not be activated: {lack}'
    return ''


Controllers = Mapping[str, Controller[Any]]


class Strictness(IntEnum):
    """Values of ``controller_manager_msgs/srv/SwitchController``; the last two are best effort."""

    BEST_EFFORT = 1
    STRICT = 2
    AUTO = 3
    FORCE_AUTO = 4


@dataclass(frozen=True, slots=True)
class SwitchResult:
    """Whether all controllers of a request are in the requested states, and why not."""

    ok: bool
    message: str


@dataclass(frozen=True, slots=True)
class SwitchPlan:
    """Controllers to stop and to start, by name, and what was left out of the request."""

    deactivate: tuple[str, ...]
    activate: tuple[str, ...]
    left_out: tuple[str, ...]


def plan_takeover(controllers: Controllers, chain: Sequence[Controller[Any]]) -> SwitchPlan:
    """
    Return what the failure of a chain does: its fallback controllers take over.

    Controllers that hold command interfaces of the fallback controllers are deactivated, and those
    that depend on these.

    :param chain: its active controllers.
    """
    left_out: list[str] = []
    names = _loaded([name for member in chain for name in member.fallback_controllers],
                    controllers, left_out)
    starting = [controllers[name] for name in names
                if not controllers[name].active or controllers[name] in chain]
    needed = {interface for controller in starting
              for interface in controller.required_command_interfaces}
    others = [controller for controller in controllers.values()
              if controller.active and controller not in chain]
    holders = [controller for controller in others
               if not needed.isdisjoint(controller.required_command_interfaces)]
    stopping = (*chain, *holders, *dependents(holders, others))
    return SwitchPlan(tuple(controller.name for controller in stopping),
                      tuple(controller.name for controller in starting), tuple(left_out))


def takeover_obstacles(
    controllers: Controllers, resources: Resources, plan: SwitchPlan
) -> list[str]:
    """Return why fallback controllers cannot be activated, nothing where they all can."""
    starting, stopping = plan.activate, plan.deactivate
    problems = [text for name in starting
                if (text := _start_obstacle(controllers, name, starting, stopping))]
    return problems or list(_conflicts(controllers, resources, starting, stopping))


def plan_switch(
    controllers: Controllers, resources: Resources, activate: Sequence[str],
    deactivate: Sequence[str], *, strict: bool
) -> SwitchPlan:
    """
    Return what a request does.

    :raises ControllerError: nothing may be switched; the message has all reasons.
    """
    problems: list[str] = []
    stopping = _loaded(deactivate, controllers, problems)
    starting = _loaded(activate, controllers, problems)
    if not strict and ((deactivate and not stopping) or (activate and not starting)):
        raise ControllerError('; '.join(problems))
    for name in tuple(starting):
        if problem := (_start_obstacle(controllers, name, starting, stopping)
                       or fallback_obstacle(controllers[name], controllers, resources)):
            problems.append(problem)
            starting.remove(name)
    for name in tuple(stopping):
        if problem := _stop_obstacle(controllers, name, starting, stopping):
            problems.append(problem)
            stopping.remove(name)
    if strict and problems:
        raise ControllerError('; '.join(problems))
    starting = [name for name in starting if not controllers[name].active or name in stopping]
    if conflicts := list(_conflicts(controllers, resources, starting, stopping)):
        raise ControllerError('; '.join(conflicts))
    return SwitchPlan(tuple(stopping), tuple(starting), tuple(problems))


def claimed_joints(controllers: Sequence[Controller[Any]], hardware: HardwareInterface
                   ) -> dict[str, frozenset[str]]:
    """
    Return joint -> claimed interfaces of controllers that are or will be active.

    :param hardware: whose joints are meant; interfaces that move none of them are left out.
    """
    claims: dict[str, set[str]] = {}
    for controller in controllers:
        for interface in controller.required_command_interfaces:
            if motion := hardware.motion_of(interface):
                joint, kind = motion
                claims.setdefault(joint, set()).add(kind)
    return {joint: frozenset(kinds) for joint, kinds in claims.items()}


def clash(controller: Controller[Any], other: Controller[Any]) -> str:
    """Return why a controller cannot be active beside another one, '' where it can."""
    for interface in controller.required_command_interfaces:
        if interface in other.required_command_interfaces:
            return (f"'{controller.name}' needs the command interface {interface}, which "
                    f"'{other.name}' has claimed")
    if (controller.frees_arm and other.moves_arm) or (controller.moves_arm and other.frees_arm):
        return (f"'{controller.name}' cannot be active together with '{other.name}': one moves "
                'the arm, the other gives it free')
    return ''


def find_controller(controllers: Controllers, name: str) -> Controller[Any]:
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
            f'{" or ".join(state.value for state in states)}')


def require_unique_interfaces(controller: Controller[Any]) -> None:
    """Raise ControllerError where a controller names an interface twice."""
    for kind, names in (('command', controller.required_command_interfaces),
                        ('state', controller.required_state_interfaces)):
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise ControllerError(
                f"'{controller.name}' names {kind} interfaces more than once: {', '.join(twice)}")


def _loaded(names: Sequence[str], controllers: Controllers, problems: list[str]) -> list[str]:
    """Return the names that are loaded, each once; the others become problems."""
    problems += [_unknown(name, controllers) for name in names if name not in controllers]
    return [name for name in dict.fromkeys(names) if name in controllers]


def _start_obstacle(
    controllers: Controllers, name: str, starting: Sequence[str], stopping: Sequence[str]
) -> str:
    controller = controllers[name]
    if controller.active and name not in stopping:
        return f"'{name}' is active already"
    if controller.state not in (LifecycleState.ACTIVE, LifecycleState.INACTIVE):
        return f"'{name}' cannot be activated: it is {controller.state.value}, configure it first"
    return start_obstacle(controller, controllers.values(), starting, stopping)


def _stop_obstacle(
    controllers: Controllers, name: str, starting: Sequence[str], stopping: Sequence[str]
) -> str:
    controller = controllers[name]
    if not controller.active:
        return f"'{name}' cannot be deactivated: it is {controller.state.value}"
    return stop_obstacle(controller, controllers.values(), starting, stopping)


def _conflicts(
    controllers: Controllers, resources: Resources, starting: Sequence[str],
    stopping: Sequence[str]
) -> Iterator[str]:
    """Yield why controllers cannot have their interfaces."""
    running = [controller for controller in controllers.values()
               if controller.active
               and (controller.name not in stopping or controller.name in starting)]
    active = {controller.name for controller in running}.union(starting)
    others = list(running)
    for name in starting:
        controller = controllers[name]
        if idle := resources.inactive_owner(controller.required_command_interfaces):
            yield (f"'{name}' needs hardware '{idle}', which is inactive; activate it with "
                   'set_hardware_component_state or the hardware_spawner')
        if controller.active:
            continue
        if lack := resources.lack_of(controller, active):
            yield lack
        yield from [text for other in others if (text := clash(controller, other))][:1]
        others.append(controller)


def _unknown(name: str, controllers: Controllers) -> str:
    known = tuple(controllers)
    hint = nearest(name, known) or f'loaded: {", ".join(known) or "none"}'
    return f"no controller '{name}' is loaded; {hint}"
