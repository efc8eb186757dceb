# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""static_transform_publisher of tf2_ros, with both of its forms of arguments."""

from __future__ import annotations

from collections.abc import Sequence
import math
import sys

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ArmsimError
from armsim_ros.model.transforms import matrix_from_rpy, pose_from_parts, quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.upstream.single_node import spin

_USAGE = ('static_transform_publisher [--x X] [--y Y] [--z Z] [--roll R --pitch P --yaw Y | '
          '--qx X --qy Y --qz Z --qw W] --frame-id PARENT --child-frame-id CHILD, or '
          'x y z yaw pitch roll PARENT CHILD, or x y z qx qy qz qw PARENT CHILD')
_EULER, _QUATERNION = ('roll', 'pitch', 'yaw'), ('qx', 'qy', 'qz', 'qw')
_NUMBERS = ('x', 'y', 'z', *_EULER, *_QUATERNION)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish a transform until SIGINT or SIGTERM.

    :returns: 0 after a signal, 1 for words that cannot be understood.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words):
        print(f'usage: {_USAGE}')
        return 0
    try:
        transform = read_transform(words)
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return 1

    def make(node: Node) -> object:
        publisher = node.create_publisher(TFMessage, '/tf_static', qos.LATCHED)
        transform.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(TFMessage(transforms=[transform]))
        return publisher

    return spin('static_transform_publisher', ros_args, make, start_parameter_services=False)


def read_transform(words: Sequence[str]) -> TransformStamped:
    """
    Return the transform that the words describe.

    :raises UsageError: where they describe none.
    """
    if words and words[0].startswith('--'):
        values, parent, child = _by_name(words)
    else:
        values, parent, child = _by_place(words)
    if not parent or not child:
        raise UsageError(f'the two frames are needed: {_USAGE}')
    if parent == child:
        raise UsageError(f"child_frame_id cannot equal frame_id '{parent}'")
    has_quaternion = any(axis in values for axis in _QUATERNION)
    if has_quaternion and any(axis in values for axis in _EULER):
        raise UsageError('Cannot specify both quaternion and Euler rotations')
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    pose = pose_from_parts([values.get(axis, 0.0) for axis in 'xyz'], matrix_from_rpy(
        [values.get(axis, 0.0) for axis in _EULER]))
    xyzw = [float(component) for component in quat_xyzw_from_matrix(pose)]
    if has_quaternion:
        xyzw = [values.get(axis, 1.0 if axis == 'qw' else 0.0) for axis in _QUATERNION]
        length = math.hypot(*xyzw)
        if length < 1e-6:
            raise UsageError('the quaternion is zero')
        xyzw = [component / length for component in xyzw]
    translation, rotation = made.transform.translation, made.transform.rotation
    translation.x, translation.y, translation.z = (values.get(axis, 0.0) for axis in 'xyz')
    rotation.x, rotation.y, rotation.z, rotation.w = xyzw
    return made


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
