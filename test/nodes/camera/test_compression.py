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


def test_depths_survive():
    """As compressed_depth_image_transport decodes them: by the two numbers of the header."""
    depth = np.array([[0.3, 1.0, 2.5], [9.0, np.inf, np.nan]], np.float32)
    content = depth_as_png(depth)
    kind, scale, offset = struct.unpack_from('<iff', content)
    stored = np.asarray(Image.open(BytesIO(content[12:]))).astype(float)
    assert kind == 0
    assert (stored[1, 1:] == 0).all()
    read = scale / (stored - offset)
    assert read[0] == pytest.approx(depth[0], rel=1e-3)
    assert read[1, 0] == pytest.approx(9.0, rel=1e-2)
