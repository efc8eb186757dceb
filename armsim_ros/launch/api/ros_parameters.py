# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of nodes as launch files write them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import os
from pathlib import Path
from typing import Any, Union

from armsim_ros.launch.api.context import (
    as_yaml_value,
    coerce,
    LaunchContext,
    perform_text,
    SomeText,
    Substitution,
    to_bool,
)
from armsim_ros.launch.failures import LaunchError, Placed
from armsim_ros.launch.process_spec import ParameterSource

#: What launch files annotate their functions with.
SomeParameterFile = Union[SomeText, 'ParameterFile']
SomeParameterValue = Union['ParameterValue', SomeText, int, float, bool, Sequence[Any]]
SomeParametersDict = Mapping[Any, Any]
SomeParameters = Sequence[Union[SomeParameterFile, 'Parameter', SomeParametersDict]]


class ParameterValue(Placed):
    """
    A value with a type.

    :param value: the value, a text, or a substitution.
    :param value_type: None for that of the value, or of a substitution the one that YAML sees.
    """

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self.value, self.value_type = value, value_type

    def evaluate(self, context: LaunchContext) -> Any:
        """
        Return the value.

        :raises LaunchError: where it is not of its type.
        """
        try:
            if is_text(self.value) and (
                    self.value_type is not None or not isinstance(self.value, str)):
                return coerce(perform_text(context, self.value), self.value_type)
            value = plain_value(context, self.value)
            return str(value) if self.value_type is str else value
        except LaunchError as failure:
            raise failure.at(self.where) from None


class Parameter(ParameterValue):
    """
    A name and its value.

    :param name: of the parameter.
    """

    def __init__(self, name: SomeText, value: Any, *, value_type: Any = None, **_kwargs: Any
                 ) -> None:
        super().__init__(value, value_type=value_type)
        self.name = name


class ParameterFile(Placed):
    """
    A file of parameters.

    :param param_file: its path.
    :param allow_substs: whether ``$(var x)`` and such in it are replaced.
    """

    def __init__(self, param_file: SomeText, *, allow_substs: Any = False) -> None:
        self.param_file, self.allow_substs = param_file, allow_substs

    def evaluate(self, context: LaunchContext) -> str:
        """Return the path of the file to read."""
        path = perform_text(context, self.param_file)
        allow = self.allow_substs if isinstance(self.allow_substs, bool) else to_bool(
            perform_text(context, self.allow_substs), 'allow_substs')
        if not allow or not Path(path).is_file():
            return path
        from armsim_ros.launch.syntax import parse_substitution

        text = Path(path).read_text(encoding='utf-8')
        try:
            replaced = perform_text(context, parse_substitution(text))
        except LaunchError as failure:
            raise LaunchError(f"in '{path}': {failure.what}", self.where) from None
        if replaced == text or context.engine is None:
            return path
        return context.engine.files.write(os.path.basename(path), replaced)

    def cleanup(self) -> None:
        """Do nothing: the launch removes its files at its end."""


class ParameterDescription(ParameterValue):
    """The same under an older name."""


def evaluate_parameters(context: LaunchContext, parameters: Any) -> list[ParameterSource]:
    """
    Return the parameters of a node: blocks and files in their order.

    :raises LaunchError: where an item is neither.
    """
    if parameters is None:
        return []
    if isinstance(parameters, (Mapping, ParameterFile)) or is_text(parameters):
        parameters = [parameters]
    found: list[ParameterSource] = []
    for item in parameters:
        if item is None:
            continue
        if isinstance(item, ParameterFile):
            found.append(item.evaluate(context))
        elif isinstance(item, Parameter):
            found.append({perform_text(context, item.name): item.evaluate(context)})
        elif isinstance(item, Mapping):
            found.append(evaluate_block(context, item))
        elif is_text(item) or isinstance(item, os.PathLike):
            found.append(perform_text(context, item))
        elif isinstance(item, Iterable):
            found += evaluate_parameters(context, item)
        else:
            raise LaunchError(f"a parameter of a node is '{item}' of type "
                                f'{type(item).__name__}; allowed: a mapping, or the path of a '
                                'file')
    return found


def normalize_parameters(parameters: Any) -> tuple[Any, ...]:
    """
    Return the parameters of a node as evaluate_parameters takes them.

    :raises TypeError: where they are not a list.
    """
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise TypeError(f'Expecting list of parameters, got {parameters}')
    return tuple(parameters)


def evaluate_block(context: LaunchContext, block: Mapping[Any, Any], prefix: str = ''
                   ) -> dict[str, Any]:
    """Return a block of parameters; names of blocks inside it are joined with dots."""
    found: dict[str, Any] = {}
    for key, value in block.items():
        name = prefix + (key if isinstance(key, str) else perform_text(
            context, key if not isinstance(key, (int, float)) else str(key)))
        if isinstance(value, Mapping):
            found.update(evaluate_block(context, value, f'{name}.'))
        else:
            found[name] = plain_value(context, value)
    return found


def plain_value(context: LaunchContext, value: Any) -> Any:
    """Return a parameter's value, substitutions with the type that YAML sees in them."""
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if isinstance(value, Substitution):
        return _typed(perform_text(context, value))
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, (list, tuple)):
        if value and _has_substitution(value) and all(
                is_text(item) for item in value) and not all(
                isinstance(item, (list, tuple)) for item in value):
            return _typed(perform_text(context, value))
        return _uniform([plain_value(context, item) for item in value])
    return value


def _uniform(values: list[Any]) -> list[Any]:
    """Return a list with the integers among floats as floats: a parameter has one type."""
    kinds = {type(value) for value in values}
    return [float(value) for value in values] if kinds == {int, float} else values


def _typed(text: str) -> Any:
    if '\n' in text or len(text) > 1000:
        # A robot description; reading it as YAML takes long and gives a text, or fails.
        return text
    value = as_yaml_value(text)
    return _uniform(value) if isinstance(value, list) else value


def is_text(value: Any) -> bool:
    """Return whether a value is a text, a substitution, or several in a row."""
    if isinstance(value, (str, Substitution)):
        return True
    return isinstance(value, (list, tuple)) and bool(value) and all(
        isinstance(item, (str, Substitution)) or is_text(item) for item in value) and \
        _has_substitution(value)


def _has_substitution(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return any(_has_substitution(item) for item in value)
    return isinstance(value, Substitution)
