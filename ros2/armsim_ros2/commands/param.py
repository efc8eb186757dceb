# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 param``."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
import re
import sys
from typing import Any

import yaml

from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.parameter_files import parameters_in
from armsim_ros2.parsing import argument, flag, node_options, Verb
from armsim_ros2.session import Session

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
    return _Node(session, session.require_node(
        options.node_name, options.include_hidden_nodes, getattr(options, 'timeout', 0.0)))


def _list(options: Namespace) -> None:
    pattern = None
    if options.filter is not None:
        try:
            pattern = re.compile(options.filter)
        except re.error as error:
            raise CliError(f"Invalid filter '{options.filter}': {error}") from None
    with Session(options) as session:
        if options.node_name:
            nodes = [_node(session, options)]
        else:
            session.settle()
            nodes = [_Node(session, name)
                     for name in sorted(set(session.nodes(options.include_hidden_nodes)))
                     if f'{name}/list_parameters' in session.services()]
        for node in nodes:
            try:
                names = node.names(options.param_prefixes)
            except CliError as failure:
                print(failure, file=sys.stderr)
                continue
            names = [name for name in names if pattern is None or pattern.match(name)]
            if names and not options.node_name:
                print(f'{node.name}:')
            if options.param_type:
                for descriptor in node.descriptors(names):
                    print(f'  {descriptor.name} (type: {_TYPES[descriptor.type][0]})')
            else:
                for name in names:
                    print(f'  {name}')


def _get(options: Namespace) -> None:
    with Session(options) as session:
        node = _node(session, options)
        values = node.call('get_parameters', names=[options.parameter_name]).values
        if not values:
            raise CliError(f"Parameter not set: '{options.parameter_name}'"
                           f'{hint(options.parameter_name, node.names())}')
        value = value_of(values[0])
        if options.hide_type:
            print(value)
        elif value is None:
            print(_TYPES[0][1])
            print(f"{node.name} has no parameter '{options.parameter_name}'"
                  f'{hint(options.parameter_name, node.names())}', file=sys.stderr)
        else:
            print(_TYPES[values[0].type][1], value)


def _report(result: Any, success: str, failure: str) -> None:
    reason = f': {result.reason}' if result.reason else ''
    print(f'{success if result.successful else failure}{reason}',
          file=sys.stdout if result.successful else sys.stderr)


def _set(options: Namespace) -> None:
    from rclpy.parameter import get_parameter_value

    try:
        value = get_parameter_value(options.value)
    except (AssertionError, OverflowError, yaml.YAMLError) as error:
        raise CliError(f"'{options.value}' is not the value of a parameter: "
                       f'{" ".join(str(error).split())}') from None
    parameter = load('rcl_interfaces/Parameter', 'msg')(name=options.parameter_name, value=value)
    with Session(options) as session:
        (result,) = _node(session, options).set([parameter])
        _report(result, 'Set parameter successful', 'Setting parameter failed')


def _delete(options: Namespace) -> None:
    parameter = load('rcl_interfaces/Parameter', 'msg')(name=options.parameter_name)
    with Session(options) as session:
        (result,) = _node(session, options).set([parameter])
        _report(result, 'Deleted parameter successfully', 'Deleting parameter failed')


def _describe(options: Namespace) -> None:
    with Session(options) as session:
        node = _node(session, options)
        for descriptor in node.descriptors(options.parameter_names):
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


def _dump(options: Namespace) -> None:
    with Session(options) as session:
        node = _node(session, options)
        names = node.names()
        values = node.call('get_parameters', names=names).values
        tree: dict[str, Any] = {}
        for name, message in zip(names, values, strict=False):
            *path, last = name.split('.')
            branch = tree
            for part in path:
                branch = branch.setdefault(part, {})
            branch[last] = value_of(message)
        print(yaml.dump({node.name: {'ros__parameters': tree}}, default_flow_style=False))


def _load(options: Namespace) -> None:
    from rclpy.parameter import Parameter

    file = Path(options.parameter_file)
    with Session(options) as session:
        node = _node(session, options)
        values = parameters_in(file, node.name, not options.no_use_wildcard)
        if not values:
            raise CliError(f"Parameter file '{file}' has no parameters for {node.name}")
        try:
            parameters = [Parameter(name, value=value).to_parameter_msg()
                          for name, value in values.items()]
        except (AssertionError, TypeError, ValueError) as error:
            raise CliError(f"Parameter file '{file}': {error}") from None
        for parameter, result in zip(parameters, node.set(parameters), strict=True):
            _report(result, f'Set parameter {parameter.name} successful',
                    f'Set parameter {parameter.name} failed')


_name = argument('node_name', help='name of the node')
_parameter = argument('parameter_name', help='name of the parameter')
_hidden = flag('--include-hidden-nodes', about='include hidden nodes')
_timeout = argument('--timeout', type=float, default=1.0, metavar='S',
                    help='time to wait for the node (default: %(default)s)')
_common = [_hidden, _timeout, node_options]

VERBS = {
    'delete': Verb('delete a parameter', _delete, [_name, _parameter, *_common]),
    'describe': Verb('print the descriptions of parameters', _describe, [
        _name, argument('parameter_names', nargs='+', help='names of the parameters'), *_common]),
    'dump': Verb('print the parameters of a node as a parameter file', _dump, [_name, *_common]),
    'get': Verb('print a parameter', _get, [
        _name, _parameter, flag('--hide-type', about='print only the value'), *_common]),
    'list': Verb('print the names of parameters', _list, [
        argument('node_name', nargs='?', help='name of the node; all nodes by default'),
        argument('--filter', metavar='REGEX', help='only names that match from their start'),
        argument('--param-prefixes', nargs='+', default=[], metavar='PREFIX',
                 help='only names with these prefixes'),
        flag('--param-type', about='print types, too'), _hidden, node_options]),
    'load': Verb('set the parameters of a parameter file', _load, [
        _name, argument('parameter_file', help='the YAML file'),
        flag('--no-use-wildcard', about='do not use entries of /**'), *_common]),
    'set': Verb('set a parameter', _set, [
        _name, _parameter, argument('value', help='as YAML: 1.5, true, [a, b]'), *_common]),
}
