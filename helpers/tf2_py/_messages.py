# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Between messages and plain numbers."""

from __future__ import annotations

from typing import Any, cast

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from tf2_py._rigid import Pose, unit

_SECOND = 1_000_000_000
_TEMPLATE: Any = TransformStamped()
#: Whether messages check what is assigned to their fields.
_CHECKED = _TEMPLATE._check_fields


def nanoseconds(value: Any, kind: str = 'time') -> int:
    """
    Return a time or duration of rclpy or of builtin_interfaces [ns].

    :param kind: time or duration, for the error's text.
    :raises TypeError: it is neither.
    """
    try:
        return int(value.nanoseconds)
    except AttributeError:
        pass
    try:
        return int(value.sec) * _SECOND + int(value.nanosec)
    except AttributeError:
        raise TypeError(f'{kind} must have sec and nanosec, or nanoseconds.') from None


def transform_message(stamp: int, frame: str, child: str, pose: Pose) -> TransformStamped:
    """
    Return the message of a transform.

    The generated constructors check every field, which takes far longer than a look-up; all
    fields are set here, of the right types.

    :param stamp: [ns].
    :param pose: of the child in the frame.
    """
    time = _blank(Time)
    time._sec, time._nanosec = divmod(stamp, _SECOND)
    header = _blank(Header)
    header._stamp, header._frame_id = time, frame
    translation = _blank(Vector3)
    translation._x, translation._y, translation._z = pose[4:]
    rotation = _blank(Quaternion)
    rotation._x, rotation._y, rotation._z, rotation._w = unit(*pose[:4])
    transform = _blank(Transform)
    transform._translation, transform._rotation = translation, rotation
    message = _blank(TransformStamped)
    message._header, message._child_frame_id, message._transform = header, child, transform
    return cast(TransformStamped, message)


def _blank(kind: Any) -> Any:
    """Return a message without fields."""
    message = kind.__new__(kind)
    message._check_fields = _CHECKED
    return message
