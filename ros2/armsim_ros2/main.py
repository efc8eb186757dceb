# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The entry point: finds the command without importing ROS and reports failures."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

from armsim_ros2.errors import CliError
from armsim_ros2.handover import hand_over
from armsim_ros2.packages import package_prefixes
from armsim_ros2.parsing import listing, run_verb, unknown, USAGE_STATUS

#: Command -> one line of help. Each is a module of ``commands`` with VERBS, or with run(argv).
COMMANDS = {
    'action': 'actions: list, type, info, send_goal',
    'bag': 'recordings: record, play, info',
    'control': 'controllers and hardware of a controller manager',
    'daemon': 'there is no daemon; for compatibility',
    'doctor': 'check the installation, the middleware and the graph',
    'interface': 'definitions of messages, services and actions',
    'launch': 'run a launch file',
    'lifecycle': 'states of lifecycle nodes',
    'node': 'nodes: list, info',
    'param': 'parameters: list, get, set, describe, dump, load, delete',
    'pkg': 'installed packages',
    'run': 'run a program of a package',
    'service': 'services: list, type, info, find, call, echo',
    'topic': 'topics: list, echo, pub, info, type, find, hz, bw, delay',
}
#: Commands of a ROS installation that this distribution does not have -> why.
ABSENT = {
    'component': 'component containers are C++ programs of rclcpp_components',
    'multicast': 'it is part of ros2multicast; `ros2 doctor` checks multicast',
    'security': 'it is part of sros2',
    'test': 'it is part of ros_testing; pytest runs tests of this environment',
    'trace': 'it is part of ros2_tracing',
}
SIGINT_STATUS = 2
SIGTERM_STATUS = 128 + signal.SIGTERM
_PIPE_STATUS = 128 + signal.SIGPIPE


def main() -> NoReturn:
    """Run ``ros2`` with the arguments of this process and end it."""
    # The type support of messages would import the generator of their classes, and a parser.
    sys.modules.setdefault(
        'rosidl_generator_py.generate_py_impl', None)  # type: ignore[arg-type] # makes it fail
    status = _status(sys.argv[1:])
    sys.stderr.flush()
    # The node has left the graph; at a usual end Fast DDS waits 0.1 s
    # (DomainParticipantFactory::~DomainParticipantFactory).
    os._exit(status)


def _status(argv: Sequence[str]) -> int:
    try:
        try:
            hand_over(argv)
            signal.signal(signal.SIGTERM, _terminate)
            if hasattr(sys.stdout, 'reconfigure'):
                sys.stdout.reconfigure(line_buffering=True)
            return run(argv)
        except KeyboardInterrupt:
            return SIGINT_STATUS
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # What is still buffered goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _PIPE_STATUS


def run(argv: Sequence[str]) -> int:
    """
    Run a command; a failure is reported on standard error.

    :param argv: the arguments after ``ros2``.
    :returns: the status.
    """
    # ament_index_python finds packages that pip installed only through this variable.
    os.environ['AMENT_PREFIX_PATH'] = os.pathsep.join(map(str, package_prefixes()))
    words = [word for word in argv[:1] if word != '--use-python-default-buffering'] + [*argv[1:]]
    try:
        if not words or words[0] in ('-h', '--help'):
            print(f'usage: ros2 COMMAND ...\n\nCommands:\n{listing(COMMANDS)}\n\n'
                  'Call `ros2 COMMAND -h` for the verbs of a command.')
            return 0
        name, *rest = words
        if name in ABSENT:
            raise CliError(f"'ros2 {name}' is not in this environment: {ABSENT[name]}; it comes "
                           'with a ROS 2 Jazzy installation '
                           '(https://docs.ros.org/en/jazzy/Installation.html)', USAGE_STATUS)
        if name not in COMMANDS:
            raise CliError(unknown('ros2', 'command', name, COMMANDS), USAGE_STATUS)
        command = import_module(f'armsim_ros2.commands.{name}')
        if hasattr(command, 'VERBS'):
            return run_verb(name, COMMANDS[name], command.VERBS, rest)
        return int(command.run(rest))
    except CliError as failure:
        sys.stdout.flush()
        if str(failure):
            print(failure, file=sys.stderr)
        return failure.status


def _terminate(signum: int, frame: FrameType | None) -> None:
    raise SystemExit(SIGTERM_STATUS)
