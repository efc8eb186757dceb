# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The spawner program."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import signal
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import uninstall_signal_handlers

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.errors import ArmsimError, ControllerError
from armsim_ros.nodes.spawner.arguments import parse_spawner_arguments
from armsim_ros.nodes.spawner.manager_client import ManagerClient
from armsim_ros.nodes.spawner.parameter_files import controller_type


def main(argv: Sequence[str] | None = None) -> int:
    """
    Spawn controllers.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when all are in the wanted state, 1 at the first failure, or with
        ``--keep-going`` after those that could be loaded.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    arguments = parse_spawner_arguments(words)
    name = f'spawner_{arguments.controllers[0]}'
    return run_client(name, ros_args, lambda node: _spawn(node, arguments))


def run_client(name: str, ros_args: Sequence[str], work: Callable[[Node], None]) -> int:
    """
    Run a short-lived client of a manager.

    :param name: the node's name.
    :param work: raises an ArmsimError where it fails.
    :returns: 0, or 1 after a failure, which is logged.
    """
    rclpy.init(args=[name, *ros_args])
    node = Node(name, enable_rosout=False, start_parameter_services=False)
    try:
        work(node)
    except ArmsimError as error:
        node.get_logger().error(str(error))
        return 1
    except (KeyboardInterrupt, ExternalShutdownException):
        return 1
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _spawn(node: Node, arguments: argparse.Namespace) -> None:
    if arguments.controller_ros_args:
        raise ControllerError('--controller-ros-args: controllers cannot be remapped here')
    files = [str(Path(file).resolve()) for file in arguments.param_file]
    for file in files:
        if not Path(file).is_file():
            raise ControllerError(f"parameter file '{file}' does not exist")
    manager = ManagerClient(node, arguments.controller_manager, arguments.service_call_timeout)
    manager.wait(arguments.controller_manager_timeout)
    states = manager.states()
    lost = []
    for name in arguments.controllers:
        try:
            if name in states:
                node.get_logger().warning(f"controller '{name}' is loaded already")
            else:
                _load(node, manager, name, files, arguments)
                states[name] = 'unconfigured'
        except ControllerError as error:
            if not arguments.keep_going or arguments.activate_as_group:
                raise
            node.get_logger().error(str(error))
            lost.append(name)
            continue
        if not arguments.load_only:
            if states[name] in ('unconfigured', 'inactive'):
                manager.configure(name)
                states[name] = 'inactive'
            if not (arguments.inactive or arguments.activate_as_group):
                _activate(node, manager, [name], states, arguments)
    if arguments.activate_as_group and not (arguments.load_only or arguments.inactive):
        _activate(node, manager, arguments.controllers, states, arguments)
    if lost:
        raise ControllerError(f"not loaded: {', '.join(lost)}")
    if arguments.unload_on_kill:
        node.get_logger().info('waiting for the end, to unload the controllers then')
        _wait_and_unload(manager, arguments)


def _load(
    node: Node,
    manager: ManagerClient,
    name: str,
    files: list[str],
    arguments: argparse.Namespace,
) -> None:
    kind = arguments.controller_type or controller_type(name, manager.namespace, files)
    described: dict[str, object] = {}
    if kind:
        described[f'{name}.type'] = kind
    if files:
        described[f'{name}.params_file'] = files
    if described:
        manager.set_parameters(described)
    manager.load(name)
    node.get_logger().info(f"loaded '{name}'")


def _activate(
    node: Node, manager: ManagerClient, names: list[str], states: dict[str, str],
    arguments: argparse.Namespace,
) -> None:
    idle = [name for name in names if states[name] != 'active']
    if idle:
        manager.switch(
            activate=idle, asap=arguments.switch_asap, timeout=arguments.switch_timeout
        )
        states.update(dict.fromkeys(idle, 'active'))
    node.get_logger().info(f'active: {", ".join(names)}')


def _wait_and_unload(manager: ManagerClient, arguments: argparse.Namespace) -> None:
    # Not rclpy's handlers, which would end the context that the unloading needs.
    uninstall_signal_handlers()
    ends = {signal.SIGINT, signal.SIGTERM}
    signal.pthread_sigmask(signal.SIG_BLOCK, ends)
    signal.sigwait(ends)
    unload(manager, arguments.controllers, arguments.switch_timeout)


def unload(manager: ManagerClient, names: Sequence[str], switch_timeout: float) -> None:
    """
    Deactivate and unload controllers.

    :param switch_timeout: [s].
    :raises ControllerError: one is not loaded, or the manager refuses.
    """
    states = manager.states()
    missing = [name for name in names if name not in states]
    if missing:
        loaded = ', '.join(states) or 'none'
        raise ControllerError(f'not loaded: {", ".join(missing)}; loaded: {loaded}')
    active = [name for name in names if states[name] == 'active']
    if active:
        manager.switch(deactivate=active, timeout=switch_timeout)
    for name in names:
        if states[name] != 'unconfigured':
            manager.cleanup(name)
        manager.unload(name)
