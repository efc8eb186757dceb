# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What programs get from the one that starts them, and how they end."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from contextlib import suppress
import ctypes
import os
from pathlib import Path
import signal
import sys
import sysconfig
from tempfile import gettempdir

import armsim_ros

AMENT_PREFIX_PATH = 'AMENT_PREFIX_PATH'
#: Process id of the bringup that started a program.
BRINGUP_PID = 'ARMSIM_BRINGUP_PID'
#: Where Fast DDS looks for a user's settings; the second name is that of later versions.
FASTDDS_PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
#: What Fast DDS sends by, unless its settings name something else.
FASTDDS_TRANSPORTS = ('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')


def add_own_prefix(environment: MutableMapping[str, str] = os.environ) -> None:
    """
    Let ament find the packages that pip installed into this interpreter's environment.

    A sourced ROS installation sets ``AMENT_PREFIX_PATH``, pip does not; without it
    ament_index_python refuses to look anything up. The prefix comes last: what the user
    sourced is found first.

    :param environment: the variables to change.
    """
    own = str(Path(sys.prefix))
    known = [entry for entry in environment.get(AMENT_PREFIX_PATH, '').split(os.pathsep) if entry]
    has_packages = Path(own, 'share', 'ament_index', 'resource_index', 'packages').is_dir()
    if own not in known and (has_packages or not known):
        environment[AMENT_PREFIX_PATH] = os.pathsep.join([*known, own])


def leave_generator_out() -> None:
    """
    Keep the generator of message classes out of this process.

    The type support of every message imports it, and with it a parser, where that is possible
    (rosidl_generator_py/__init__.py): an eighth of the processor time of a small command, for
    what only a build uses.
    """
    # In Python's documentation: None in sys.modules makes the import fail.
    sys.modules.setdefault('rosidl_generator_py.generate_py_impl', None)  # type: ignore[arg-type]


def announce_often(environment: MutableMapping[str, str] = os.environ) -> None:
    """
    Let Fast DDS announce this process often, so that nodes find each other in 0.3 s, not in 3 s.

    Its messages go through sockets. Fast DDS 2.14 loses messages in shared memory while other
    participants come and go, answers of services among them. With the discovery range LOCALHOST,
    rmw_fastrtps adds shared memory by itself (participant.cpp, create_participant).

    The user's own settings are left alone. Other middlewares read nothing of it.

    :param environment: the variables to change.
    """
    if any(environment.get(name) for name in FASTDDS_PROFILES):
        return
    if not Path('DEFAULT_FASTRTPS_PROFILES.xml').is_file():
        environment[FASTDDS_PROFILES[0]] = str(Path(__file__).with_name('fastdds_profiles.xml'))
        environment.setdefault(*FASTDDS_TRANSPORTS)


def ensure_log_folder(environment: MutableMapping[str, str] = os.environ) -> str:
    """
    Let ROS log to a temporary folder if ~/.ros/log cannot be written.

    A folder that the user names by ROS_LOG_DIR or ROS_HOME is left alone.

    :param environment: the variables to change.
    :returns: a message about the change, '' if there is none.
    """
    if environment.get('ROS_LOG_DIR') or environment.get('ROS_HOME'):
        return ''
    usual = Path(environment.get('HOME') or '/nonexistent', '.ros', 'log')
    if _can_write(usual):
        return ''
    folder = Path(gettempdir(), f'armsim_{os.getuid()}', 'log')
    if not _can_write(folder) or folder.parent.stat().st_uid != os.getuid():
        return ''
    environment['ROS_LOG_DIR'] = str(folder)
    return f"cannot write logs to '{usual}'; writing them to '{folder}' (set ROS_LOG_DIR)"


def _can_write(folder: Path) -> bool:
    """Make a folder where it is missing, and return whether files can be written to it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def started_by_bringup(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether this process's parent is a bringup, and so another program runs beside it."""
    return environment.get(BRINGUP_PID) == str(os.getppid())


#: From linux/prctl.h.
_PR_SET_PDEATHSIG = 1


def program_command(program: str, arguments: Sequence[str]) -> list[str]:
    """Return the words that start a program of this package with this interpreter."""
    safe_path = ['-P'] if sys.version_info >= (3, 11) else []
    return [sys.executable, *safe_path, '-m', 'armsim_ros', program, *arguments]


def child_environment() -> dict[str, str]:
    """Return the environment in which a child imports the same armsim_ros and does not buffer."""
    environment = dict(os.environ, PYTHONUNBUFFERED='1', **{BRINGUP_PID: str(os.getpid())})
    if sys.stderr.isatty():
        environment.setdefault('RCUTILS_COLORIZED_OUTPUT', '1')
    root = str(Path(armsim_ros.__file__).resolve().parent.parent)
    if root not in (sysconfig.get_path('purelib'), sysconfig.get_path('platlib')):
        known = [entry for entry in environment.get('PYTHONPATH', '').split(os.pathsep) if entry]
        environment['PYTHONPATH'] = os.pathsep.join([root, *known])
    return environment


def die_with_parent(*, holds_sigint: bool = True) -> Callable[[], None]:
    """
    Return what runs in the child before the program: a tie to this process's life.

    :param holds_sigint: for programs of this package: SIGINT waits until they can end without a
        traceback (``armsim_ros.cli.main.start_program``).
    """
    libc = ctypes.CDLL(None, use_errno=True)
    parent = os.getpid()

    def prepare() -> None:
        libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
        # A shell's background job ignores SIGINT, and so would all it starts.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if holds_sigint:
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

    return prepare


def signal_group(leader: int, number: int) -> None:
    """Send a signal to a process and all that it started in its group, if there are any left."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, number)


class StopLadder:
    """
    What a program gets that does not end: SIGINT, then SIGTERM, then SIGKILL.

    :param sigterm: when, after SIGINT [s].
    :param sigkill: when, after SIGINT [s].
    """

    def __init__(self, sigterm: float, sigkill: float) -> None:
        self.rungs = ((0.0, signal.SIGINT), (sigterm, signal.SIGTERM), (sigkill, signal.SIGKILL))
        self._taken = 0

    def due(self, elapsed: float) -> Iterator[signal.Signals]:
        """Yield the signals that have come due [s] and were not yielded before."""
        while self._taken < len(self.rungs) and self.rungs[self._taken][0] <= elapsed:
            self._taken += 1
            yield self.rungs[self._taken - 1][1]


#: Begins each line of a refusal that a bringup reads: the ASCII record separator.
MARK = '\x1e'


def refuse(text: str) -> None:
    """Write why the program does not run to standard error; where that is full, do not wait."""
    mark = MARK if started_by_bringup() else ''
    with suppress(OSError):
        print('\n'.join(mark + line for line in text.splitlines()), file=sys.stderr, flush=True)


class QuietEnd:
    """
    Ends the process before its libraries report leaks.

    OMPL's bindings print a page about that, below what the user should read.

    :param status: of the process; None lets it end as usual.
    """

    def __init__(self, status: int | None = None) -> None:
        self.status = status
        atexit.register(self._leave)

    def _leave(self) -> None:
        if self.status is not None:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(self.status)
