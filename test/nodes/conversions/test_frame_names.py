# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames read from serialized transforms are those of the message."""

from __future__ import annotations

from geometry_msgs.msg import TransformStamped
import pytest
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage

from armsim_ros.nodes.conversions.serialized import child_frame_ids


def serialized(*frames: tuple[str, str]) -> bytes:
    """Return transforms between frames as the middleware carries them."""
    transforms = [TransformStamped(child_frame_id=child) for _, child in frames]
    for (parent, _), transform in zip(frames, transforms, strict=True):
        transform.header.frame_id = parent
    return bytes(serialize_message(TFMessage(transforms=transforms)))


@pytest.mark.parametrize('length', range(9))
def test_frames_of_names_of_every_length_are_found(length):
    """The names before and after shift everything that is aligned."""
    children = ['x' * length, 'camera_optical_frame', 'größe', 'x' * (length + 3)]
    frames = [('base'[: length % 5], child) for child in children]
    assert child_frame_ids(serialized(*frames)) == children


def test_no_transforms_are_no_frames():
    """An empty message is legal."""
    assert child_frame_ids(serialized()) == []


def test_other_bytes_are_not_guessed_at():
    """Another representation, or a message cut short, is left to the middleware."""
    whole = serialized(('base', 'tool'), ('tool', 'camera'))
    assert child_frame_ids(b'\x00\x00' + whole[2:]) is None
    assert child_frame_ids(whole[:90]) is None
    assert child_frame_ids(b'') is None
