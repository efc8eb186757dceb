# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The ``armsim`` command, and the entry point of every program of the package."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
import gc
from importlib import import_module
from io import TextIOWrapper
import os
import signal
import sys
from types import FrameType
from typing import TextIO

from armsim_ros.cli.arguments import format_help, split_ros_args
from armsim_ros.cli.environment import (
    add_own_prefix,
    announce_often,
    ensure_log_folder,
    leave_generator_out,
)
from armsim_ros.cli.programs import (
    FILE_PROGRAMS,
    LEARNING_PROGRAMS,
    main_of,
    PROGRAMS,
    PURPOSES,
    ROBOT_PROGRAMS,
    ROS2_COMMANDS,
)
from armsim_ros.errors import ArmsimError, nearest, USAGE_STATUS

_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_WITHOUT_LOG = {*FILE_PROGRAMS, *LEARNING_PROGRAMS}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run ``armsim PROGRAM [argument ...]``.

    :param argv: the words after ``armsim``; those of this process where None.
    :returns: the exit status.
    """
    if argv is None:
        leave_generator_out()
    words = [*(sys.argv[1:] if argv is None else argv)]
    if not words or words[0] in ('-h', '--help'):
        _print(_overview())
        return 0 if words else USAGE_STATUS
    name, *rest = words
    if name == '--version':
        _print(f'armsim_ros {_version()}')
        return 0
    if name not in PROGRAMS:
        hint = nearest(name, tuple(PROGRAMS)) or f"known: {', '.join(PROGRAMS)}"
        if command := ROS2_COMMANDS.get(name):
            hint = f"the command is '{command}'"
        _print(f"armsim: unknown program '{name}'; {hint}", sys.stderr)
        return USAGE_STATUS
    return start_program(name, rest)


def start_program(program: str, argv: Sequence[str] | None = None) -> int:
    """
    Run a program: import it, call its ``main``, turn what it raises into an exit status.

    :param program: a name of ``PROGRAMS``.
    :param argv: the words after the program's name; those of this process where None.
    :returns: the program's status; 2 after a user's error; 128 and the number of a signal that the
        program did not handle (0 for bringup), such as SIGPIPE after ``| head``.
    """
    if argv is None:
        leave_generator_out()
    words = [*(sys.argv[1:] if argv is None else argv)]
    if program in ROBOT_PROGRAMS and {'-h', '--help'} & set(split_ros_args(words)[0]):
        _print(format_help(program, PROGRAMS[program]))
        return _say_xacro_help(program, words)
    if isinstance(sys.stdout, TextIOWrapper):  # a locale may lack the degree sign
        sys.stdout.reconfigure(errors='replace')
    add_own_prefix()
    announce_often()
    if program not in _WITHOUT_LOG and (report := ensure_log_folder()):
        _print(f'{program}: {report}', sys.stderr)

    def status(number: int) -> int:
        return 0 if program == 'bringup' else 128 + number

    def leave(number: int, _frame: FrameType | None) -> None:
        """End at once: an interrupted import would show a useless traceback."""
        os._exit(status(number))

    try:
        usual = {number: signal.signal(number, leave) for number in _STOP_SIGNALS}
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOP_SIGNALS)
        module, _, function = main_of(program).partition(':')
        start = getattr(import_module(module), function)
        if program not in ROBOT_PROGRAMS:
            # The others import more before they take the signals over themselves.
            for number, handler in usual.items():
                signal.signal(number, handler)
        ended = int(start(words))
        sys.stdout.flush()
        return ended
    except BrokenPipeError:
        _stop_printing()
        return 128 + signal.SIGPIPE
    except ArmsimError as error:
        _print(f'{program}: {error}', sys.stderr)
        return USAGE_STATUS
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition('.')[0] == 'armsim_ros':
            raise
        _print(_missing_module(program, error.name), sys.stderr)
        return 1
    except ImportError as error:
        library, found, _ = str(error).partition(': cannot open shared object file')
        if not found:
            raise
        package = {'libgomp.so.1': ' (Debian, Ubuntu: apt install libgomp1)'}.get(library, '')
        _print(f"{program}: the system library '{library}' is missing; install it{package}",
             sys.stderr)
        return 1
    except RuntimeError as error:
        if 'log directory' not in str(error):
            raise
        _print(f'{program}: {str(error).partition(", at ")[0]}; set ROS_LOG_DIR to a folder that '
             'can be written', sys.stderr)
        return USAGE_STATUS
    except KeyboardInterrupt:
        return status(signal.SIGINT)
    finally:
        # The interpreter would search all it has loaded for cycles once more, up to a second
        # in which the user waits for the end.
        gc.freeze()


# The entry points of setup.py, by the names of their programs; colcon makes an executable of each.
globals().update({program: partial(start_program, program) for program in PROGRAMS})


def _say_xacro_help(program: str, words: Sequence[str]) -> int:
    """Print the arguments of the xacro of the robot that is named, and return the status."""
    if {*split_ros_args(words)[0]} <= {'-h', '--help'}:
        return 0
    from armsim_ros.cli.settings import xacro_help

    try:
        text = xacro_help(split_ros_args(words)[0])
    except ArmsimError as error:
        _print(f'{program}: {error}', sys.stderr)
        return USAGE_STATUS
    if text:
        _print(f'\n{text}')
    return 0


def _overview() -> str:
    width = max(map(len, PROGRAMS))
    lines = ['usage: armsim PROGRAM [argument ...] [--ros-args ...]', '       armsim --version']
    for purpose, names in PURPOSES.items():
        lines += ['', f'{purpose}:',
                  *(f'  {name:<{width}}  {PROGRAMS[name]}' for name in names)]
    return '\n'.join([*lines, '', 'armsim PROGRAM --help lists the arguments of each'])


def _version() -> str:
    from armsim_ros.resources import own_version

    return own_version()


def _missing_module(program: str, module: str) -> str:
    found = f"{program}: the Python package '{module}' is not installed"
    if sys.platform != 'linux' or os.uname().machine != 'x86_64' or sys.version_info > (3, 14):
        return (f'{found}, and ROS has Python wheels only for Linux on x86_64 with Python 3.10 to '
                '3.13; use such a machine, a container, or a ROS 2 Jazzy installation')
    return (f"{found}; either source a ROS 2 Jazzy installation, or install the extra ros: pip "
            "install --find-links dist 'armsim_ros[ros]' with the wheels of `make dist`, or "
            '`make env` in the source tree')


def _print(text: str, stream: TextIO | None = None) -> None:
    try:
        print(text, file=stream or sys.stdout, flush=True)
    except BrokenPipeError:
        _stop_printing()


def _stop_printing() -> None:
    """Drop what is still buffered: the reader, such as head, has seen enough."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
