# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Camera pictures as a browser gets them."""

import base64
import io

import numpy as np
import pytest
from sensor_msgs.msg import Image

pytest.importorskip('viser')

from PIL import Image as Picture

from armsim_ros.nodes.web.parts.simulation import picture_url


def shown(encoding, pixels):
    """Return what the browser draws of a message with these pixels."""
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding,
                    step=pixels[0].nbytes, data=pixels.tobytes())
    head, _, content = picture_url(message).partition(',')
    assert head == 'data:image/jpeg;base64'
    return np.asarray(Picture.open(io.BytesIO(base64.b64decode(content)))).astype(int)


def test_depth_is_bright_where_it_is_near():
    """What was not measured is black; colours are grey."""
    depth = np.full((48, 64), 1.0, np.float32)
    depth[:, 16:32], depth[:, 32:48], depth[:, 48:] = 2.0, np.inf, -np.inf
    seen = shown('32FC1', depth)[24, 8::16]
    near, far, missing, closer = (int(pixel.mean()) for pixel in seen)
    assert near > 245
    assert 40 < far < 70
    assert max(missing, closer) < 8
    assert np.ptp(seen, axis=1).max() < 5


def test_depth_of_nothing_is_black():
    """No depth at all is no mistake."""
    assert shown('32FC1', np.full((16, 16), np.inf, np.float32)).max() < 8


def test_colour_is_shown_as_it_is():
    """Red stays red."""
    red, green, blue = shown('rgb8', np.full((16, 16, 3), (200, 0, 0), np.uint8))[8, 8]
    assert (red > 190, green < 10, blue < 10) == (True, True, True)
