# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The web program: a page in which a person sees the robot and drives it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
import sys
import threading

from armsim_ros.cli.arguments import UsageError
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.ports import read_values
from armsim_ros.nodes.robot_program import StopSignals
from armsim_ros.packages import split_path

PORT = 8080
HELP = f"""usage: armsim web [NAME:=VALUE ...] [--ros-args ...]

serve the page that shows and moves the robot in a browser

arguments (--name VALUE is the same as name:=VALUE):
  port:=NUMBER            the first port to try (default: {PORT})
  host:=ADDRESS           the address to listen on (default: 127.0.0.1, this machine only)
  token:=WORD             token that browsers must send; made if other machines can reach the page
  packages_path:=DIR:...  folders that are searched first for packages with meshes
  near:=FILE:...          files of the robot; packages in their workspace are found
  --ros-args ...          remappings, as for any ROS 2 program"""


@dataclass(frozen=True)
class WebArguments:
    """
    The page's arguments, checked.

    :param packages_path: folders that ``package://`` searches first.
    :param near: files around which packages are found.
    """

    port: int = PORT
    host: str = '127.0.0.1'
    token: str = ''
    packages_path: tuple[Path, ...] = ()
    near: tuple[Path, ...] = ()
    ros_args: tuple[str, ...] = field(default=())


def parse_web_arguments(argv: Sequence[str]) -> WebArguments:
    """
    Read the command line.

    :raises UsageError: names the known arguments.
    """
    known = ('port', 'host', 'token', 'packages_path', 'near')
    values, ros_args = read_values(argv, known)
    port = values.get('port', str(PORT))
    if not port.isascii() or not port.isdigit() or not 1 <= int(port) <= 65535:
        raise UsageError(f"port is '{port}'; allowed: a number from 1 to 65535")
    return WebArguments(
        port=int(port), host=values.get('host', '127.0.0.1'), token=values.get('token', ''),
        packages_path=split_path(values.get('packages_path', '')),
        near=split_path(values.get('near', '')), ros_args=ros_args)


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
