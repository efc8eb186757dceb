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


def prepare(environment: Mapping[str, str], patience: float) -> None:
    """
    Take over an environment, with the package's settings of Fast DDS.

    :param patience: how long commands wait for a name that they do not find [s].
    """
    os.environ.update(environment)
    for name in FASTDDS_PROFILES:
        os.environ.pop(name, None)
    session.PATIENCE.update({True: patience, False: patience})


def run_in(folder: str, words: tuple[str, ...]) -> tuple[int, str, str]:
    """Run a command in a folder; return its status, output and errors."""
    os.chdir(folder)
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        status = run(words)
    return status, out.getvalue(), err.getvalue()
