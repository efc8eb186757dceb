# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that hold or repeat others, call the user's functions or print a line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import inspect
import logging
import os
from pathlib import Path
from typing import Any

import yaml

from armsim_ros.launch.api.configuration import (
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetLaunchConfiguration,
)
from armsim_ros.launch.api.context import (
    Action,
    entities_of_result,
    LaunchContext,
    LaunchDescriptionEntity,
    normalize_to_list_of_entities,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
    SomeText,
)
from armsim_ros.launch.failures import LaunchError

Entities = list[LaunchDescriptionEntity]


class GroupAction(Action):
    """
    Actions with a common condition and scope.

    :param scoped: whether configurations and environment end with the group.
    :param forwarding: whether it begins with the configurations and environment around it.
    :param launch_configurations: set at its begin.
    """

    def __init__(
        self, actions: Iterable[Any], *, scoped: bool = True, forwarding: bool = True,
        launch_configurations: Mapping[Any, Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._actions = normalize_to_list_of_entities(actions)
        self._scoped, self._forwarding = scoped, forwarding
        self._configurations = dict(launch_configurations or {})

    def get_sub_entities(self) -> Entities:
        """Return the actions."""
        return self._actions

    def describe_sub_entities(self) -> Entities:
        """Return the actions if the group has no condition."""
        return self._actions if self.condition is None else []

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the actions if the group has a condition."""
        return [] if self.condition is None else [('a condition', self._actions)]

    def execute(self, context: LaunchContext) -> Entities:
        """Return the actions between the begin and the end of the scope."""
        settings: Entities = [SetLaunchConfiguration(name, value)
                              for name, value in self._configurations.items()]
        if not self._scoped:
            return [*settings, *self._actions]
        if not self._forwarding:
            settings = [ResetEnvironment(), ResetLaunchConfigurations(self._configurations)]
        return [PushLaunchConfigurations(), PushEnvironment(), *settings, *self._actions,
                PopEnvironment(), PopLaunchConfigurations()]


class OpaqueFunction(Action):
    """
    A function of the user, called when it is visited.

    :param function: is called with the context, ``args`` and ``kwargs``; may return entities.
    """

    def __init__(
        self, *, function: Callable[..., Any], args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None, **left_over: Any
    ) -> None:
        super().__init__(**left_over)
        self._function = function
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})

    def execute(self, context: LaunchContext) -> Entities | None:
        """Call it."""
        result = self._function(context, *self._args, **self._kwargs)
        if inspect.iscoroutine(result):
            result.close()
            raise LaunchError('the function is a coroutine; use OpaqueCoroutine', self.where)
        return entities_of_result(result, self.where)


class OpaqueCoroutine(Action):
    """
    A coroutine of the user, run by the event loop.

    :param coroutine: is called with the context, ``args`` and ``kwargs``.
    """

    def __init__(
        self, *, coroutine: Callable[..., Any], args: Iterable[Any] | None = None,
        kwargs: Mapping[str, Any] | None = None, ignore_context: bool = False, **left_over: Any,
    ) -> None:
        super().__init__(**left_over)
        self._coroutine = coroutine
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})
        self._ignore_context = ignore_context

    def execute(self, context: LaunchContext) -> None:
        """Have the event loop run it."""
        first = () if self._ignore_context else (context,)
        if context.engine is not None:
            context.engine.run_coroutine(
                self, self._coroutine(*first, *self._args, **self._kwargs))


class ForLoop(Action):
    """
    Calls a function for each number.

    :param length: how often, a text.
    :param function: is called with the number, returns entities.
    """

    def __init__(
        self, length: SomeText, *, function: Callable[..., Any] | None = None,
        name: str | None = None, entities: Iterable[Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._length, self._function, self._name = length, function, name
        self._entities = normalize_to_list_of_entities(entities or ())

    def execute(self, context: LaunchContext) -> Entities:
        """Return the entities of every round."""
        text = perform_text(context, self._length)
        try:
            count = int(text)
        except ValueError:
            raise LaunchError(f"the length of a ForLoop is '{text}'; allowed: a whole number",
                                self.where) from None
        return [entity for number in range(count) for entity in self._round(number)]

    def _round(self, number: int) -> Entities:
        if self._function is not None:
            return entities_of_result(self._function(number), self.where) or []
        return [_ExtendLocals({self._name or 'i': number}), *self._entities]


class ForEach(Action):
    """
    Calls a function for each set of values.

    :param input_values: blocks of YAML, parted by semicolons.
    :param function: is called with the values of a block by name, returns entities.
    """

    def __init__(
        self, input_values: SomeText, *, function: Callable[..., Any] | None = None,
        entities: Iterable[Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._values, self._function = input_values, function
        self._entities = normalize_to_list_of_entities(entities or ())

    def execute(self, context: LaunchContext) -> Entities:
        """Return the entities of every round."""
        found: Entities = []
        for text in perform_text(context, self._values).split(';'):
            if not text.strip():
                continue
            try:
                values = yaml.safe_load(text)
            except yaml.YAMLError as error:
                raise LaunchError(f"values of ForEach: '{text}' is not YAML: {error}",
                                    self.where) from None
            values = values if isinstance(values, dict) else {}
            if self._function is not None:
                requested = inspect.signature(self._function).parameters
                given = {name: values[name] for name in requested if name in values}
                found += entities_of_result(self._function(**given), self.where) or []
            else:
                found += [_ExtendLocals(values), *self._entities]
        return found


class _ExtendLocals(Action):
    """Sets values of the scope."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        super().__init__()
        self._values = dict(values)

    def execute(self, context: LaunchContext) -> None:
        context.extend_locals(self._values)


class LogInfo(Action):
    """
    Prints a line.

    :param msg: the text.
    """

    level = 'INFO'

    def __init__(self, *, msg: SomeText, **kwargs: Any) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._msg = normalize_to_list_of_substitutions(msg)
        if isinstance(kwargs.get('level'), str):
            self.level = kwargs['level'].upper()

    def execute(self, context: LaunchContext) -> None:
        """Print it."""
        text = perform_substitutions(context, self._msg)
        if context.engine is not None:
            context.engine.log(self.level, text, 'launch.user')


class Log(LogInfo):
    """Logs a line at a level."""


class LogDebug(LogInfo):
    """Logs a line at debug level."""

    level = 'DEBUG'


class LogWarning(LogInfo):
    """Logs a warning."""

    level = 'WARNING'


class LogError(LogInfo):
    """Logs an error."""

    level = 'ERROR'


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger that prints as launch does."""
    logger = logging.getLogger(f'launch.{name}' if name else 'launch')
    if not logging.getLogger('launch').handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter('[%(levelname)s] [%(name)s]: %(message)s'))
        top = logging.getLogger('launch')
        top.addHandler(handler)
        top.setLevel(logging.INFO)
        top.propagate = False
    return logger


def get_output_loggers(process_name: str, output_config: Any) -> tuple[Any, Any]:
    """Return the loggers of a process's two streams."""
    return get_logger(f'{process_name}-stdout'), get_logger(f'{process_name}-stderr')


class launch_config:  # noqa: N801 - launch's own name
    """The settings of the logging."""

    level = logging.INFO
    log_dir = os.environ.get('ROS_LOG_DIR', str(Path.home() / '.ros' / 'log'))

    @classmethod
    def get_log_file_path(cls, file_name: str = 'launch.log') -> str:
        """Return the path of a log file."""
        return os.path.join(cls.log_dir, file_name)
