# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fallback controllers: they take over when a controller fails, and must be able to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.manager.resources import Resources
from armsim_ros.errors import ControllerError


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
        raise ControllerError(f"'{name}' cannot be a fallback controller of itself")
    return tuple(given)


def fallback_obstacle(
    controller: Controller[Any],
    controllers: Mapping[str, Controller[Any]],
    resources: Resources,
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


def holders_of(
    names: Sequence[str], controllers: Mapping[str, Controller[Any]]
) -> list[Controller[Any]]:
    """Return the active controllers that hold command interfaces of the named ones."""
    needed = {interface for name in names if name in controllers
              for interface in controllers[name].required_command_interfaces}
    return [controller for controller in controllers.values()
            if controller.active and not needed.isdisjoint(controller.required_command_interfaces)]
