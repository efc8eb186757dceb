# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Checked settings as declared ROS parameters, and their changes back into checked settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.nodes.parameter_entries import entries, Entry

SettingsT = TypeVar('SettingsT', bound=BaseModel)


class SettingsParameters(Generic[SettingsT]):
    """
    Declares settings on a node and keeps the two equal.

    A change that the settings' own checks refuse is refused with their words; a legal change
    replaces the settings and is handed on.

    :param node: the node that owns the parameters.
    :param settings: the values at the start.
    :param changed: called with the new settings after every change.
    :param objection: returns what else is wrong with new settings, '' where nothing is.
    """

    def __init__(
        self,
        node: Node,
        settings: SettingsT,
        changed: Callable[[SettingsT], None] | None = None,
        objection: Callable[[SettingsT], str] | None = None,
    ) -> None:
        """Declare all parameters; values from ``--ros-args`` win over the settings'."""
        self.settings = settings
        self._changed = changed
        self._objection = objection
        self._entries = {entry.name: entry for entry in entries(settings)}
        overrides = []
        for entry in self._entries.values():
            parameter = _declare(node, entry)
            if _differs(parameter.value, entry.value):
                overrides.append(parameter)
        if overrides:
            self.settings = self._merged(overrides)
            if changed is not None:
                changed(self.settings)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def _check(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        try:
            merged = self._merged(parameters)
        except ValidationError as error:
            return SetParametersResult(successful=False, reason=reason(error))
        wrong = self._objection(merged) if self._objection is not None else ''
        return SetParametersResult(successful=not wrong, reason=wrong)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        mine = [parameter for parameter in parameters if parameter.name in self._entries]
        if not mine:
            return
        self.settings = self._merged(mine)
        if self._changed is not None:
            self._changed(self.settings)

    def _merged(self, parameters: Sequence[Parameter]) -> SettingsT:
        # Only what was given: settings may treat a default otherwise than the same value given.
        content = self.settings.model_dump(by_alias=True, exclude_unset=True)
        for parameter in parameters:
            entry = self._entries.get(parameter.name)
            if entry is None:
                continue
            value = parameter.value
            if isinstance(entry.value, list) and value is not None:
                value = list(value)
            _put(content, self.settings, entry.path, value)
        return type(self.settings).model_validate(content)


def parameters_by_prefix(node: Node, prefix: str) -> dict[str, Parameter]:
    """Return the parameters below a prefix; rclpy's own annotation takes them for values."""
    found: dict[str, Any] = dict(node.get_parameters_by_prefix(prefix))
    return found


def reason(error: ValidationError) -> str:
    """Return a validation error as a line that names every parameter."""
    lines = []
    for problem in error.errors(include_url=False):
        name = '.'.join(str(key) for key in problem['loc'])
        text = str(problem['msg']).removeprefix('Value error, ')
        lines.append(f'{name}: {text}' if name else text)
    return '; '.join(lines)


def _put(content: dict[str, Any], current: Any, path: tuple[str, ...], value: Any) -> None:
    """Write a value into dumped settings; what was not dumped on the way is taken as it is."""
    key, *rest = path
    if not rest:
        content[key] = value
        return
    if isinstance(current, BaseModel):
        current = {
            **{info.alias or name: getattr(current, name)
               for name, info in type(current).model_fields.items()},
            **(current.model_extra or {}),
        }
    if key not in content:
        content[key] = _dump(current[key])
    _put(content[key], current[key], tuple(rest), value)


def _dump(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(by_alias=True, exclude_unset=True)
    if isinstance(value, Mapping):
        return {key: _dump(item) for key, item in value.items()}
    return value


def _declare(node: Node, entry: Entry) -> Parameter:
    name, kind, descriptor = entry.name, entry.kind, entry.descriptor
    if node.has_parameter(name):
        return _declare_again(node, entry)
    if entry.value is None:
        node.declare_parameter(name, kind, descriptor)
        return node.get_parameter_or(name)
    if entry.value != []:
        return node.declare_parameter(name, entry.value, descriptor)
    # An empty list has no element whose type could be inferred: declared by type, set, closed.
    node.declare_parameter(name, kind, ParameterDescriptor())
    if node.get_parameter_or(name).value is None:
        node.set_parameters([Parameter(name, kind, [])])
    node.set_descriptor(name, descriptor)
    return node.get_parameter(name)


def _declare_again(node: Node, entry: Entry) -> Parameter:
    """Give a parameter that the node declared by itself, for an override, type and range."""
    value = node.get_parameter(entry.name).value
    if entry.kind is Parameter.Type.DOUBLE and type(value) is int:
        value = float(value)
    node.undeclare_parameter(entry.name)
    return node.declare_parameter(entry.name, value, entry.descriptor, ignore_override=True)


def _differs(declared: Any, given: Any) -> bool:
    if isinstance(given, list):
        return list(declared or ()) != given
    return bool(declared != given)
