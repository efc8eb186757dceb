# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The web program: a page in which a person sees the robot and drives it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
import sys
import threading

from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.robot_program import StopSignals
from armsim_ros.nodes.web.arguments import HELP, parse_web_arguments

#: What the page is made with, all of the extra ``web``.
NEEDED = ('viser', 'websockets', 'trimesh')
MISSING = ("the page needs the Python package '{}', which is not installed; "
           "python3 -m pip install 'armsim_ros[web]'")


def missing_package() -> str:
    """Return the name of a package that the page needs and that is not there, or ''."""
    return next((name for name in NEEDED if find_spec(name) is None), '')


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    :param argv: the arguments after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error or without viser.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words):
        print(HELP)
        return 0
    ended = threading.Event()
    signals = StopSignals()
    signals.on_stop = ended.set
    try:
        arguments = parse_web_arguments(words)
        missing = missing_package()
        if missing:
            raise ArmsimError(MISSING.format(missing))
        # Slow to import; a signal finds us listening.
        from armsim_ros.nodes.web.program import WebProgram

        if signals.stop_requested:
            return 0
        return WebProgram(arguments).run(ended)
    except ArmsimError as error:
        print(f'web: {error}', file=sys.stderr, flush=True)
        return USAGE_STATUS
