# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The single values of nested settings: names, types, ranges and texts of ROS parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
import math
import types
from typing import Any, get_args, get_origin, Literal, Union

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
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
        description=info.description or '', read_only=read_only, type=kind.value
    )
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
                to_value=math.inf if upper is None else float(upper),
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
