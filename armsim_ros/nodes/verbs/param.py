# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim param``: parameters of a running node, read and set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.parameter import parameter_value_to_python
import yaml

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.client.ros_client import RosClient
from armsim_ros.nodes.verbs.terminal import call, parser, read, show

_NOT_SET = 0


def main(argv: Sequence[str] | None = None) -> int:
    """
    List, get or set.

    :returns: 0, or 1 where the node refused a value.
    :raises ArmsimError: there is no such node or parameter.
    """
    words = parser('param', 'list, read and set parameters of a node')
    words.add_argument('what', choices=('list', 'get', 'set'))
    words.add_argument('node', help='such as /move_group')
    words.add_argument('name', nargs='?', default='', help='of the parameter')
    words.add_argument('value', nargs='?', default=None, help='as YAML: 1.5, true, [a, b]')
    asked, ros = read(words, argv)
    node = f"/{asked.node.strip('/')}"
    if (asked.what != 'list' and not asked.name) or (asked.what == 'set' and asked.value is None):
        words.error(f"'{asked.what}' needs the parameter's name"
                    + (' and its value' if asked.what == 'set' else ''))
    with RosClient('armsim_param', ros) as client:
        if asked.what == 'list':
            names = _names(client, node, asked.timeout)
            show(names, asked.json, '\n'.join(names))
        elif asked.what == 'get':
            value = _get(client, node, asked.name, asked.timeout)
            show(value, asked.json, _text(value))
        else:
            value = yaml.safe_load(asked.value)
            return _set(client, node, asked.name, value, asked)
    return 0


def _names(client: RosClient, node: str, patience: float) -> list[str]:
    answer = call(client, ListParameters, f'{node}/list_parameters', None, patience)
    return sorted(answer.result.names)


def _get(client: RosClient, node: str, name: str, patience: float) -> Any:
    answer = call(client, GetParameters, f'{node}/get_parameters',
                  GetParameters.Request(names=[name]), patience)
    if not answer.values or answer.values[0].type == _NOT_SET:
        hint = nearest(name, _names(client, node, patience))
        raise ArmsimError(f"{node} has no parameter '{name}'; "
                          f"{hint or f'armsim param list {node} shows them'}")
    value = parameter_value_to_python(answer.values[0])
    return list(value) if hasattr(value, '__iter__') and not isinstance(value, str) else value


def _set(client: RosClient, node: str, name: str, value: Any, asked: Any) -> int:
    old = _get(client, node, name, asked.timeout)
    if isinstance(old, float) and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    try:
        message: Parameter = RclpyParameter(name, value=value).to_parameter_msg()
    except (TypeError, ValueError, AttributeError):
        raise ArmsimError(f"'{asked.value}' is no value of a parameter; allowed: a number, true, "
                          'false, a text, or a list of one kind') from None
    answer = call(client, SetParameters, f'{node}/set_parameters',
                  SetParameters.Request(parameters=[message]), asked.timeout)
    (result,) = answer.results
    text = f'{name}: {_text(old)} -> {_text(value)}'
    if not result.successful:
        text = f'{node} keeps {name} at {_text(old)}: {result.reason}'
    show({'name': name, 'old': old, 'value': value, 'success': result.successful,
          'reason': result.reason}, asked.json, text)
    return 0 if result.successful else 1


def _text(value: Any) -> str:
    return str(yaml.safe_dump(value, default_flow_style=True)).removesuffix('...\n').strip()
