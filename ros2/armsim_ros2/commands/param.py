# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 param``."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
import re
import sys
from typing import Any

import yaml

from armsim_ros2.commands.names import name_argument
from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.parameter_files import parameters_in
from armsim_ros2.parsing import argument, Arguments, flag, hidden, Verb
from armsim_ros2.session import graph_verb, Session

#: Number of a parameter's type -> name, label of its value, field of the message.
_TYPES = (
    ('not set', 'Parameter not set.', ''),
    ('boolean', 'Boolean value is:', 'bool_value'),
    ('integer', 'Integer value is:', 'integer_value'),
    ('double', 'Double value is:', 'double_value'),
    ('string', 'String value is:', 'string_value'),
    ('byte array', 'Byte values are:', 'byte_array_value'),
    ('boolean array', 'Boolean values are:', 'bool_array_value'),
    ('integer array', 'Integer values are:', 'integer_array_value'),
    ('double array', 'Double values are:', 'double_array_value'),
    ('string array', 'String values are:', 'string_array_value'),
)


class _Node:
    """
    The parameter services of a node.

    :param name: full name of the node.
    """

    def __init__(self, session: Session, name: str) -> None:
        self._session = session
        self.name = name

    def call(self, service: str, /, **fields: Any) -> Any:
        """Call one of its services; raises CliError if it does not respond."""
        kind = ''.join(word.capitalize() for word in service.split('_'))
        return self._session.call(f'rcl_interfaces/srv/{kind}', f'{self.name}/{service}',
                                  patience=5.0, **fields)

    def names(self, prefixes: list[str] | None = None) -> list[str]:
        """Return the names of its parameters, sorted."""
        response = self.call('list_parameters', prefixes=prefixes or [])
        return sorted(response.result.names)

    def descriptors(self, names: list[str]) -> list[Any]:
        """Return the descriptors of parameters."""
        return list(self.call('describe_parameters', names=names).descriptors)

    def set(self, parameters: list[Any]) -> list[Any]:
        """Set parameters and return the results."""
        return list(self.call('set_parameters', parameters=parameters).results)


def value_of(message: Any) -> Any:
    """Return the value of a ParameterValue, None if it is not set."""
    name = _TYPES[message.type][2]
    value: Any = getattr(message, name) if name else None
    return value.tolist() if hasattr(value, 'tolist') else value


def _node(session: Session, options: Namespace) -> _Node:
    return _Node(session, session.require_node(options.node_name, options.hidden,
                                               getattr(options, 'timeout', 0.0)))


def _list(session: Session, options: Namespace) -> None:
    try:
        pattern = re.compile(options.filter)
    except re.error as error:
        raise CliError(f"Invalid filter '{options.filter}': {error}") from None
    if options.node_name:
        nodes = [_node(session, options)]
    else:
        session.settle()
        nodes = [_Node(session, name) for name in sorted(set(session.nodes(options.hidden)))
                 if f'{name}/list_parameters' in session.names('service')]
    for node in nodes:
        try:
            names = [name for name in node.names(options.param_prefixes) if pattern.match(name)]
        except CliError as failure:
            print(failure, file=sys.stderr)
            continue
        if names and not options.node_name:
            print(f'{node.name}:')
        if options.param_type:
            for descriptor in node.descriptors(names):
                print(f'  {descriptor.name} (type: {_TYPES[descriptor.type][0]})')
        else:
            for name in names:
                print(f'  {name}')


def _get(session: Session, options: Namespace) -> None:
    node, name = _node(session, options), options.parameter_name
    values = node.call('get_parameters', names=[name]).values
    if not values:
        raise CliError(f"Parameter not set: '{name}'{hint(name, node.names())}")
    value = value_of(values[0])
    if options.hide_type:
        print(value)
    elif value is None:
        print(_TYPES[0][1])
        print(f"{node.name} has no parameter '{name}'{hint(name, node.names())}", file=sys.stderr)
    else:
        print(_TYPES[values[0].type][1], value)


def _report(result: Any, success: str, failure: str) -> None:
    reason = f': {result.reason}' if result.reason else ''
    print(f'{success if result.successful else failure}{reason}',
          file=sys.stdout if result.successful else sys.stderr)


