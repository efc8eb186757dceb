# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""nav2_common's substitutions for parameter files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import os
from pathlib import Path
import tempfile
from typing import Any

import yaml

from armsim_ros.launch.api.context import (
    as_yaml_value,
    LaunchContext,
    perform_text,
    SomeText,
    Substitution,
)
from armsim_ros.launch.api.substitutions import LaunchConfiguration
from armsim_ros.launch.failures import SubstitutionFailure
from armsim_ros.launch.lookup import check_not_missing

_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_DUMPER = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)


class _NewFile(Substitution):
    """The path of a file that is generated from another."""

    def __init__(self, source_file: SomeText, condition: Any = None) -> None:
        self._source, self._condition = source_file, condition

    def perform(self, context: LaunchContext) -> str:
        path = perform_text(context, self._source)
        check_not_missing(path)
        if self._condition is not None and not self._condition.evaluate(context):
            return path
        try:
            text = Path(path).read_text(encoding='utf-8')
        except OSError as error:
            raise SubstitutionFailure(f"file '{path}' cannot be read: {error.strerror}") from None
        return _keep(context, os.path.basename(path), self.change(context, text, path))

    def change(self, context: LaunchContext, text: str, path: str) -> str:
        """Return the text of the new file."""
        raise NotImplementedError


class ReplaceString(_NewFile):
    """
    The path of a copy of a file with strings replaced.

    :param source_file: the file that is read.
    :param replacements: text -> its replacement.
    """

    def __init__(self, source_file: SomeText, replacements: Mapping[str, SomeText],
                 condition: Any = None) -> None:
        super().__init__(source_file, condition)
        self._replacements = dict(replacements)

    def change(self, context: LaunchContext, text: str, path: str) -> str:
        """Replace."""
        for old, new in self._replacements.items():
            text = text.replace(old, perform_text(context, new))
        return text


class RewrittenYaml(_NewFile):
    """
    The path of a copy of a YAML file with other values.

    :param source_file: the file that is read.
    :param param_rewrites: key, or path of keys with dots -> value.
    :param root_key: a block that everything is put under.
    :param key_rewrites: key -> other key.
    :param value_rewrites: text value -> other value.
    :param convert_types: whether texts become numbers and truths.
    """

    def __init__(
        self, source_file: SomeText, param_rewrites: Mapping[str, Any],
        root_key: SomeText | None = None, key_rewrites: Mapping[str, Any] | None = None,
        value_rewrites: Mapping[str, Any] | None = None, convert_types: bool = False
    ) -> None:
        super().__init__(source_file)
        self._values = dict(param_rewrites)
        self._keys = dict(key_rewrites or {})
        self._texts = dict(value_rewrites or {})
        self._root, self._convert = root_key, convert_types

    def change(self, context: LaunchContext, text: str, path: str) -> str:
        """Rewrite."""
        try:
            content = yaml.load(text, _LOADER)
        except yaml.YAMLError as error:
            raise SubstitutionFailure(f"file '{path}' is not YAML: {error}") from None
        content = content if isinstance(content, dict) else {}
        values = {name: perform_text(context, value) for name, value in self._values.items()}
        for parent, key, place in list(_walk(content)):
            requested = values.get(place, values.get(str(key)))
            if requested is not None:
                parent[key] = as_yaml_value(requested) if self._convert else requested
            elif isinstance(parent[key], str) and parent[key] in self._texts:
                parent[key] = perform_text(context, self._texts[parent[key]])
        known = {place for _, _, place in _walk(content)}
        for name, value in values.items():
            if '.' in name and name not in known:
                _put(content, name.split('.'), as_yaml_value(value) if self._convert else value)
        keys = {old: perform_text(context, new) for old, new in self._keys.items()}
        content = _renamed(content, keys)
        root = perform_text(context, self._root) if self._root is not None else ''
        return str(yaml.dump({root: content} if root else content, Dumper=_DUMPER,
                             sort_keys=False))


class HasNodeParams(Substitution):
    """
    True where a YAML file has parameters of a node.

    :param source_file: the file.
    :param node_name: the node.
    """

    def __init__(self, source_file: SomeText, node_name: str) -> None:
        self._source, self._node = source_file, node_name

    def perform(self, context: LaunchContext) -> str:
        """Look into the file."""
        path = perform_text(context, self._source)
        try:
            content = yaml.load(Path(path).read_text(encoding='utf-8'), _LOADER)
        except (OSError, yaml.YAMLError) as error:
            raise SubstitutionFailure(f"file '{path}' cannot be read: {error}") from None
        return str(self._node in (content or {}))


class LaunchConfigAsBool(LaunchConfiguration):
    """A configuration as True or False."""

    def __init__(self, name: str) -> None:
        super().__init__(name)

    def perform(self, context: LaunchContext) -> str:
        """Return its value as True or False."""
        return str(super().perform(context).strip().lower() in ('true', '1', 'yes', 'on'))


class ParseMultiRobotPose:
    """
    The robots of an argument such as ``robots:="a={x: 1}; b={x: 2}"``.

    :param target_argument: the argument's name.
    """

    def __init__(self, target_argument: str) -> None:
        self._argument = target_argument

    def value(self) -> dict[str, Any]:
        """Return name -> pose."""
        return {}


def _walk(content: Any, path: str = '') -> Iterator[tuple[Any, Any, str]]:
    if isinstance(content, dict):
        for key, value in content.items():
            place = f'{path}.{key}' if path else str(key)
            if isinstance(value, dict):
                yield from _walk(value, place)
            else:
                yield content, key, place


def _put(content: dict[str, Any], keys: list[str], value: Any) -> None:
    for key in keys[:-1]:
        inner = content.get(key)
        if not isinstance(inner, dict):
            inner = content[key] = {}
        content = inner
    content[keys[-1]] = value


def _renamed(content: Any, keys: Mapping[str, str]) -> Any:
    if not isinstance(content, dict):
        return content
    return {keys.get(str(key), key): _renamed(value, keys) for key, value in content.items()}


def _keep(context: LaunchContext, name: str, text: str) -> str:
    if context.engine is not None:
        return context.engine.files.write(name, text)
    with tempfile.NamedTemporaryFile('w', suffix=f'_{name}', delete=False,
                                     encoding='utf-8') as stream:
        stream.write(text)
    return stream.name
