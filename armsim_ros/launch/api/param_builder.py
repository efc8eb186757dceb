# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""launch_param_builder: parameters from a package's files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from typing_extensions import Self
import yaml

from armsim_ros.install_rules.xacro_run import XacroCommand
from armsim_ros.launch.api.substitutions.programs import run_xacro
from armsim_ros.launch.failures import LaunchError
from armsim_ros.launch.lookup import current_lookup


class ParameterBuilderFileNotFoundError(KeyError):
    """A file of parameters does not exist."""


def load_file(file_path: Any) -> str:
    """
    Return the text of a file.

    :raises ParameterBuilderFileNotFoundError: where it does not exist.
    """
    try:
        return Path(file_path).read_text(encoding='utf-8')
    except OSError:
        raise ParameterBuilderFileNotFoundError(f"file '{file_path}' does not exist") from None


def load_yaml(file_path: Any) -> Any:
    """
    Return the content of a YAML file.

    :raises ParameterBuilderFileNotFoundError: where it does not exist.
    :raises LaunchError: where it is not YAML.
    """
    text = load_file(file_path)
    try:
        return yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        raise LaunchError(f"file '{file_path}' is not YAML: {error}") from None


def load_xacro(file_path: Any, mappings: Mapping[str, Any] | None = None) -> str:
    """Return the output of xacro for a file."""
    if not Path(file_path).is_file():
        raise ParameterBuilderFileNotFoundError(f"file '{file_path}' does not exist")
    words = {name: str(value) for name, value in (mappings or {}).items()}
    return run_xacro(XacroCommand(str(file_path), words), None)


def get_path(file_path: Any) -> Path:
    """Return a value as a path."""
    return Path(file_path)


class ParameterBuilder:
    """
    Parameters of a node, collected.

    :param package_name: whose files are read.
    """

    def __init__(self, package_name: str) -> None:
        self._package_path = current_lookup().share(package_name)
        self._parameters: dict[str, Any] = {}

    def yaml(self, file_path: Any, parameter_namespace: str | None = None) -> Self:
        """Add a YAML file, without the node names around its parameters."""
        content = load_yaml(self._package_path / file_path) or {}
        for block in _blocks_of_nodes(content):
            content = {**{key: value for key, value in content.items()
                          if not isinstance(value, dict) or 'ros__parameters' not in value},
                       **block}
        self._add(content, parameter_namespace)
        return self

    def file_parameter(self, parameter_name: str, file_path: Any) -> Self:
        """Add the text of a file as a parameter."""
        self._parameters[parameter_name] = load_file(self._package_path / file_path)
        return self

    def xacro_parameter(self, parameter_name: str, file_path: Any,
                        mappings: Mapping[str, Any] | None = None) -> Self:
        """Add the output of xacro for a file as a parameter."""
        self._parameters[parameter_name] = load_xacro(self._package_path / file_path, mappings)
        return self

    def parameter(self, parameter_name: str, parameter_value: Any) -> Self:
        """Add a parameter."""
        self._parameters[parameter_name] = parameter_value
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return them."""
        return self._parameters

    def _add(self, content: Mapping[str, Any], namespace: str | None) -> None:
        if namespace is None:
            self._parameters.update(content)
        else:
            self._parameters.setdefault(namespace, {}).update(content)


class _Loader(yaml.SafeLoader):
    """Reads angles with a unit, as MoveIt's files write them."""


def _angle(factor: float) -> Any:
    def read(loader: Any, node: Any) -> float:
        text = str(loader.construct_scalar(node))
        return float(text) * factor
    return read


_Loader.add_constructor('!degrees', _angle(0.017453292519943295))
_Loader.add_constructor('!radians', _angle(1.0))


def _blocks_of_nodes(content: Any) -> list[dict[str, Any]]:
    if not isinstance(content, dict):
        return []
    return [value['ros__parameters'] for value in content.values()
            if isinstance(value, dict) and isinstance(value.get('ros__parameters'), dict)]
