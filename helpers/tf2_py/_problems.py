# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with names and transforms, in the words of tf2."""

from __future__ import annotations

from math import isnan

#: How far the squared length of a quaternion may be from 1.
_UNIT_TOLERANCE = 0.01


def problem_of_name(frame: str) -> str:
    """Return why no frame can have this name."""
    if not frame:
        return 'in tf2 frame_ids cannot be empty'
    return "in tf2 frame_ids cannot start with a '/'" if frame.startswith('/') else ''


def problem_of_transform(parent: str, child: str, numbers: tuple[float, ...]) -> str:
    """Return why a transform cannot be used, with the name that tf2 gives to the error."""
    if not child:
        return 'TF_NO_CHILD_FRAME_ID: child_frame_id is empty'
    if not parent:
        return 'TF_NO_FRAME_ID: frame_id is empty'
    if child == parent:
        return 'TF_SELF_TRANSFORM: the two frames are the same'
    x, y, z, w = numbers[:4]
    total = x * x + y * y + z * z + w * w
    if isnan(total + sum(numbers[4:])):
        return f'TF_NAN_INPUT: {numbers} has a NaN'
    if abs(total - 1.0) >= _UNIT_TOLERANCE:
        return f'TF_DENORMALIZED_QUATERNION: the length of ({x}, {y}, {z}, {w}) is not 1'
    return ''
