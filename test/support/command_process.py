# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What runs in the process of the tests' ros2 commands: one process saves each its imports."""

from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
import io
import os

from armsim_ros.cli.environment import FASTDDS_PROFILES
from armsim_ros2 import session
from armsim_ros2.main import run


def prepare(environment: Mapping[str, str]) -> None:
    """Take over an environment, with the package's settings of Fast DDS."""
    os.environ.update(environment)
    for name in FASTDDS_PROFILES:
        os.environ.pop(name, None)


def run_in(folder: str, words: tuple[str, ...], patience: float) -> tuple[int, str, str]:
    """
    Run a command in a folder; return its status, output and errors.

    :param patience: how long it waits for a name that it does not find [s].
    """
    os.chdir(folder)
    session.PATIENCE.update({True: patience, False: patience})
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        status = run(words)
    return status, out.getvalue(), err.getvalue()
