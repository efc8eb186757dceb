# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 control``."""

from __future__ import annotations

from argparse import Namespace, REMAINDER
from collections.abc import Callable, Iterable
import os
from pathlib import Path
import sys
from typing import Any

from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.manager import Manager
from armsim_ros2.parsing import argument, Arguments, exclusive, flag, Parser, Verb
from armsim_ros2.session import graph_verb

_BEST_EFFORT, _STRICT = 1, 2
#: Lifecycle state -> number and colour.
_STATES = {'unconfigured': (1, 93), 'inactive': (2, 96), 'active': (3, 92)}
#: Present and target state of a controller -> service (none: a switch), words while and after it.
_TRANSITIONS = {
    ('inactive', 'unconfigured'): ('cleanup_controller', 'cleaning up', 'successfully cleaned up'),
    ('unconfigured', 'inactive'): ('configure_controller', 'configuring',
                                   'Successfully configured'),
    ('active', 'inactive'): ('', 'stopping', 'Successfully deactivated'),
    ('inactive', 'active'): ('', 'activating', 'Successfully activated'),
}
_BLUE, _CYAN, _RED, _YELLOW, _MAGENTA = 94, 96, 91, 93, 95


def _colored(text: str, color: int | None) -> str:
    """Return a text in a colour if the terminal shows colours."""
    setting = os.environ.get('RCUTILS_COLORIZED_OUTPUT')
    wanted = setting == '1' or (setting != '0' and sys.stdout.isatty())
    return f'\033[{color}m{text}\033[0m' if wanted and color else text


def _succeed(text: str) -> int:
    print(_colored(text, _BLUE))
    return 0


def _refuse(text: str) -> int:
    """Report a refusal where upstream does, on standard output."""
    print(_colored(text, _RED))
    return 1


def _list_controllers(manager: Manager, options: Namespace) -> None:
    controllers = manager.controllers()
    if not controllers:
        print('No controllers are currently loaded!')
        return
    widths = [max(len(getattr(entry, name)) for entry in controllers)
              for name in ('name', 'type', 'state')]
    verbose = options.verbose
    exported = options.exported_interfaces or options.reference_interfaces or verbose
    for entry in controllers:
        color = _STATES.get(entry.state, (0, None))[1]
        print(f'{_colored(entry.name.ljust(widths[0]), color)} {entry.type.ljust(widths[1])}  '
              f'{_colored(entry.state.ljust(widths[2]), color)}')
        if verbose:
            print(f'\tupdate_rate: {entry.update_rate} Hz\n\tis_async: {entry.is_async}')
        chained = [f'{name:20s}' for connection in entry.chain_connections
                   for name in connection.reference_interfaces]
        for shown, title, names in (
                (options.claimed_interfaces or verbose, 'claimed interfaces',
                 entry.claimed_interfaces),
                (options.required_command_interfaces or verbose, 'required command interfaces',
                 entry.required_command_interfaces),
                (options.required_state_interfaces or verbose, 'required state interfaces',
                 entry.required_state_interfaces),
                (options.chained_interfaces or verbose, 'chained to interfaces', chained),
                (exported, 'exported reference interfaces', entry.reference_interfaces),
                (exported, 'exported state interfaces', entry.exported_state_interfaces)):
            if shown:
                print(f'\t{title}:')
                for name in names:
                    print(f'\t\t{name}')


def _list_controller_types(manager: Manager, options: Namespace) -> None:
    response = manager.call('list_controller_types')
    for name, base in zip(response.types, response.base_classes, strict=True):
        print(f'{name:70s} {base}')


def _list_hardware_components(manager: Manager, options: Namespace) -> None:
    colors = {1: _YELLOW, 2: _MAGENTA, 3: 92}
    for i, part in enumerate(manager.call('list_hardware_components').component, 1):
        color = colors.get(part.state.id, _RED)
        print(f'Hardware Component {i}\n\tname: {_colored(part.name, color)}\n'
              f'\ttype: {part.type}\n\tplugin name: {part.plugin_name}\n'
              f'\tstate: id={part.state.id} label={_colored(part.state.label, color)}\n'
              f'\tread/write rate: {part.rw_rate} Hz\n\tis_async: {part.is_async}\n'
              '\tcommand interfaces')
        for interface in part.command_interfaces:
            kind = f' [{interface.data_type}]' if options.verbose else ''
            claimed = _colored('[claimed]', _BLUE) if interface.is_claimed else '[unclaimed]'
            print(f'\t\t{interface.name}{kind} {_availability(interface)} {claimed}')
        if options.verbose:
            print('\tstate interfaces')
            for interface in part.state_interfaces:
                print(f'\t\t{interface.name} [{interface.data_type}] {_availability(interface)}')


