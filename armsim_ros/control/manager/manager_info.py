# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Chains of controllers, and information about controllers and interfaces."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.model.robot_model import HardwareSystem

AnyController = Controller[Any]
Relation = Callable[[AnyController, AnyController], bool]
Connections = dict[str, tuple[str, ...]]
"""Following controller -> its references, as ``joint/interface``."""


def writes_to(first: AnyController, other: AnyController) -> bool:
    """Return whether a controller writes to references of another."""
    offered = other.reference_interfaces
    return bool(offered) and not set(offered).isdisjoint(first.required_command_interfaces)


def reads_from(first: AnyController, other: AnyController) -> bool:
    """Return whether a controller reads states that another exports."""
    offered = other.exported_states
    return bool(offered) and not set(offered).isdisjoint(first.required_state_interfaces)


def depends_on(first: AnyController, other: AnyController) -> bool:
    """Return whether a controller can be active only while another is."""
    return writes_to(first, other) or reads_from(first, other)


def precedes(first: AnyController, other: AnyController) -> bool:
    """Return whether the update of a controller comes before that of another."""
    return writes_to(first, other) or (reads_from(other, first) and not writes_to(other, first))


def preceding(controller: AnyController, others: Iterable[AnyController]) -> list[AnyController]:
    """Return those of the others that write to a controller's references."""
    return [other for other in others if writes_to(other, controller)]


def dependents(
    controllers: Iterable[AnyController], others: Iterable[AnyController]
) -> list[AnyController]:
    """Return those of the others that depend on any of the controllers, also through others."""
    return _reached(controllers, others, lambda found, other: depends_on(other, found))


def dependencies(
    controller: AnyController, others: Iterable[AnyController]
) -> list[AnyController]:
    """Return those of the others that a controller depends on, also through others."""
    return _reached([controller], others, depends_on)


def group_of(
    controller: AnyController, controllers: Iterable[AnyController]
) -> list[AnyController]:
    """Return a controller and all that are in a chain with it."""
    return [controller, *_reached(
        [controller], controllers,
        lambda found, other: depends_on(found, other) or depends_on(other, found))]


def _reached(
    controllers: Iterable[AnyController], others: Iterable[AnyController], related: Relation
) -> list[AnyController]:
    """Return those of the others that a relation leads to from the controllers."""
    found, others = list(controllers), list(others)
    begin = len(found)
    for member in found:
        found += [other for other in others if other not in found and related(member, other)]
    return found[begin:]


def in_order(
    controllers: Sequence[AnyController], before: Relation = precedes
) -> list[AnyController]:
    """Return controllers with each after those that come before it, else in their order."""
    ordered: list[AnyController] = []
    left = list(controllers)
    while left:
        # A ring of controllers has no beginning; it is cut at the controller loaded first.
        first = next((each for each in left if not any(
            before(other, each) for other in left if other is not each)), left[0])
        ordered.append(first)
        left.remove(first)
    return ordered


def connections(controller: AnyController, controllers: Iterable[AnyController]) -> Connections:
    """Return the references that a controller writes to, by the controller that has them."""
    commanded = controller.required_command_interfaces
    return {
        follower.name: tuple(relative(name) for name in commanded
                             if name in follower.reference_interfaces)
        for follower in controllers if writes_to(controller, follower)}


def relative(interface: str) -> str:
    """Return a reference's name within its controller."""
    return interface.partition('/')[2]


def withdraw(controller: AnyController, hardware: HardwareInterface) -> None:
    """Offer nothing of a controller to others any more."""
    for name in controller.reference_interfaces:
        hardware.references.pop(name, None)
    for name in controller.exported_states:
        hardware.given_states.pop(name, None)


def start_obstacle(
    controller: AnyController, controllers: Iterable[AnyController], starting: Sequence[str],
    stopping: Sequence[str]
) -> str:
    """
    Return why a controller cannot be activated in its chain, '' where it can.

    :param starting: names of the controllers that the same request activates.
    """
    for needed in dependencies(controller, controllers):
        if needed.name in starting:
            continue
        use = ('writes to references of' if writes_to(controller, needed) else
               'reads states of' if reads_from(controller, needed) else 'depends on')
        if needed.name in stopping:
            return (f"'{controller.name}' {use} '{needed.name}', which the same request "
                    'deactivates')
        if not needed.active:
            return (f"'{controller.name}' {use} '{needed.name}', which is not active; activate "
                    f"'{needed.name}' before it or with it")
    return ''


def stop_obstacle(
    controller: AnyController, controllers: Iterable[AnyController], starting: Sequence[str],
    stopping: Sequence[str]
) -> str:
    """
    Return why a controller cannot be deactivated in its chain, '' where it can.

    :param starting: names of the controllers that the same request activates.
    """
    for user in controllers:
        if depends_on(user, controller) and (
                user.name not in stopping if user.active else user.name in starting):
            use = 'writes to its references' if writes_to(user, controller) else 'reads its states'
            return (f"'{controller.name}' cannot be deactivated: '{user.name}' {use}; "
                    f"deactivate '{user.name}' before it or with it")
    return ''


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
        connections(controller, controllers) if known else {})


def interface_infos(
    hardware: HardwareInterface, controllers: Iterable[Controller[Any]],
    systems: Sequence[HardwareSystem] = (), unavailable: Collection[str] = ()
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
    of_hardware = [*_names(hardware.command_interfaces.items()),
                   *(name for system in systems for name in system.other_commands)]
    commands = [*((name, name.rpartition('/')[0] not in unavailable) for name in of_hardware),
                *((name, controller.active) for controller in controllers
                  for name in controller.reference_interfaces if name in hardware.references)]
    states = [*_names(hardware.state_interfaces.items()), *hardware.other_states]
    return (
        [InterfaceInfo(name, available, available and name in claimed)
         for name, available in commands],
        [InterfaceInfo(name, name in exported if name in own
                       else name.rpartition('/')[0] not in unavailable, False)
         for name in states])


def _names(interfaces: Iterable[tuple[str, tuple[str, ...]]]) -> list[str]:
    return [f'{joint}/{kind}' for joint, kinds in interfaces for kind in kinds]
