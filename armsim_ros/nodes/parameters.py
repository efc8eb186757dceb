# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Checked settings as declared ROS parameters, and their changes back into checked settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
import sys
import types
from typing import Any, get_args, get_origin, Literal, Union

import annotated_types
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

_SCALARS = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
}
_ARRAYS = {
    bool: Parameter.Type.BOOL_ARRAY,
    int: Parameter.Type.INTEGER_ARRAY,
    float: Parameter.Type.DOUBLE_ARRAY,
    str: Parameter.Type.STRING_ARRAY,
}
_INT64 = (-(2**63), 2**63 - 1)


@dataclass(frozen=True)
class Entry:
    """
    One parameter.

    :param path: keys from the settings' root to the value.
    :param value: in the form of a ROS parameter; None where it is not set.
    """

    path: tuple[str, ...]
    kind: Parameter.Type
    value: Any
    descriptor: ParameterDescriptor

    @property
    def name(self) -> str:
        """The parameter's name: the path, dotted."""
        return '.'.join(self.path)


def entries(settings: BaseModel) -> Iterator[Entry]:
    """Yield every single value of nested settings, in their order."""
    yield from _of_model(settings, (), False)


class SettingsParameters:
    """
    Declares settings on a node and keeps the two equal.

    A change that the settings' own checks refuse is refused with their words; a legal one
    replaces the settings and is handed on.

    :param node: the node that owns the parameters.
    :param settings: the values at the start.
    :param changed: called with the new settings after every change.
    """

    def __init__(
        self, node: Node, settings: BaseModel, changed: Callable[[Any], None] | None = None
    ) -> None:
        """Declare all parameters; values from ``--ros-args`` win over the settings'."""
        self.settings = settings
        self._changed = changed
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
            self._merged(parameters)
        except ValidationError as error:
            return SetParametersResult(successful=False, reason=reason(error))
        return SetParametersResult(successful=True)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        mine = [parameter for parameter in parameters if parameter.name in self._entries]
        if not mine:
            return
        self.settings = self._merged(mine)
        if self._changed is not None:
            self._changed(self.settings)

    def _merged(self, parameters: Sequence[Parameter]) -> BaseModel:
        content = self.settings.model_dump(by_alias=True)
        for parameter in parameters:
            entry = self._entries.get(parameter.name)
            if entry is None:
                continue
            *folders, last = entry.path
            place = content
            for key in folders:
                place = place[key]
            value = parameter.value
            place[last] = list(value) if entry.kind in _ARRAYS.values() and value else value
        return type(self.settings).model_validate(content)


def reason(error: ValidationError) -> str:
    """Return a validation error as one line that names every parameter."""
    lines = []
    for problem in error.errors(include_url=False):
        name = '.'.join(str(key) for key in problem['loc'])
        text = str(problem['msg']).removeprefix('Value error, ')
        lines.append(f'{name}: {text}' if name else text)
    return '; '.join(lines)


def _declare(node: Node, entry: Entry) -> Parameter:
    name, kind, descriptor = entry.name, entry.kind, entry.descriptor
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


def _differs(declared: Any, given: Any) -> bool:
    if isinstance(given, list):
        return list(declared or ()) != given
    return bool(declared != given)


def _of_model(model: BaseModel, path: tuple[str, ...], read_only: bool) -> Iterator[Entry]:
    for name, info in type(model).model_fields.items():
        key = (*path, info.alias or name)
        fixed = read_only or _is_read_only(info)
        yield from _of_value(getattr(model, name), info.annotation, info, key, fixed)


def _of_value(
    value: Any, annotation: Any, info: FieldInfo, path: tuple[str, ...], read_only: bool
) -> Iterator[Entry]:
    if isinstance(value, BaseModel):
        yield from _of_model(value, path, read_only)
    elif isinstance(value, Mapping):
        inner = get_args(annotation)[-1] if get_args(annotation) else type(None)
        for key, item in value.items():
            yield from _of_value(item, inner, info, (*path, str(key)), read_only)
    else:
        kind = _kind(annotation, value)
        if kind is not None:
            yield Entry(path, kind, _ros_value(value), _descriptor(info, kind, read_only))


def _is_read_only(info: FieldInfo) -> bool:
    extra = info.json_schema_extra
    return isinstance(extra, dict) and bool(extra.get('read_only', False))


def _kind(annotation: Any, value: Any) -> Parameter.Type | None:
    """Return the ROS type of a value; None for what ROS parameters cannot carry."""
    origin = get_origin(annotation)
    arguments = get_args(annotation)
    if origin in (Union, types.UnionType):
        inner = [argument for argument in arguments if argument is not type(None)]
        return _kind(inner[0], value) if len(inner) == 1 else _kind(type(value), value)
    if origin is Literal:
        return _SCALARS.get(type(arguments[0]))
    if origin in (tuple, list, frozenset) or (origin and isinstance(value, (tuple, list))):
        element = arguments[0] if arguments else str
        if get_origin(element) is Literal:
            element = type(get_args(element)[0])
        if isinstance(element, type) and issubclass(element, Enum):
            element = str
        return _ARRAYS.get(element)
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return Parameter.Type.STRING
    return _SCALARS.get(annotation)


def _ros_value(value: Any) -> Any:
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, (tuple, list, frozenset)):
        items = sorted(value) if isinstance(value, frozenset) else value
        return [_ros_value(item) for item in items]
    return value


def _descriptor(info: FieldInfo, kind: Parameter.Type, read_only: bool) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=info.description or '', read_only=read_only, type=kind.value
    )
    if get_origin(info.annotation) is Literal:
        words = ', '.join(str(word) for word in get_args(info.annotation))
        descriptor.additional_constraints = f'one of: {words}'
    lower, upper = _bounds(info)
    if lower is None and upper is None:
        return descriptor
    if kind in (Parameter.Type.DOUBLE, Parameter.Type.DOUBLE_ARRAY):
        most = sys.float_info.max
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-most if lower is None else float(lower),
                to_value=most if upper is None else float(upper),
            )
        ]
    elif kind in (Parameter.Type.INTEGER, Parameter.Type.INTEGER_ARRAY):
        descriptor.integer_range = [
            IntegerRange(
                from_value=_INT64[0] if lower is None else int(lower),
                to_value=_INT64[1] if upper is None else int(upper),
                step=0,
            )
        ]
    return descriptor


def _bounds(info: FieldInfo) -> tuple[Any, Any]:
    lower = upper = None
    for item in info.metadata:
        if isinstance(item, annotated_types.Ge):
            lower = item.ge
        elif isinstance(item, annotated_types.Gt):
            lower = item.gt
        elif isinstance(item, annotated_types.Le):
            upper = item.le
        elif isinstance(item, annotated_types.Lt):
            upper = item.lt
    return lower, upper