def _availability(interface: Any) -> str:
    if interface.is_available:
        return _colored('[available]', _BLUE)
    return _colored('[unavailable]', _YELLOW)


def _list_hardware_interfaces(manager: Manager, options: Namespace) -> None:
    response = manager.call('list_hardware_interfaces')
    print('command interfaces')
    for interface in _sorted(response.command_interfaces):
        kind = f' [{interface.data_type}]' if options.verbose else ''
        if not interface.is_available:
            state, color = '[unavailable] [unclaimed]', _YELLOW
        elif interface.is_claimed:
            state, color = '[available] [claimed]', _BLUE
        else:
            state, color = '[available] [unclaimed]', _CYAN
        print('\t' + _colored(f'{interface.name}{kind} {state}', color))
    print('state interfaces')
    for interface in _sorted(response.state_interfaces):
        print(f'\t{interface.name}{f" [{interface.data_type}]" if options.verbose else ""}')


def _sorted(interfaces: Iterable[Any]) -> list[Any]:
    return sorted(interfaces, key=lambda interface: str(interface.name))


def _load_controller(manager: Manager, options: Namespace) -> int:
    name = options.controller_name
    if any(entry.name == name for entry in manager.controllers()):
        print(_colored(f'Controller : {name} already loaded, skipping load_controller!', _YELLOW))
    else:
        if options.param_file:
            file = Path(options.param_file).absolute()
            if not file.is_file():
                return _refuse(f'Controller parameter file : {options.param_file} does not exist, '
                               'Aborting!')
            manager.set_file(name, file)
        if not manager.call('load_controller', name=name).ok:
            return _refuse(f'Failed loading controller {name} check controller_manager logs')
        _succeed(f'Successfully loaded controller {name}')
    if options.set_state is None:
        return 0
    if not manager.call('configure_controller', name=name).ok:
        return _refuse(f'Error configuring controller : {name}')
    if options.set_state == 'active' and not manager.switch([name], []).ok:
        return _refuse(f'Error activating controller : {name}, check controller_manager logs')
    return _succeed(f'Successfully loaded controller {name} into state {options.set_state}')


def _set_controller_state(manager: Manager, options: Namespace) -> None:
    name, target = options.controller_name, options.state
    states = {entry.name: entry.state for entry in manager.controllers()}
    if name not in states:
        raise CliError(f'controller {name} does not seem to be loaded{hint(name, states)}')
    present = states[name]
    if (present, target) not in _TRANSITIONS:
        change = {'unconfigured': f'cleanup {name}', 'active': f'activate {name}'}.get(
            target, f"put {name} in 'inactive' state")
        raise CliError(f'cannot {change} from its current state {present}')
    service, doing, done = _TRANSITIONS[present, target]
    response = (manager.call(service, name=name) if service
                else manager.switch([name], []) if target == 'active'
                else manager.switch([], [name]))
    if not response.ok:
        raise CliError(f'Error {doing} controller, check controller_manager logs')
    print(f'{done} {name}')


def _switch_controllers(manager: Manager, options: Namespace) -> int:
    strictness = _STRICT if options.strict else _BEST_EFFORT if options.best_effort else 0
    response = manager.switch(options.activate, options.deactivate, strictness,
                              options.activate_asap, options.switch_timeout)
    return _succeed(response.message) if response.ok else _refuse(response.message)


