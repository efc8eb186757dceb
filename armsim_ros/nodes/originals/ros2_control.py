# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The verbs of ``ros2 control`` that launch files execute."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import sys

from controller_manager_msgs.srv import SwitchController
from rclpy.node import Node

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ControllerError
from armsim_ros.nodes.spawner.main import run_client
from armsim_ros.nodes.spawner.manager_client import ManagerClient
from armsim_ros.nodes.spawner.parameter_files import entries_of

#: How long a command waits for the manager to appear [s].
MANAGER_TIMEOUT = 20.0
#: How long the manager may take for one answer [s].
CALL_TIMEOUT = 10.0


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are those of the package."""

    def error(self, message: str) -> None:  # type: ignore[override]  # it raises, too
        raise UsageError(f'{message}\n{self.format_usage().strip()}')


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run one verb.

    :param argv: the words after ``ros2 control``; those of this process where None.
    :returns: 0 when it is done, 1 where the manager refuses.
    :raises UsageError: the words are not those of a verb.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(words)
    verb: Callable[[ManagerClient, argparse.Namespace], str] = options.verb

    def work(node: Node) -> None:
        manager = ManagerClient(node, options.controller_manager, CALL_TIMEOUT)
        manager.wait(MANAGER_TIMEOUT)
        print(verb(manager, options), flush=True)

    return run_client('ros2_control', ros_args, work)


def _load_controller(manager: ManagerClient, options: argparse.Namespace) -> str:
    name = options.controller_name
    if name not in manager.states():
        if options.param_file:
            file = Path(options.param_file).resolve()
            if not file.is_file():
                raise ControllerError(f"parameter file '{file}' does not exist")
            entries = entries_of(name, manager.namespace, [str(file)])
            values: dict[str, object] = {'params_file': [str(file)]}
            if entries.type:
                values['type'] = entries.type
            manager.set_parameters({f'{name}.{key}': value for key, value in values.items()})
        manager.load(name)
    if options.set_state:
        manager.configure(name)
    if options.set_state == 'active':
        manager.switch(activate=[name], strictness=SwitchController.Request.BEST_EFFORT)
    state = f' into state {options.set_state}' if options.set_state else ''
    return f'Successfully loaded controller {name}{state}'


def _unload_controller(manager: ManagerClient, options: argparse.Namespace) -> str:
    manager.unload(options.controller_name)
    return f'Successfully unloaded controller {options.controller_name}'


def _set_controller_state(manager: ManagerClient, options: argparse.Namespace) -> str:
    name, wanted = options.controller_name, options.state
    state = manager.states().get(name)
    effort = SwitchController.Request.BEST_EFFORT
    if state is None:
        raise ControllerError(f'controller {name} does not seem to be loaded')
    if (state, wanted) == ('unconfigured', 'inactive'):
        manager.configure(name)
        return f'Successfully configured {name}'
    if (state, wanted) == ('active', 'inactive'):
        manager.switch(deactivate=[name], strictness=effort)
        return f'Successfully deactivated {name}'
    if (state, wanted) == ('inactive', 'active'):
        manager.switch(activate=[name], strictness=effort)
        return f'Successfully activated {name}'
    if (state, wanted) == ('inactive', 'unconfigured'):
        manager.cleanup(name)
        return f'Successfully cleaned up {name}'
    raise ControllerError(f"cannot put {name} in '{wanted}' state from its current state {state}")


def _switch_controllers(manager: ManagerClient, options: argparse.Namespace) -> str:
    strictness = 0  # the manager's default
    if options.strict or options.best_effort:
        request = SwitchController.Request
        strictness = request.STRICT if options.strict else request.BEST_EFFORT
    manager.switch(
        activate=options.activate, deactivate=options.deactivate, strictness=strictness,
        asap=options.activate_asap, timeout=options.switch_timeout)
    return 'Successfully switched controllers'


def _set_hardware_component_state(manager: ManagerClient, options: argparse.Namespace) -> str:
    name = options.hardware_component_name
    state = manager.set_hardware_state(name, options.state)
    if state != options.state:
        raise ControllerError(f"hardware component {name} stays in state '{state}'")
    return f'Successfully set {name} to state {state}'


def _parser() -> _Parser:
    parser = _Parser(prog='ros2 control', add_help=False)
    verbs = parser.add_subparsers(required=True, metavar='VERB', parser_class=_Parser)

    def add(function: Callable[[ManagerClient, argparse.Namespace], str], *names: str) -> _Parser:
        verb: _Parser = verbs.add_parser(function.__name__.strip('_'), add_help=False)
        verb.set_defaults(verb=function)
        for name in names:
            verb.add_argument(name)
        verb.add_argument('-c', '--controller-manager', default='/controller_manager')
        verb.add_argument('--spin-time')
        verb.add_argument('-s', '--use-sim-time', action='store_true')
        return verb

    load = add(_load_controller, 'controller_name')
    load.add_argument('param_file', nargs='?')
    load.add_argument('--set-state', choices=['inactive', 'active'])
    add(_unload_controller, 'controller_name')
    states = ['unconfigured', 'inactive', 'active']
    add(_set_controller_state, 'controller_name').add_argument('state', choices=states)
    add(_set_hardware_component_state, 'hardware_component_name').add_argument(
        'state', choices=states)
    switch = add(_switch_controllers)
    for option in ('--activate', '--deactivate'):
        switch.add_argument(option, nargs='*', default=[])
    for option in ('--strict', '--best-effort', '--activate-asap'):
        switch.add_argument(option, action='store_true')
    switch.add_argument('--switch-timeout', type=float, default=5.0)
    return parser
