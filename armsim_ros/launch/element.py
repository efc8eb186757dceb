# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An element of a launch file, the same for XML and YAML, and those of ROS 1 as those of ROS 2."""

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


_MARKS = ('rosparam', 'param', 'machine', 'test', 'env', 'remap')


def is_ros1(root: Element) -> bool:
    """Return whether a file is one of ROS 1: nodes by type, parameters outside of nodes."""
    for child in root.children:
        if child.type_name in _MARKS:
            return True
        if child.type_name == 'node' and 'type' in child.attributes:
            return True
        if any('$(arg ' in str(value) or '$(find ' in str(value)
               for value in child.attributes.values()):
            return True
        if child.type_name in ('group', 'include') and is_ros1(child):
            return True
    return False


def translate(root: Element) -> Element:
    """
    Return the elements translated into those of ROS 2.

    Parameters of the parameter server become those of all nodes after them; files of parameters
    likewise. ``required`` becomes ``on_exit="shutdown"``.
    """
    return Element(root.type_name, root.attributes, [
        translated for child in root.children for translated in _translated(child)], root.where)


def _translated(element: Element) -> list[Element]:
    name, attributes = element.type_name, dict(element.attributes)
    if name in ('machine', 'test'):
        return []
    if name == 'arg':
        if 'value' in attributes:
            return [Element('let', {**attributes}, [], element.where)]
        if 'doc' in attributes:
            attributes['description'] = attributes.pop('doc')
        return [Element('arg', attributes, [], element.where)]
    if name == 'env':
        return [Element('set_env', attributes, [], element.where)]
    if name == 'remap':
        return [Element('set_remap', attributes, [], element.where)]
    if name == 'param':
        return _parameter(element)
    if name == 'rosparam':
        return _file(element)
    children = [inner for child in element.children for inner in _inside(name, child)]
    if name == 'group' and 'ns' in attributes:
        push = Element('push_ros_namespace', {'namespace': attributes.pop('ns')}, [],
                       element.where)
        children.insert(0, push)
    if name == 'include':
        attributes.pop('pass_all_args', None)
        attributes.pop('clear_params', None)
    return [Element(name, attributes, children, element.where)]


def _inside(parent: str, element: Element) -> list[Element]:
    if parent not in ('node', 'include'):
        return _translated(element)
    if parent == 'include' or element.type_name in ('remap', 'env'):
        return [element]
    if element.type_name == 'rosparam':
        file = element.attributes.get('file')
        return [Element('param', {'from': file}, [], element.where)] if file else []
    if element.type_name == 'param':
        return [] if 'value' not in element.attributes else [
            Element('param', {**element.attributes, 'name': _dotted(element)}, [], element.where)]
    return []


def _parameter(element: Element) -> list[Element]:
    value = element.attributes.get('value')
    if 'command' in element.attributes:
        value = f"$(command '{element.attributes['command']}')"
    elif 'textfile' in element.attributes:
        value = f"$(file-content {element.attributes['textfile']})"
    if value is None:
        return []
    kept = _condition(element)
    kind = element.attributes.get('type')
    if 'command' in element.attributes or 'textfile' in element.attributes:
        kind = 'str'
    kinds = {'string': 'str', 'str': 'str', 'double': 'float', 'int': 'int', 'bool': 'bool'}
    if kind in kinds:
        kept['type'] = kinds[kind]
    return [Element('set_parameter', {'name': _dotted(element), 'value': value, **kept}, [],
                    element.where)]


def _file(element: Element) -> list[Element]:
    file = element.attributes.get('file')
    if file is None or element.attributes.get('command', 'load') != 'load':
        return []
    kept = _condition(element)
    return [Element('set_parameters_from_file', {'filename': file, **kept}, [], element.where)]


def _condition(element: Element) -> dict[str, Any]:
    return {key: value for key, value in element.attributes.items() if key in ('if', 'unless')}


def _dotted(element: Element) -> str:
    return str(element.attributes.get('name', '')).strip('/').replace('/', '.')
