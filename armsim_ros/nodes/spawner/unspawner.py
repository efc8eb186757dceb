# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The unspawner program."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.nodes.spawner.arguments import parse_unspawner_arguments
from armsim_ros.nodes.spawner.main import run_client, unload
from armsim_ros.nodes.spawner.manager_client import ManagerClient


def main(argv: Sequence[str] | None = None) -> int:
    """
    Deactivate and unload controllers.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when all are gone, 1 at the first failure.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    arguments = parse_unspawner_arguments(words)
    name = f'unspawner_{arguments.controllers[0]}'
    return run_client(name, ros_args, lambda client: _unspawn(client, arguments))


def _unspawn(client: RosClient, arguments: argparse.Namespace) -> None:
    log = client.node.get_logger()
    manager = ManagerClient(client, arguments.controller_manager, arguments.service_call_timeout)
    manager.wait(arguments.controller_manager_timeout)
    unload(manager, arguments.controllers, arguments.switch_timeout)
    log.info(f'unloaded: {", ".join(arguments.controllers)}')
