# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of the spawner, with the flags of ros2_control's."""

from __future__ import annotations

import argparse
from collections.abc import Sequence


def parse_spawner_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Read the words after the program's name; leaves with status 2 where they are wrong."""
    parser = argparse.ArgumentParser(
        prog='spawner', description='Load, configure and activate controllers.'
    )
    _add_common(parser)
    parser.add_argument(
        '-p', '--param-file', action='append', default=[], metavar='FILE',
        help='file with the parameters, in the layout of ROS 1 or ROS 2; may be repeated',
    )
    parser.add_argument(
        '--load-only', action='store_true', help='load, and leave unconfigured'
    )
    parser.add_argument(
        '--inactive', '--stopped', action='store_true', help='load and configure, do not activate'
    )
    parser.add_argument(
        '-u', '--unload-on-kill', action='store_true',
        help='stay, and deactivate and unload the controllers at the end',
    )
    parser.add_argument(
        '--activate-as-group', action='store_true',
        help='activate all together, at the end, or none',
    )
    parser.add_argument(
        '--keep-going', action='store_true',
        help='where a controller cannot be loaded, spawn the others; the status is 1 all the same',
    )
    parser.add_argument('-t', '--controller-type', default='', help='type of the controllers')
    parser.add_argument(
        '--controller-ros-args', action='append', default=[], metavar='ARGS',
        help='remappings of the controllers; controllers live in the simulation, where no '
        'remapping is possible: refused',
    )
    parser.add_argument(
        '--switch-asap', action=argparse.BooleanOptionalAction, default=True,
        help='activate at the next update',
    )
    return parser.parse_args(list(argv))


def parse_unspawner_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Read the words after the program's name; leaves with status 2 where they are wrong."""
    parser = argparse.ArgumentParser(
        prog='unspawner', description='Deactivate and unload controllers.'
    )
    _add_common(parser)
    return parser.parse_args(list(argv))


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('controllers', nargs='+', metavar='NAME', help='name of a controller')
    parser.add_argument(
        '-c', '--controller-manager', default='controller_manager', metavar='MANAGER',
        help='name of the manager (default: controller_manager)',
    )
    parser.add_argument(
        '--controller-manager-timeout', type=float, default=0.0, metavar='S',
        help='time to wait for the manager [s], 0 is for ever',
    )
    parser.add_argument(
        '--switch-timeout', type=float, default=5.0, metavar='S', help='time for a switch [s]'
    )
    parser.add_argument(
        '--service-call-timeout', type=float, default=10.0, metavar='S',
        help='time for one answer of the manager [s]',
    )