def _set_hardware_component_state(manager: Manager, options: Namespace) -> None:
    name = options.hardware_component_name
    known = [part.name for part in manager.call('list_hardware_components').component]
    target = load('lifecycle_msgs/State', 'msg')(id=_STATES[options.state][0], label=options.state)
    response = manager.call('set_hardware_component_state', name=name, target_state=target)
    if not response.ok:
        doing = {'unconfigured': 'cleaning up', 'inactive': 'stopping'}.get(
            options.state, 'activating')
        raise CliError(f'Error {doing} hardware component, check controller_manager logs'
                       + ('' if name in known else hint(name, known)))
    print(f'Successfully set {name} to state {response.state}')


def _reload_controller_libraries(manager: Manager, options: Namespace) -> None:
    if not manager.call('reload_controller_libraries', force_kill=options.force_kill).ok:
        raise CliError('Error reloading libraries, check controller_manager logs')
    print('Reload successful')


def _manager_options(parser: Parser) -> None:
    parser.add_argument('-c', '--controller-manager', metavar='NAME',
                        help='the controller manager (default: controller_manager, or the only '
                             'one in the graph)')
    parser.add_argument('--include-hidden-nodes', action='store_true', help='for compatibility')
    parser.add_argument('--ros-args', nargs=REMAINDER, help='arguments of the node')


def _verb(about: str, run: Callable[[Manager, Namespace], int | None], *arguments: Arguments
          ) -> Verb:
    """Return a verb that calls a controller manager."""
    return graph_verb(about, lambda session, options: run(Manager(session, options), options),
                      *arguments, _manager_options)


def _controller_verb(about: str, service: str, doing: str, done: str) -> Verb:
    """
    Return a verb that calls a service of the manager with the name of a controller.

    :param doing, done: words for a failure and for success.
    """
    def run(manager: Manager, options: Namespace) -> int:
        name = options.controller_name
        if not manager.call(service, name=name).ok:
            return _refuse(f'Error {doing} controller {name}, check controller_manager logs')
        return _succeed(f'Successfully {done} controller {name}')

    return _verb(about, run, _controller)


_controller = argument('controller_name', help='name of the controller')
_state = argument('state', choices=list(_STATES), help='the target state')
_verbose = flag('-v', '--verbose', about='print all details')

VERBS = {
    'cleanup_controller': _controller_verb(
        'bring a controller to unconfigured', 'cleanup_controller', 'cleaning up', 'cleaned up'),
    'list_controller_types': _verb('print the types of controllers', _list_controller_types),
    'list_controllers': _verb(
        'print the loaded controllers', _list_controllers,
        *(flag(f'--{name}', about='print these, too') for name in (
            'claimed-interfaces', 'required-state-interfaces', 'required-command-interfaces',
            'chained-interfaces', 'reference-interfaces', 'exported-interfaces')), _verbose),
    'list_hardware_components': _verb('print the hardware components', _list_hardware_components,
                                      _verbose),
    'list_hardware_interfaces': _verb('print command and state interfaces',
                                      _list_hardware_interfaces, _verbose),
    'load_controller': _verb(
        'load a controller', _load_controller, _controller,
        argument('param_file', nargs='?', help='YAML file with its parameters'),
        argument('--set-state', choices=['inactive', 'active'], help='state to bring it to')),
    'reload_controller_libraries': _verb(
        'reload the libraries of controllers', _reload_controller_libraries,
        flag('--force-kill', about='stop controllers that run')),
    'set_controller_state': _verb('change the state of a controller', _set_controller_state,
                                  _controller, _state),
    'set_hardware_component_state': _verb(
        'change the state of a hardware component', _set_hardware_component_state,
        argument('hardware_component_name', help='name of the component'), _state),
    'switch_controllers': _verb(
        'activate and deactivate controllers at once', _switch_controllers,
        argument('--activate', nargs='*', default=[], metavar='NAME', help='to be activated'),
        argument('--deactivate', nargs='*', default=[], metavar='NAME', help='to be deactivated'),
        exclusive(flag('--strict', about='all or none'),
                  flag('--best-effort', about='as many as possible')),
        flag('--activate-asap', about='activate as soon as possible'),
        argument('--switch-timeout', type=float, default=5.0, metavar='S',
                 help='longest time (default: %(default)s)')),
    'unload_controller': _controller_verb(
        'unload a controller', 'unload_controller', 'unloading', 'unloaded'),
}
