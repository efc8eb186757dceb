# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reads launch files in Python, XML and YAML, also with what users' packages add to them."""

from __future__ import annotations

from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import re
from types import ModuleType
from typing import Any, TypeVar

import yaml

from armsim_ros.errors import ConfigError, Location
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.failures import InvalidLaunchFileError, LaunchError
from armsim_ros.launch.lookup import current_lookup
from armsim_ros.launch.parser import Parser
from armsim_ros.launch.syntax import Element, is_ros1, translate
from armsim_ros.model.description.xml_tree import parse_xml, XmlElement

XML_ENDINGS = ('.xml', '.launch', '.test')
YAML_ENDINGS = ('.yaml', '.yml')


def read_launch_file(path: Path) -> LaunchDescription:
    """
    Return the description in a launch file; its code runs.

    :raises InvalidLaunchFileError: where it is not a launch file.
    """
    path = path.absolute()
    current_lookup().beside(path)
    if path.suffix == '.py':
        return _of_python(path)
    if path.suffix in XML_ENDINGS or path.suffix in YAML_ENDINGS:
        return read_frontend_file(path)
    raise InvalidLaunchFileError('this is not a launch file by its name', Location(str(path)))


def load_python_file(path: Path) -> ModuleType:
    """Run a Python file and return it as a module, which is not cached."""
    name = re.sub(r'\W', '_', f'launch_file_{path.stem}')
    spec = spec_from_file_location(name, path, loader=SourceFileLoader(name, str(path)))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _of_python(path: Path) -> LaunchDescription:
    module = load_python_file(path)
    make = getattr(module, 'generate_launch_description', None)
    if make is None:
        raise InvalidLaunchFileError('the launch file has no function '
                                     'generate_launch_description()', Location(str(path)))
    made = make()
    if not hasattr(made, 'visit'):
        raise InvalidLaunchFileError(
            f'generate_launch_description() returned {type(made).__name__}; allowed: a '
            'LaunchDescription', Location(str(path)))
    if not isinstance(made, LaunchDescription):
        return LaunchDescription([made])
    return made


def read_frontend_file(path: Path) -> LaunchDescription:
    """
    Return the description in an XML or YAML file.

    :raises InvalidLaunchFileError: where it is none.
    """
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidLaunchFileError(f'cannot be read: {error}', Location(str(path))) from None
    is_yaml = path.suffix in YAML_ENDINGS
    root = _of_yaml(text, path) if is_yaml else _of_xml(text, path)
    if root.type_name != 'launch':
        raise InvalidLaunchFileError(f'the root element is <{root.type_name}>; allowed: <launch>',
                                     root.where)
    if not is_yaml and is_ros1(root):
        root = translate(root)
    return Parser().parse_description(root)


def _of_xml(text: str, path: Path) -> Element:
    try:
        root = parse_xml(text, str(path))
    except ConfigError as error:
        problem = error.problems[0]
        raise InvalidLaunchFileError(problem.what, problem.where) from None
    return _element(root)


def _element(xml: XmlElement) -> Element:
    return Element(xml.tag, xml.attributes, [_element(child) for child in xml.children],
                   xml.where)


class _Lines(yaml.SafeLoader):
    """Keeps the line of every mapping."""


def _mapping(loader: Any, node: Any) -> dict[Any, Any]:
    content: dict[Any, Any] = loader.construct_mapping(node, deep=True)
    content['__line__'] = node.start_mark.line + 1
    return content


_Lines.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def _of_yaml(text: str, path: Path) -> Element:
    try:
        content = yaml.load(text, _Lines)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        raise InvalidLaunchFileError(
            f"this is not YAML: {getattr(error, 'problem', error)}",
            Location(str(path), mark.line + 1 if mark else None)) from None
    if not isinstance(content, dict) or 'launch' not in content:
        raise InvalidLaunchFileError("the file has no list 'launch:'", Location(str(path)))
    return Element('launch', {}, _children(content['launch'], path), Location(str(path), 1))


def _children(content: Any, path: Path) -> list[Element]:
    found: list[Element] = []
    for item in content or ():
        if not isinstance(item, dict):
            raise LaunchError(f"'{item}' is not an action", Location(str(path)))
        line = item.get('__line__')
        for name, body in item.items():
            if name != '__line__':
                found.append(_of_body(str(name), body, path, line))
    return found


def _of_body(name: str, body: Any, path: Path, line: Any) -> Element:
    """Return an action: lists of blocks are children, all else are attributes."""
    where = Location(str(path), line)
    if isinstance(body, list):
        return Element(name, {}, _children(body, path), where)
    if not isinstance(body, dict):
        return Element(name, {} if body is None else {'value': body}, [], where, is_typed=True)
    attributes: dict[str, Any] = {}
    children: list[Element] = []
    for key, value in body.items():
        if key == '__line__':
            continue
        if isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            if key == 'children':
                children += _children(value, path)
            else:
                children += [_of_body(str(key), item, path, item.get('__line__'))
                             for item in value]
        elif isinstance(value, dict):
            children.append(_of_body(str(key), value, path, value.get('__line__')))
        else:
            attributes[str(key)] = value
    return Element(name, attributes, children, where, is_typed=True)


_T = TypeVar('_T')


def expose_action(name: str) -> Callable[[_T], _T]:
    """Return a decorator that lets files use an action under a name."""
    return _into(Parser.actions, name)


def expose_substitution(name: str) -> Callable[[_T], _T]:
    """Return a decorator that lets files use a substitution under a name."""
    return _into(Parser.substitutions, name)


def _into(table: dict[str, Any], name: str) -> Callable[[_T], _T]:
    def keep(exposed: _T) -> _T:
        table[name] = exposed
        return exposed

    return keep
