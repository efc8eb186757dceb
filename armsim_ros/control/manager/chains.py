# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Chains of controllers: a preceding one writes to the references of a following one.

A following controller starts first and stops last; in each update the preceding one comes first.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import HardwareInterface

AnyController = Controller[Any]
Connections = dict[str, tuple[str, ...]]
"""Following controller -> its references, as ``joint/interface``."""


def precedes(one: AnyController, other: AnyController) -> bool:
    """Return whether a controller writes to references of another one."""
    return not set(one.required_command_interfaces).isdisjoint(other.reference_interfaces)


def preceding(controller: AnyController, others: Iterable[AnyController]) -> list[AnyController]:
    """Return those of the others that write to a controller's references."""
    return [one for one in others if precedes(one, controller)]


def following(controller: AnyController, others: Iterable[AnyController]) -> list[AnyController]:
    """Return those of the others to whose references a controller writes."""
    return [one for one in others if precedes(controller, one)]


def all_preceding(
    controller: AnyController, others: Collection[AnyController]
) -> list[AnyController]:
    """Return all whose commands go through a controller, nearest first."""
    found: list[AnyController] = []
    waiting = [controller]
    while waiting:
        for one in preceding(waiting.pop(0), others):
            if one not in found and one is not controller:
                found.append(one)
                waiting.append(one)
    return found


def in_order(controllers: Sequence[AnyController]) -> list[AnyController]:
    """Return controllers with each before those that it precedes, else in their order."""
    ordered: list[AnyController] = []
    left = list(controllers)
    while left:
        # A ring of controllers has no first one; it is cut where it was loaded first.
        first = next((one for one in left if not preceding(one, _without(left, one))), left[0])
        ordered.append(first)
        left.remove(first)
    return ordered


def connections(
    controller: AnyController, controllers: Iterable[AnyController]
) -> Connections:
    """Return the references that a controller writes to, by the controller that has them."""
    commanded = controller.required_command_interfaces
    return {
        one.name: tuple(relative(name) for name in commanded if name in one.reference_interfaces)
        for one in following(controller, controllers)
    }


def relative(interface: str) -> str:
    """Return a reference's name within its controller."""
    return interface.partition('/')[2]


def withdraw(controller: AnyController, hardware: HardwareInterface) -> None:
    """Offer nothing of a controller to others any more."""
    for name in controller.reference_interfaces:
        hardware.references.pop(name, None)
    for name in controller.exported_states:
        hardware.given_states.pop(name, None)


def broken_by_start(
    controllers: Mapping[str, AnyController], starting: list[str], stopping: Sequence[str]
) -> list[str]:
    """
    Take those out of ``starting`` that would lack a following controller; return why.

    :param controllers: all that are loaded.
    """
    problems = []
    while True:
        running = {name for name, one in controllers.items()
                   if (one.active and name not in stopping) or name in starting}  # fmt: skip
        for name in starting:
            lacking = [one.name for one in following(controllers[name], controllers.values())
                       if one.name not in running]  # fmt: skip
            if lacking:
                problems.append(f"'{name}' writes to references of '{lacking[0]}', which is not "
                                f"active; activate '{lacking[0]}' before it or with it")
                starting.remove(name)
                break
        else:
            return problems


def broken_by_stop(controllers: Mapping[str, AnyController], stopping: list[str]) -> list[str]:
    """
    Take those out of ``stopping`` that an active preceding controller needs; return why.

    :param controllers: all that are loaded.
    """
    problems = []
    while True:
        staying = [one for name, one in controllers.items() if one.active and name not in stopping]
        for name in stopping:
            users = preceding(controllers[name], staying)
            if users:
                problems.append(f"'{name}' cannot be deactivated: '{users[0].name}' writes to its "
                                f"references; deactivate '{users[0].name}' before it or with it")
                stopping.remove(name)
                break
        else:
            return problems


def _without(controllers: Iterable[AnyController], one: AnyController) -> list[AnyController]:
    return [other for other in controllers if other is not one]
