# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of the page's program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.serving.arguments import read_values
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
