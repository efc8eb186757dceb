# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""static_transform_publisher of tf2_ros: the program with its arguments, and the component."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math
import random
import string
import sys
from typing import TypeAlias

from geometry_msgs.msg import TransformStamped
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter
from tf2_msgs.msg import TFMessage

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ArmsimError
from armsim_ros.model.transforms import quat_xyzw_from_rpy
from armsim_ros.nodes import qos
from armsim_ros.nodes.upstream.single_node import spin

#: Values of the node's parameters by their names [m].
Values: TypeAlias = 'Mapping[str, float | str]'

_USAGE = ('static_transform_publisher [--x X] [--y Y] [--z Z] [--roll R --pitch P --yaw Y | '
          '--qx X --qy Y --qz Z --qw W] --frame-id PARENT --child-frame-id CHILD, or '
          'x y z yaw pitch roll PARENT CHILD, or x y z qx qy qz qw PARENT CHILD')
_EULER, _QUATERNION = ('roll', 'pitch', 'yaw'), ('qx', 'qy', 'qz', 'qw')
_NUMBERS = ('x', 'y', 'z', *_EULER, *_QUATERNION)
#: The node's parameters, all of them read-only, and their defaults.
DEFAULTS: Values = {
    **{f'translation.{axis}': 0.0 for axis in 'xyz'},
    **{f'rotation.{axis}': float(axis == 'w') for axis in 'xyzw'},
    'frame_id': '/frame', 'child_frame_id': '/child',
}
_NAME = 'static_transform_publisher'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish the transform that the words describe until SIGINT or SIGTERM.

    :returns: 0 after a signal, 1 for words that cannot be understood.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words):
        print(f'usage: {_USAGE}')
        return 0
    return _run(words, ros_args)


def component(argv: Sequence[str] | None = None) -> int:
    """
    Publish the transform that the parameters describe until SIGINT or SIGTERM.

    :param argv: ``--ros-args`` with the parameters of tf2_ros::StaticTransformBroadcasterNode.
    :returns: 0 after a signal, 1 where a parameter is wrong.
    """
    _, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    return _run(None, ros_args)


def _run(words: Sequence[str] | None, ros_args: Sequence[str]) -> int:
    try:
        values = {} if words is None else read_words(words)
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        return spin(unique_name(), ros_args, _publish, parameter_overrides=overrides)
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return 1


def unique_name() -> str:
    """Return a name of the node that no other has."""
    characters = string.digits + string.ascii_letters
    return f"{_NAME}_{''.join(random.choices(characters, k=16))}"


def _publish(node: Node) -> object:
    read_only = ParameterDescriptor(read_only=True)
    try:
        values = {name: node.declare_parameter(name, default, read_only).value
                  for name, default in DEFAULTS.items()}
    except InvalidParameterTypeException as error:
        raise UsageError(str(error)) from None
    transform = transform_of(values)
    transform.header.stamp = node.get_clock().now().to_msg()
    publisher = node.create_publisher(TFMessage, '/tf_static', qos.LATCHED)
    publisher.publish(TFMessage(transforms=[transform]))
    return publisher


def transform_of(values: Values) -> TransformStamped:
    """
    Return the transform that the node's parameters describe.

    :raises UsageError: where both frames are the same, or the quaternion is zero.
    """
    made = TransformStamped(child_frame_id=str(values['child_frame_id']))
    made.header.frame_id = str(values['frame_id'])
    if made.child_frame_id == made.header.frame_id:
        raise UsageError(f"child_frame_id cannot equal frame_id '{made.child_frame_id}'")
    length = math.hypot(*(float(values[f'rotation.{axis}']) for axis in 'xyzw'))
    if length < 1e-6:
        raise UsageError('the quaternion is zero')
    for axis in 'xyz':
        setattr(made.transform.translation, axis, values[f'translation.{axis}'])
    for axis in 'xyzw':
        setattr(made.transform.rotation, axis, float(values[f'rotation.{axis}']) / length)
    return made


def read_words(words: Sequence[str]) -> Values:
    """
    Return the parameters that the program's words set.

    :raises UsageError: where they describe no transform.
    """
    if words and words[0].startswith('--'):
        values, parent, child = _by_name(words)
    else:
        values, parent, child = _by_place(words)
    if not parent or not child:
        raise UsageError(f'the two frames are needed: {_USAGE}')
    has_quaternion = any(axis in values for axis in _QUATERNION)
    if has_quaternion and any(axis in values for axis in _EULER):
        raise UsageError('Cannot specify both quaternion and Euler rotations')
    if has_quaternion:
        xyzw = [values.get(axis, float(axis == 'qw')) for axis in _QUATERNION]
    else:
        xyzw = [float(part) for part in quat_xyzw_from_rpy(
            [values.get(axis, 0.0) for axis in _EULER])]
    return {
        **{f'translation.{axis}': values.get(axis, 0.0) for axis in 'xyz'},
        **{f'rotation.{axis}': value for axis, value in zip('xyzw', xyzw, strict=True)},
        'frame_id': parent, 'child_frame_id': child,
    }


def _by_name(words: Sequence[str]) -> tuple[dict[str, float], str, str]:
    values: dict[str, float] = {}
    frames = {'frame-id': '', 'child-frame-id': ''}
    rest = iter(words)
    for word in rest:
        name = word.removeprefix('--')
        if name in frames:
            frames[name] = next(rest, '')
        elif name in _NUMBERS:
            values[name] = _number(next(rest, ''))
        else:
            raise UsageError(f"cannot read '{word}': {_USAGE}")
    return values, frames['frame-id'], frames['child-frame-id']


def _by_place(words: Sequence[str]) -> tuple[dict[str, float], str, str]:
    names = {8: ('x', 'y', 'z', 'yaw', 'pitch', 'roll'),
             9: ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')}.get(len(words))
    if names is None:
        raise UsageError(f'cannot read {len(words)} words: {_USAGE}')
    values = {name: _number(word) for name, word in zip(names, words, strict=False)}
    return values, words[-2], words[-1]


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise UsageError(f"'{word}' is not a number: {_USAGE}") from None
