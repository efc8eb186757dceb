# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How programs of this package, and others, are started as children."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import ctypes
import os
from pathlib import Path
import signal
import sys
import sysconfig

import armsim_ros
from armsim_ros.cli.environment import BRINGUP_PID

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
        traceback (``armsim_ros.cli.main.run``).
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
