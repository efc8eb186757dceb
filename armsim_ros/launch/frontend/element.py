# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An element of a launch file, the same for XML and YAML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from armsim_ros.errors import Location
from armsim_ros.launch.api.utilities import coerce
from armsim_ros.launch.failures import LaunchError


class Element:
    """
    Attributes and children.

    :param name: of the element.
    :param attributes: texts; in YAML also numbers, truths and lists.
    :param where: its line.
    """

    def __init__(
        self, name: str, attributes: Mapping[str, Any], children: Sequence[Element] = (),
        where: Location | None = None,
    ) -> None:
        self.type_name = name
        self.attributes = dict(attributes)
        self.children = list(children)
        self.where = where
        self.read: set[str] = set()

    def all(self, name: str) -> list[Element]:
        """Return the children of a name."""
        return [child for child in self.children if child.type_name == name]

    def get_attr(self, name: str, *, data_type: Any = str, optional: bool = False,
                 can_be_str: bool = True) -> Any:
        """
        Return an attribute, or the children of a name where a list is asked for.

        :raises LaunchError: where it is required but missing.
        """
        self.read.add(name)
        if data_type is list or getattr(data_type, '__origin__', None) is list:
            found = self.all(name)
            if found or name not in self.attributes:
                if not found and not optional:
                    raise LaunchError(f'<{self.type_name}> needs <{name}> inside', self.where)
                return found or None
        if name in self.attributes:
            value = self.attributes[name]
            return value if data_type is str else coerce(value, data_type)
        if optional:
            return None
        raise LaunchError(f"<{self.type_name}> needs the attribute '{name}'", self.where)

    def text(self, name: str) -> str | None:
        """Return an attribute as a text, None where it is not there."""
        value = self.get_attr(name, optional=True)
        if value is None:
            return None
        if isinstance(value, bool):
            return str(value).lower()
        return str(value)

    def assert_entity_completely_parsed(self) -> None:
        """Do nothing: unread attributes are not an error."""
