# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whole numbers where ROS 2 wants a double; its nodes refuse to start with them."""

from __future__ import annotations

from collections.abc import Iterator
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints, Union

from pydantic import BaseModel

from armsim_ros.config.yaml.node import YamlNode


def real_number_edits(kind: Any, node: YamlNode) -> dict[tuple[int, int], str]:
    """
    Return place -> text with a decimal point, of every whole number that is to be a double.

    :param kind: what the node is checked as: a settings class, or ``dict[str, X]``.
    """
    return {(inner.where.line, inner.where.column): _with_point(inner)
            for inner in _whole_numbers(kind, node)
            if inner.where.line is not None and inner.where.column is not None}


def _whole_numbers(kind: Any, node: YamlNode) -> Iterator[YamlNode]:
    if get_origin(kind) in (Union, UnionType):
        kind = next((member for member in get_args(kind) if member is not type(None)), kind)
    if kind is float:
        if isinstance(node.value, int) and not isinstance(node.value, bool):
            yield node
        return
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        extra = get_type_hints(kind).get('__pydantic_extra__')
        for key, inner in node.entries.items():
            field = kind.model_fields.get(key)
            yield from _whole_numbers(field.annotation if field else _values_of(extra), inner)
        return
    for inner in (*node.entries.values(), *node.items):
        yield from _whole_numbers(_values_of(kind), inner)


def _values_of(annotation: Any) -> Any:
    """Return X of ``dict[str, X]`` or ``tuple[X, ...]``; of a text the class is not known."""
    arguments = [argument for argument in get_args(annotation) if argument is not Ellipsis]
    return arguments[-1] if arguments else None


def _with_point(node: YamlNode) -> str:
    return f'{node.text}.0' if node.text.lstrip('+-').isdigit() else repr(float(str(node.value)))
