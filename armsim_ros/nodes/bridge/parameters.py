# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of nodes for rosapi: ``node:name``, values as JSON."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Iterable, Mapping
from contextlib import suppress
import json
from typing import Any, TypeVar

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from armsim_ros.errors import nearest
from armsim_ros.nodes.bridge.graph_view import is_hidden
from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.permissions import NamePatterns

#: How long a node may take to answer [s].
_PATIENCE = 1.0
_MOST_NAMES = 20

T = TypeVar('T')


class Parameters:
    """
    The parameters of all nodes.

    :param patterns: those that may be used.
    :param ignores_silent: whether ``all_values`` leaves out nodes that have not answered before.
    """

    def __init__(self, link: BridgeLink, patterns: NamePatterns, *, ignores_silent: bool = False
                 ) -> None:
        self._link, self._patterns, self._ignores_silent = link, patterns, ignores_silent
        self._silent: set[str] = set()

    def allows(self, full_name: str) -> bool:
        """Return whether a parameter may be used, whether or not it is there."""
        node, _, name = full_name.partition(':')
        return self._patterns.allows_parameter(node, name)

    async def value(self, full_name: str) -> Any:
        """
        Return a value; an array of bytes as integers.

        :raises RefusalError: there is no such node or parameter.
        """
        node, name = self._parts(full_name)
        value = await self._value(node, name)
        if value.type == ParameterType.PARAMETER_NOT_SET:
            raise RefusalError(await self._no_such(node, name))
        return plain_value(value)

    async def set(self, full_name: str, text: str) -> None:
        """
        Set a parameter to a value in JSON.

        :raises RefusalError: the node does not take it; with its reason.
        """
        try:
            value = json.loads(text)
        except ValueError as error:
            raise RefusalError(f'the value is not JSON: {error}') from None
        await self.set_value(full_name, value)

    async def set_value(self, full_name: str, value: Any) -> None:
        """
        Set a parameter.

        :raises RefusalError: the node does not take it; with its reason.
        """
        node, name = self._parts(full_name)
        present = (await self._value(node, name)).type
        await self._set(node, name, _to_value(value, present))

    async def delete(self, full_name: str) -> None:
        """
        Delete a parameter.

        :raises RefusalError: the node does not allow it; with its reason.
        """
        node, name = self._parts(full_name)
        if (await self._value(node, name)).type == ParameterType.PARAMETER_NOT_SET:
            raise RefusalError(await self._no_such(node, name))
        await self._set(node, name, ParameterValue(type=ParameterType.PARAMETER_NOT_SET))

    async def names(self) -> list[str]:
        """Return all parameters of all nodes; a node that does not answer is left out."""
        found = await self._gather({node: self._names_of(node) for node in self._nodes()})
        return [f'{node}:{name}' for node, names in found.items() for name in names
                if self._patterns.allows_parameter(node, name)]

    async def values(self, full_names: Iterable[str]) -> dict[str, Any]:
        """
        Return the values of parameters by the given names; what cannot be read is left out.

        All nodes are called at the same time, each once.
        """
        requested = dict[str, dict[str, str]]()
        for full_name in full_names:
            with suppress(RefusalError):
                node, name = self._parts(full_name)
                requested.setdefault(node, {})[name] = full_name
        found = await self._gather({node: self._values_of(node, list(names))
                                    for node, names in requested.items()})
        return {requested[node][name]: value for node, values in found.items()
                for name, value in values.items()}

    async def all_values(self) -> dict[str, Any]:
        """Return the values of all parameters of all nodes, as ``values`` does."""
        nodes = self._nodes()
        self._silent.intersection_update(nodes)
        left_out = self._silent if self._ignores_silent else ()
        found = await self._gather({node: self._all_values_of(node)
                                    for node in nodes if node not in left_out})
        return {f'{node}:{name}': value for node, values in found.items()
                for name, value in values.items()}

    def _nodes(self) -> list[str]:
        ending = '/list_parameters'
        return sorted(service.removesuffix(ending) for service in self._link.service_types()
                      if service.endswith(ending) and not is_hidden(service))

    async def _gather(self, calls: Mapping[str, Awaitable[T]]) -> dict[str, T]:
        """Return the answers of nodes that are called at the same time."""
        answers = await asyncio.gather(*calls.values(), return_exceptions=True)
        silent = [node for node, found in zip(calls, answers, strict=True)
                  if isinstance(found, BaseException)]
        if silent:
            self._silent.update(silent)
            self._link.node.get_logger().warning(
                f'no parameters of {", ".join(silent)}: no answer within {_PATIENCE:g} s')
        return {node: found for node, found in zip(calls, answers, strict=True)
                if not isinstance(found, BaseException)}

    async def _all_values_of(self, node: str) -> dict[str, Any]:
        return await self._values_of(node, [
            name for name in await self._names_of(node)
            if self._patterns.allows_parameter(node, name)])

    async def _values_of(self, node: str, names: list[str]) -> dict[str, Any]:
        """Return the values that a node has."""
        values = await self._values(node, names)
        if len(values) < len(names) > 1:  # rclcpp returns none where one is not declared
            values = [value for name in names
                      for value in await self._values(node, [name]) or [ParameterValue()]]
        return {name: plain_value(value) for name, value in zip(names, values, strict=False)
                if value.type != ParameterType.PARAMETER_NOT_SET}

    async def _names_of(self, node: str) -> list[str]:
        response = await self._call(ListParameters, node, 'list_parameters',
                                    ListParameters.Request())
        return list(response.result.names)

    async def _value(self, node: str, name: str) -> Any:
        values = await self._values(node, [name])
        return values[0] if values else ParameterValue()

    async def _values(self, node: str, names: list[str]) -> list[ParameterValue]:
        response = await self._call(GetParameters, node, 'get_parameters',
                                    GetParameters.Request(names=names))
        return list(response.values)

    async def _set(self, node: str, name: str, value: Any) -> None:
        request = SetParameters.Request(parameters=[ParameterMessage(name=name, value=value)])
        result = (await self._call(SetParameters, node, 'set_parameters', request)).results[0]
        if not result.successful:
            raise RefusalError(result.reason or f'node {node} does not take it')

    async def _call(self, kind: type[Any], node: str, service: str, request: Any) -> Any:
        try:
            return await asyncio.wait_for(
                self._link.call_when_ready(kind, f'{node}/{service}', request), _PATIENCE)
        except (asyncio.TimeoutError, TimeoutError):
            raise RefusalError(f'node {node} did not answer within {_PATIENCE:g} s') from None

    def _parts(self, full_name: str) -> tuple[str, str]:
        node, separator, name = full_name.partition(':')
        if not separator or not name:
            raise RefusalError(f"'{full_name[:200]}': a parameter is named node:name")
        node = self._link.expand(node)
        if not self._patterns.allows_parameter(node, name):
            raise self._patterns.refusal()
        if f'{node}/get_parameters' not in self._link.service_types():
            ending = '/get_parameters'
            nodes = [each.removesuffix(ending) for each in self._link.service_types()
                     if each.endswith(ending)]
            raise RefusalError(f'no node {node}; {nearest(node, nodes)}'.rstrip('; '))
        return node, name

    async def _no_such(self, node: str, name: str) -> str:
        names = await self._names_of(node)
        more = ' ...' if len(names) > _MOST_NAMES else ''
        hint = nearest(name, names)
        return (f'node {node} has no parameter {name}; '
                + (f'{hint} ' if hint else '') + f'it has {", ".join(names[:_MOST_NAMES])}{more}')


def plain_value(value: ParameterValue) -> Any:
    """Return a value that is set; an array of bytes as integers."""
    found = parameter_value_to_python(value)
    if isinstance(found, (bool, int, float, str)):
        return found
    return [item[0] if isinstance(item, bytes) else item for item in found]


def _to_value(value: Any, present: int) -> Any:
    """Return the value of a parameter; a whole number fits where a float is."""
    if present == ParameterType.PARAMETER_DOUBLE and type(value) is int:
        value = float(value)
    if present == ParameterType.PARAMETER_DOUBLE_ARRAY and isinstance(value, list):
        value = [float(item) if type(item) is int else item for item in value]
    if present == ParameterType.PARAMETER_BYTE_ARRAY and isinstance(value, list):
        value = [bytes([item]) for item in value if isinstance(item, int) and 0 <= item < 256]
    try:
        return Parameter('value', value=value).get_parameter_value()
    except (TypeError, AssertionError, OverflowError):
        raise RefusalError('a value is true or false, a number, a string, or a list of one '
                           'kind of these') from None
