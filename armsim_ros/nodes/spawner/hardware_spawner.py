# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The hardware_spawner program."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.nodes.spawner.arguments import add_manager_options
from armsim_ros.nodes.spawner.main import run_client
from armsim_ros.nodes.spawner.manager_client import ManagerClient

#: Time for an answer of the manager [s].
_CALL_TIMEOUT = 10.0


def main(argv: Sequence[str] | None = None) -> int:
    """
    Configure or activate hardware components.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0, also after a warning of a component that is not there or does not change its
        state; 1 where no manager answers.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    parser = argparse.ArgumentParser(
        prog='hardware_spawner', description='Configure or activate hardware components.')
    parser.add_argument('components', nargs='+', metavar='NAME', help='of a hardware component')
    state = parser.add_mutually_exclusive_group(required=True)
    state.add_argument('--activate', dest='state', action='store_const', const='active',
                       help='configure and activate the components')
    state.add_argument('--configure', dest='state', action='store_const', const='inactive',
                       help='configure the components')
    add_manager_options(parser)
    options = parser.parse_args(words)
    return run_client('hardware_spawner', ros_args, lambda client: _set_states(client, options))


def _set_states(client: RosClient, options: argparse.Namespace) -> None:
    log = client.node.get_logger()
    manager = ManagerClient(client, options.controller_manager, _CALL_TIMEOUT)
    manager.wait(options.controller_manager_timeout)
    known = manager.hardware_states()
    for name in options.components:
        if name not in known:
            log.warning(
                f"no hardware component '{name}' is loaded; loaded: {', '.join(known) or 'none'}")
        elif (state := manager.set_hardware_state(name, options.state)) != options.state:
            log.warning(
                f"hardware component '{name}' is {state} and does not become {options.state}")
        else:
            log.info(f"hardware component '{name}' is {state}")
