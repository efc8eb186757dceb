# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ExecuteProcess: a process of any kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
import os
import re
import shlex
from typing import Any

from armsim_ros.launch.api.context import (
    Action,
    LaunchContext,
    LaunchDescriptionEntity,
    normalize_to_list_of_entities,
    normalize_to_list_of_substitutions,
    perform_text,
    SomeText,
    to_bool,
)
from armsim_ros.launch.api.event_handlers import Shutdown
from armsim_ros.launch.failures import LaunchError
from armsim_ros.launch.process_spec import ProcessSpec, program_of


class Executable:
    """
    The command of a process and its environment.

    :param cmd: its words, each a text, a substitution, or several in a row.
    """

    def __init__(
        self, *, cmd: Iterable[SomeText], prefix: SomeText | None = None,
        name: SomeText | None = None, cwd: SomeText | None = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None, arguments: Iterable[SomeText] = (),
    ) -> None:
        self.cmd = [normalize_to_list_of_substitutions(word) for word in (*cmd, *arguments)]
        self.prefix, self.name, self.cwd = prefix, name, cwd
        self.env, self.additional_env = env, additional_env


class ExecuteLocal(Action):
    """
    Starts a process.

    :param process_description: what it runs.
    :param on_exit: what is done when it has ended.
    """

    def __init__(
        self, *, process_description: Executable | None = None, shell: bool = False,
        sigterm_timeout: Any = '5', sigkill_timeout: Any = '5', emulate_tty: Any = False,
        output: Any = 'log', output_format: str = '[{this.process_description.final_name}] {line}',
        cached_output: bool = False, log_cmd: bool = False, on_exit: Any = None,
        respawn: Any = False, respawn_delay: Any = None, respawn_max_retries: Any = -1,
        **kwargs: Any
    ) -> None:
        super().__init__(condition=kwargs.pop('condition', None))
        if kwargs:
            raise TypeError(f"{type(self).__name__} has no argument '{next(iter(kwargs))}'")
        self._executable = process_description or Executable(cmd=[])
        self._shell = shell
        self._timeouts = sigterm_timeout, sigkill_timeout
        self._emulate_tty, self._output = emulate_tty, output
        self._on_exit = on_exit
        self._respawn, self._respawn_delay = respawn, respawn_delay
        self._respawn_max_retries = respawn_max_retries
        self.process_details: dict[str, Any] | None = None
        self.return_code: int | None = None

    @property
    def process_description(self) -> Executable:
        """The process's command and environment."""
        return self._executable

    @property
    def name(self) -> str | None:
        """The name in the log, once it is started."""
        return self.process_details['name'] if self.process_details is not None else None

    @property
    def cmd(self) -> Any:
        """The words of the command."""
        return self._executable.cmd

    @property
    def ends_launch(self) -> bool:
        """Whether the launch ends with it."""
        return not callable(self._on_exit) and any(
            isinstance(entity, Shutdown) for entity in normalize_to_list_of_entities(
                [self._on_exit] if self._on_exit is not None else ()))

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the actions for its exit."""
        if self._on_exit is None or callable(self._on_exit):
            return []
        return [('its end', normalize_to_list_of_entities([self._on_exit]))]

    def describe(self) -> str:
        """Return a description for messages."""
        words = [' + '.join(part.describe() for part in word) for word in self._executable.cmd]
        return f"{type(self).__name__}(cmd=[{', '.join(words)}])"

    def execute(self, context: LaunchContext) -> None:
        """Start it."""
        if context.engine is None or context.is_shutdown:
            return
        context.engine.start_process(self, self.spec(context))

    def spec(self, context: LaunchContext) -> ProcessSpec:
        """
        Return the process with all substitutions performed.

        :raises LaunchError: where an option has a value that it cannot have.
        """
        made = self._executable
        words = [perform_text(context, word) for word in made.cmd]
        if not words:
            raise LaunchError('a process without a command', self.where)
        environment = dict(context.environment)
        if made.env is not None:
            environment = _variables(context, made.env)
        if made.additional_env is not None:
            environment.update(_variables(context, made.additional_env))
        name = perform_text(context, made.name) if made.name is not None else ''
        term, kill = (self._seconds(context, timeout, 5.0) for timeout in self._timeouts)
        return ProcessSpec(
            command=words, environment=environment, name=name or program_of(words, self._shell),
            cwd=perform_text(context, made.cwd) if made.cwd is not None else None,
            shell=self._flag(context, self._shell, 'shell'), output=self._output_words(context),
            emulate_tty=self._flag(context, self._emulate_tty, 'emulate_tty'),
            respawn=self._flag(context, self._respawn, 'respawn'),
            respawn_delay=self._seconds(context, self._respawn_delay, 0.0),
            respawn_max_retries=int(self._seconds(context, self._respawn_max_retries, -1.0)),
            sigterm_timeout=term, sigkill_timeout=kill,
            prefix=shlex.split(self._prefix(context, words[0])))

    def ended(self, context: LaunchContext, event: Any) -> list[LaunchDescriptionEntity]:
        """Return the actions for its exit."""
        self.return_code = event.returncode
        requested = self._on_exit
        if callable(requested) and not isinstance(requested, LaunchDescriptionEntity):
            requested = requested(event, context)
        return normalize_to_list_of_entities([requested]) if requested is not None else []

    def started(self, name: str, pid: int, spec: ProcessSpec) -> None:
        """Store the details of its process."""
        self.process_details = {'name': name, 'cmd': spec.command, 'pid': pid, 'cwd': spec.cwd,
                                'env': spec.environment}

    def _prefix(self, context: LaunchContext, program: str) -> str:
        given = self._executable.prefix
        if given is not None:
            return perform_text(context, given)
        settings = context.launch_configurations
        matches = re.match(settings.get('launch-prefix-filter', ''), os.path.basename(program))
        return str(settings.get('launch-prefix', '')) if matches else ''

    def _flag(self, context: LaunchContext, value: Any, name: str) -> bool:
        if isinstance(value, bool):
            return value
        try:
            return to_bool(perform_text(context, value), f"'{name}'")
        except LaunchError as failure:
            raise failure.at(self.where) from None

    def _seconds(self, context: LaunchContext, value: Any, default: float) -> float:
        if value is None:
            return default
        if isinstance(value, (int, float)):
            return float(value)
        text = perform_text(context, value)
        try:
            return float(text)
        except ValueError:
            raise LaunchError(f"'{text}' is not a number", self.where) from None

    def _output_words(self, context: LaunchContext) -> str:
        if isinstance(self._output, Mapping):
            return 'screen'
        return perform_text(context, self._output)


class ExecuteProcess(ExecuteLocal):
    """
    Starts a command as a process.

    :param cmd: its words, each a text, a substitution, or several in a row.
    """

    def __init__(
        self, *, cmd: Iterable[SomeText], prefix: SomeText | None = None,
        name: SomeText | None = None, cwd: SomeText | None = None,
        env: Mapping[Any, Any] | None = None,
        additional_env: Mapping[Any, Any] | None = None, **kwargs: Any
    ) -> None:
        words = [cmd] if isinstance(cmd, str) else cmd
        super().__init__(process_description=Executable(
            cmd=words, prefix=prefix, name=name, cwd=cwd, env=env,
            additional_env=additional_env), **kwargs)


def _variables(context: LaunchContext, given: Mapping[Any, Any]) -> dict[str, str]:
    return {perform_text(context, name): perform_text(
        context, str(value) if isinstance(value, (bool, int, float)) else value)
        for name, value in given.items()}
