# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Compressed pictures, read as their subscribers read them."""

from io import BytesIO
import struct

import numpy as np
from PIL import Image
import pytest

from armsim_ros.nodes.camera.topics import depth_as_png, jpeg


def test_colours_survive():
    """A better quality is nearer, and red stays red."""
    colour = np.zeros((32, 48, 3), np.uint8)
    colour[:, :24, 0] = 200
    colour[:, 24:, 2] = 150
    read = np.asarray(Image.open(BytesIO(jpeg(colour, 95)))).astype(int)
    assert np.abs(read - colour)[:, [4, 40]].max() < 8
    assert len(jpeg(colour, 5)) < len(jpeg(colour, 100))


def decoded(content):
    """Return depths [m] as compressed_depth_image_transport's codec.cpp decodes them."""
    kind, scale, offset = struct.unpack_from('<iff', content)
    assert kind == 0
    stored = np.asarray(Image.open(BytesIO(content[12:]))).astype(float)
    return np.where(stored == 0, np.nan, scale / (stored - offset))


def test_depths_survive():
    """By the two numbers of the header; what is not finite is no depth."""
    depth = np.array([[0.3, 1.0, 2.5], [9.0, np.inf, -np.inf]], np.float32)
    read = decoded(depth_as_png(depth))
    assert read[0] == pytest.approx(depth[0], rel=1e-3)
    assert read[1, 0] == pytest.approx(9.0, rel=1e-2)
    assert np.isnan(read[1, 1:]).all()


def test_depths_that_do_not_fit_are_none():
    """An obstacle that is nearer than 16 bits can express must not look farther away."""
    near = np.array([[0.1, 0.15, 0.1517, 0.1519]], np.float32)
    read = decoded(depth_as_png(near))[0]
    assert np.isnan(read[:3]).all()
    assert read[3] == pytest.approx(near[0, 3], rel=1e-4)
