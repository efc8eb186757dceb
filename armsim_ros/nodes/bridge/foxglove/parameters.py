# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of nodes for Foxglove: read, set, and published as they change."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import foxglove
from rcl_interfaces.msg import ParameterEvent

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.rosapi.parameters import Parameters, plain_value

_DEPTH = 100


class SharedParameters:
    """
    The parameters ``node:name`` that clients see.

    :param parameters: of all nodes.
    :param publish: sends values to the clients that follow them.
    :param report: shows clients why a value was not set.
    """

    def __init__(self, link: BridgeLink, parameters: Parameters,
                 publish: Callable[[list[Any]], None], report: Callable[[str], None]) -> None:
        self._link, self._parameters = link, parameters
        self._publish, self._report = publish, report
        self._followed: set[str] = set()
        self._events: Any = None

    async def read(self, names: list[str]) -> list[Any]:
        """Return parameters, all where no names are given."""
        found = []
        for name in names or await self._parameters.names():
            with suppress(ArmsimError):
                found.append(foxglove.Parameter(name, value=await self._parameters.value(name)))
        return found

    async def write(self, changed: list[Any]) -> None:
        """Set parameters; what a node does not take is reported."""
        for parameter in changed:
            try:
                await self._parameters.set_value(parameter.name, parameter.get_value())
            except ArmsimError as error:
                self._report(f'{parameter.name}: {error}')

    def follow(self, names: list[str]) -> None:
        """Publish these, too, as they change."""
        self._followed.update(names)
        if self._events is None:
            self._events = self._link.in_thread(lambda: self._link.node.create_subscription(
                ParameterEvent, '/parameter_events', self._changed, _DEPTH))

    def forget(self, names: list[str]) -> None:
        """Publish these no more."""
        self._followed.difference_update(names)
        if self._events is not None and not self._followed:
            events, self._events = self._events, None
            self._link.in_thread(lambda: self._link.node.destroy_subscription(events.result()))

    def _changed(self, event: ParameterEvent) -> None:
        values = [foxglove.Parameter(name, value=plain_value(parameter.value))
                  for parameter in (*event.new_parameters, *event.changed_parameters)
                  if (name := f'{event.node}:{parameter.name}') in self._followed]
        if values:
            self._publish(values)
