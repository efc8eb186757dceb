# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Events of a launch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Event:
    """Something that happened."""

    name = 'launch.Event'


class Shutdown(Event):
    """
    The launch is to end.

    :param due_to_sigint: whether the user pressed Ctrl-C.
    :param due_to_failure: whether a required process failed.
    """

    name = 'launch.events.Shutdown'

    def __init__(
        self, *, reason: str = 'reason not given', due_to_sigint: bool = False,
        due_to_failure: bool = False, **_kwargs: Any
    ) -> None:
        self.reason, self.due_to_sigint = reason, due_to_sigint
        self.due_to_failure = due_to_failure


class TimerEvent(Event):
    """A time has passed."""

    name = 'launch.events.TimerEvent'


class IncludeLaunchDescription(Event):
    """
    A description is to be visited.

    :param launch_description: the description.
    """

    name = 'launch.events.IncludeLaunchDescription'

    def __init__(self, launch_description: Any) -> None:
        self.launch_description = launch_description


class ExecutionComplete(Event):
    """
    An action has come to its end.

    :param action: the action.
    """

    name = 'launch.events.ExecutionComplete'

    def __init__(self, *, action: Any) -> None:
        self.action = action


class RunningProcessEvent(Event):
    """
    Something happened to a process.

    :param action: the action that it belongs to.
    """

    name = 'launch.events.process.RunningProcessEvent'

    def __init__(
        self, *, action: Any, name: str = '', cmd: list[str] | None = None,
        cwd: str | None = None, env: dict[str, str] | None = None, pid: int = 0, **_kwargs: Any,
    ) -> None:
        self.action, self.process_name = action, name
        self.cmd = list(cmd or ())
        self.cwd, self.env, self.pid = cwd, env, pid


class ProcessStarted(RunningProcessEvent):
    """A process runs."""

    name = 'launch.events.process.ProcessStarted'


class ProcessExited(RunningProcessEvent):
    """
    A process has ended.

    :param returncode: its exit status; negative after a signal.
    """

    name = 'launch.events.process.ProcessExited'

    def __init__(self, *, returncode: int = 0, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.returncode = returncode


class ProcessIO(RunningProcessEvent):
    """
    A process has printed something.

    :param text: what.
    :param fd: 1 for standard output, 2 for standard error.
    """

    name = 'launch.events.process.ProcessIO'

    def __init__(self, *, text: bytes = b'', fd: int = 1, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.text, self.fd = text, fd
        self.from_stdin, self.from_stdout, self.from_stderr = fd == 0, fd == 1, fd == 2


class ProcessStdin(ProcessIO):
    """Something is to be written to a process."""


class ProcessStdout(ProcessIO):
    """A process has printed to standard output."""


class ProcessStderr(ProcessIO):
    """A process has printed to standard error."""


class ProcessTargetedEvent(Event):
    """
    An event that is addressed to some processes.

    :param process_matcher: returns whether an action's process is meant.
    """

    name = 'launch.events.process.ProcessTargetedEvent'

    def __init__(self, *, process_matcher: Callable[[Any], bool]) -> None:
        self.process_matcher = process_matcher


class ShutdownProcess(ProcessTargetedEvent):
    """Processes are to be shut down."""

    name = 'launch.events.process.ShutdownProcess'


class SignalProcess(ProcessTargetedEvent):
    """
    A signal is to be sent to processes.

    :param signal_number: a number or name.
    """

    name = 'launch.events.process.SignalProcess'

    def __init__(self, *, signal_number: Any, process_matcher: Callable[[Any], bool]) -> None:
        super().__init__(process_matcher=process_matcher)
        self.signal = signal_number


class ChangeState(Event):
    """
    A lifecycle node is to change its state.

    :param lifecycle_node_matcher: returns whether a node is meant.
    :param transition_id: of lifecycle_msgs/Transition.
    """

    name = 'launch_ros.events.lifecycle.ChangeState'

    def __init__(self, *, lifecycle_node_matcher: Callable[[Any], bool], transition_id: int
                 ) -> None:
        self.lifecycle_node_matcher, self.transition_id = lifecycle_node_matcher, transition_id


class StateTransition(Event):
    """
    A lifecycle node has changed its state.

    :param action: the node.
    """

    name = 'launch_ros.events.lifecycle.StateTransition'

    def __init__(self, *, action: Any, msg: Any = None, goal_state: str = '',
                 start_state: str = '') -> None:
        self.action, self.msg, self.goal_state = action, msg, goal_state
        self.start_state = start_state


def matches_action(action: Any) -> Callable[[Any], bool]:
    """Return a matcher of an action's process."""
    return lambda other: other is action


def matches_executable(executable: str) -> Callable[[Any], bool]:
    """Return a matcher of running processes by the end of their command's first word."""
    return lambda action: _details(action, 'cmd', [''])[0].endswith(executable)


def matches_name(name: str) -> Callable[[Any], bool]:
    """Return a matcher of processes by name."""
    return lambda action: str(getattr(action, 'name', '')).startswith(name)


def matches_pid(pid: int) -> Callable[[Any], bool]:
    """Return a matcher of a process by its id."""
    return lambda action: _details(action, 'pid', 0) == pid


def _details(action: Any, key: str, missing: Any) -> Any:
    return (getattr(action, 'process_details', None) or {}).get(key, missing)


def matches_node_name(node_name: str) -> Callable[[Any], bool]:
    """Return a matcher of nodes by name."""
    return lambda action: getattr(action, 'node_name', '') == node_name
