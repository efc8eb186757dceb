# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge program: the robot for clients without ROS."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
import gc
from importlib.util import find_spec
import sys
from typing import TYPE_CHECKING

from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.robot_program import StopSignals

if TYPE_CHECKING:
    from armsim_ros.nodes.bridge.configuration import Interface

#: What it is made with, all of the extra ``bridge``.
NEEDED = ('websockets', 'cbor2')
#: How long a busy thread, such as that of ROS, keeps the sockets' thread waiting, which lets it
#: run at each read and write [s].
_SWITCH = 0.0005
MISSING = ("the bridge needs the Python package '{}', which is not installed; "
           "python3 -m pip install 'armsim_ros[bridge]'")


def missing_package() -> str:
    """Return the name of a package that the bridge needs and that is not there, or ''."""
    return next((name for name in NEEDED if find_spec(name) is None), '')


def foxglove_bridge(argv: Sequence[str]) -> int:
    """Serve Foxglove alone, as foxglove_bridge does and with its parameters."""
    # Not for bringup, which only looks whether the bridge can run.
    from armsim_ros.nodes.bridge.configuration import FOXGLOVE_BRIDGE

    return _serve(argv, FOXGLOVE_BRIDGE)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    :param argv: the arguments after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error.
    """
    from armsim_ros.nodes.bridge.configuration import BRIDGE

    return _serve(sys.argv[1:] if argv is None else argv, BRIDGE)


def _serve(words: Sequence[str], interface: Interface) -> int:
    if {'-h', '--help'} & set(words):
        print(interface.help_text())
        return 0
    signals = StopSignals()
    try:
        given, ros_args = interface.parse(words)
        missing = missing_package()
        if missing:
            raise ArmsimError(MISSING.format(missing))
        # Slow to import; a signal finds us listening.
        from armsim_ros.nodes.bridge.program import BridgeProgram

        if signals.stop_requested:
            return 0
        program = BridgeProgram(interface, given, ros_args)
        signals.on_stop = program.stop
        gc.freeze()
        sys.setswitchinterval(_SWITCH)
        return asyncio.run(program.run())
    except ArmsimError as error:
        print(f'bridge: {error}', file=sys.stderr, flush=True)
        return USAGE_STATUS