def _set(session: Session, options: Namespace) -> None:
    from rclpy.parameter import get_parameter_value

    try:
        value = get_parameter_value(options.value)
    except (AssertionError, OverflowError, yaml.YAMLError) as error:
        raise CliError(f"'{options.value}' is not the value of a parameter: "
                       f'{" ".join(str(error).split())}') from None
    parameter = load('rcl_interfaces/Parameter', 'msg')(name=options.parameter_name, value=value)
    (result,) = _node(session, options).set([parameter])
    _report(result, 'Set parameter successful', 'Setting parameter failed')


def _delete(session: Session, options: Namespace) -> None:
    parameter = load('rcl_interfaces/Parameter', 'msg')(name=options.parameter_name)
    (result,) = _node(session, options).set([parameter])
    _report(result, 'Deleted parameter successfully', 'Deleting parameter failed')


def _describe(session: Session, options: Namespace) -> None:
    for descriptor in _node(session, options).descriptors(options.parameter_names):
        print('Parameter name:', descriptor.name)
        print('  Type:', _TYPES[descriptor.type][0])
        if descriptor.description:
            print('  Description:', descriptor.description)
        print('  Constraints:')
        if descriptor.read_only:
            print('    Read only: true')
        for limits in [*descriptor.floating_point_range, *descriptor.integer_range][:1]:
            print('    Min value:', limits.from_value)
            print('    Max value:', limits.to_value)
            if limits.step:
                print('    Step:', limits.step)
        if descriptor.additional_constraints:
            print('    Additional constraints:', descriptor.additional_constraints)


def _dump(session: Session, options: Namespace) -> None:
    node = _node(session, options)
    names = node.names()
    tree: dict[str, Any] = {}
    for name, message in zip(names, node.call('get_parameters', names=names).values, strict=False):
        *path, last = name.split('.')
        branch = tree
        for part in path:
            branch = branch.setdefault(part, {})
        branch[last] = value_of(message)
    print(yaml.dump({node.name: {'ros__parameters': tree}}, default_flow_style=False))


def _load(session: Session, options: Namespace) -> None:
    from rclpy.parameter import Parameter

    file, node = Path(options.parameter_file), _node(session, options)
    values = parameters_in(file, node.name, not options.no_use_wildcard)
    if not values:
        raise CliError(f"Param file does not contain selected parameters: '{file}' has none for "
                       f'{node.name}')
    try:
        parameters = [Parameter(name, value=value).to_parameter_msg()
                      for name, value in values.items()]
    except (AssertionError, TypeError, ValueError) as error:
        raise CliError(f"Parameter file '{file}': {error}") from None
    for parameter, result in zip(parameters, node.set(parameters), strict=True):
        _report(result, f'Set parameter {parameter.name} successful',
                f'Set parameter {parameter.name} failed')


_parameter = argument('parameter_name', help='name of the parameter')


def _verb(about: str, run: Callable[[Session, Namespace], None], *arguments: Arguments) -> Verb:
    """Return a verb for the parameters of one node."""
    return graph_verb(
        about, run, name_argument('node'), *arguments, hidden('node'),
        argument('--timeout', type=float, default=1.0, metavar='S',
                 help='time to wait for the node (default: %(default)s)'))


VERBS = {
    'delete': _verb('delete a parameter', _delete, _parameter),
    'describe': _verb('print the descriptions of parameters', _describe, argument(
        'parameter_names', nargs='+', help='names of the parameters')),
    'dump': _verb('print the parameters of a node as a parameter file', _dump),
    'get': _verb('print a parameter', _get, _parameter,
                 flag('--hide-type', about='print only the value')),
    'list': graph_verb(
        'print the names of parameters', _list,
        argument('node_name', nargs='?', help='name of the node; all nodes by default'),
        argument('--filter', default='', metavar='REGEX',
                 help='only names that match from their start'),
        argument('--param-prefixes', nargs='+', default=[], metavar='PREFIX',
                 help='only names with these prefixes'),
        flag('--param-type', about='print types, too'), hidden('node')),
    'load': _verb('set the parameters of a parameter file', _load,
                  argument('parameter_file', help='the YAML file'),
                  flag('--no-use-wildcard', about='do not use entries of /**')),
    'set': _verb('set a parameter', _set, _parameter,
                 argument('value', help='as YAML: 1.5, true, [a, b]')),
}
