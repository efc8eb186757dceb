# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""tf2_echo of tf2_ros: prints the transform between two frames."""

from __future__ import annotations

from collections.abc import Sequence
import math
import re
import sys

from geometry_msgs.msg import Quaternion, TransformStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from tf2_ros import TransformException

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.errors import USAGE_STATUS
from armsim_ros.nodes.upstream.awaited_transform import AwaitedTransform
from armsim_ros.nodes.upstream.single_node import spin

_USAGE = """Usage: tf2_echo source_frame target_frame [echo_rate]

This will echo the transform from the coordinate frame of the source_frame
to the coordinate frame of the target_frame.\x20
Note: This is the transform to get data from target_frame into the source_frame.
Default echo rate is 1 if echo_rate is not given."""
_WITHOUT_FRAMES, _NOT_A_NUMBER, _MORE_THAN_A_NUMBER = 1, 2, 3
#: What std::stof reads of a text.
_NUMBER = re.compile(
    r'\s*[+-]?(inf(inity)?|nan|(\d+\.?\d*|\.\d+)(e[+-]?\d+)?)', re.IGNORECASE | re.ASCII)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print a transform until SIGINT or SIGTERM.

    :returns: 0 after a signal, 1 for a wrong number of words, 2 for a rate that is no positive
        number, 3 for a rate with something after the number.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    if len(words) not in (2, 3):
        print(_USAGE, flush=True)
        return _WITHOUT_FRAMES
    target, source, rate_text = [*words, '1'][:3]
    number = _NUMBER.match(rate_text)
    if number is None or number.end() != len(rate_text):
        print(f"Failed to convert rate argument '{rate_text}' to a floating-point number",
              file=sys.stderr, flush=True)
        return _NOT_A_NUMBER if number is None else _MORE_THAN_A_NUMBER
    rate = float(rate_text)
    if not rate > 0.0:
        print('rate must be greater than 0', file=sys.stderr, flush=True)
        return USAGE_STATUS
    return spin('tf2_echo', ros_args, lambda node: _Echo(node, target, source, 1.0 / rate))


class _Echo:
    """Prints the transform, as soon as it is available, once a period [s]."""

    def __init__(self, node: Node, target: str, source: str, period: float) -> None:
        self._clock = node.get_clock()
        self._transform = AwaitedTransform(node, target, source)
        self._arrived = False
        self._timer = node.create_timer(
            period, self._step, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._step()

    def _step(self) -> None:
        self._arrived = self._arrived or self._transform.available()
        if not self._arrived:
            return
        try:
            text = format_transform(self._transform.look_up())
        except TransformException as error:
            text = (f'Failure at {self._clock.now().nanoseconds * 1e-9:.3f}\n'
                    f'Exception thrown:{error}\nThe current list of frames is:\n'
                    f'{self._transform.buffer.all_frames_as_string()}')
        print(text, flush=True)


def format_transform(message: TransformStamped) -> str:
    """Return the text of a transform, without the last end of line."""
    stamp, rotation = message.header.stamp, message.transform.rotation
    moved = message.transform.translation
    translation = (moved.x, moved.y, moved.z)
    matrix = _matrix(rotation)
    rpy = _roll_pitch_yaw(matrix)
    rows = [*((*row, value) for row, value in zip(matrix, translation, strict=True)),
            (0.0, 0.0, 0.0, 1.0)]
    quaternion = (rotation.x, rotation.y, rotation.z, rotation.w)
    return '\n'.join([
        f'At time {stamp.sec}.{stamp.nanosec}',
        f'- Translation: {_listed(translation)}',
        f'- Rotation: in Quaternion {_listed(quaternion)}',
        f'- Rotation: in RPY (radian) {_listed(rpy)}',
        f'- Rotation: in RPY (degree) {_listed([angle * 180.0 / math.pi for angle in rpy])}',
        '- Matrix:',
        *(''.join(f' {value:6.3f}' for value in row) for row in rows)])


def _listed(values: Sequence[float]) -> str:
    return f"[{', '.join(f'{value:.3f}' for value in values)}]"


def _matrix(q: Quaternion) -> tuple[tuple[float, float, float], ...]:
    """
    Return the rotation (3, 3) of a quaternion.

    The order of operations is that of tf2::Matrix3x3::setRotation: it decides about the signs of
    zeros, and whether a pitch of 90 degrees is taken for one.
    """
    s = 2.0 / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)
    xs, ys, zs = q.x * s, q.y * s, q.z * s
    wx, wy, wz = q.w * xs, q.w * ys, q.w * zs
    xx, xy, xz = q.x * xs, q.x * ys, q.x * zs
    yy, yz, zz = q.y * ys, q.y * zs, q.z * zs
    return ((1.0 - (yy + zz), xy - wz, xz + wy),
            (xy + wz, 1.0 - (xx + zz), yz - wx),
            (xz - wy, yz + wx, 1.0 - (xx + yy)))


def _roll_pitch_yaw(m: tuple[tuple[float, float, float], ...]) -> tuple[float, float, float]:
    """Return the angles [rad] of a rotation (3, 3), as tf2::Matrix3x3::getEulerYPR."""
    if abs(m[2][0]) >= 1.0:
        return math.atan2(m[2][1], m[2][2]), math.copysign(math.pi / 2.0, -m[2][0]), 0.0
    pitch = -math.asin(m[2][0])
    cosine = math.cos(pitch)
    return (math.atan2(m[2][1] / cosine, m[2][2] / cosine), pitch,
            math.atan2(m[1][0] / cosine, m[0][0] / cosine))
