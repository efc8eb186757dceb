# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 launch``: armsim_ros's launch program, if it is in this environment."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import sys

from armsim_ros2.errors import CliError
from armsim_ros2.packages import is_program


def run(argv: Sequence[str]) -> int:
    """
    Become ``armsim launch``.

    :raises CliError: armsim_ros is not in this environment.
    """
    armsim = Path(sys.prefix, 'bin', 'armsim')
    if not is_program(armsim):
        raise CliError(f'there is no {armsim}; install armsim_ros into this environment')
    os.execv(armsim, [str(armsim), 'launch', *argv])
