# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Checked settings as declared ROS parameters, and their changes back into checked settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
import math
import types
from typing import Any, Generic, get_args, get_origin, Literal, TypeVar, Union

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
    A parameter.

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


def _of_model(model: BaseModel, path: tuple[str, ...], read_only: bool) -> Iterator[Entry]:
    for name, info in type(model).model_fields.items():
        key = (*path, info.alias or name)
        fixed = read_only or _is_read_only(info)
        yield from _of_value(getattr(model, name), info.annotation, info, key, fixed)
    for name, value in (model.model_extra or {}).items():
        yield from _of_value(value, type(value), FieldInfo(), (*path, name), read_only)


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
        if isinstance(element, type) and issubclass(element, (Enum, BaseModel)):
            element = str
        return _ARRAYS.get(element)
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return Parameter.Type.STRING
    return _SCALARS.get(annotation)


def _ros_value(value: Any) -> Any:
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, BaseModel):
        return str(getattr(value, 'name', value))  # a list of named blocks shows their names
    if isinstance(value, (tuple, list, frozenset)):
        items = sorted(value) if isinstance(value, frozenset) else value
        return [_ros_value(item) for item in items]
    return value


def _descriptor(info: FieldInfo, kind: Parameter.Type, read_only: bool) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=info.description or '', read_only=read_only, type=kind.value)
    if get_origin(info.annotation) is Literal:
        words = ', '.join(str(word) for word in get_args(info.annotation))
        descriptor.additional_constraints = f'one of: {words}'
    lower, upper = _bounds(info)
    if lower is None and upper is None:
        return descriptor
    if kind in (Parameter.Type.DOUBLE, Parameter.Type.DOUBLE_ARRAY):
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-math.inf if lower is None else float(lower),
                to_value=math.inf if upper is None else float(upper))
        ]
    elif kind in (Parameter.Type.INTEGER, Parameter.Type.INTEGER_ARRAY):
        descriptor.integer_range = [
            IntegerRange(
                from_value=_INT64[0] if lower is None else int(lower),
                to_value=_INT64[1] if upper is None else int(upper), step=0)
        ]
    return descriptor


def _bounds(info: FieldInfo) -> tuple[Any, Any]:
    lower: Any = None
    upper: Any = None
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
        self, node: Node, settings: SettingsT, changed: Callable[[SettingsT], None] | None = None,
        objection: Callable[[SettingsT], str] | None = None
    ) -> None:
        """Declare all parameters; values from ``--ros-args`` win over the settings'."""
        self.settings, self._changed, self._objection = settings, changed, objection
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
