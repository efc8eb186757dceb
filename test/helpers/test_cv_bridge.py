# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""cv_bridge: encodings, steps, byte orders and colours (upstream's enumerants.py)."""

import array
import sys

from cv_bridge import CvBridge, CvBridgeError
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

BRIDGE = CvBridge()


def image(kind, channels):
    """Return a random image of 5 x 7 pixels."""
    random = np.random.default_rng(3)
    return random.integers(0, 100, (5, 7, channels) if channels > 1 else (5, 7)).astype(kind)


@pytest.mark.parametrize(
    'kind', ['uint8', 'int8', 'uint16', 'int16', 'int32', 'float32', 'float64'])
@pytest.mark.parametrize('channels', [1, 2, 3, 4])
def test_arrays_come_back(kind, channels):
    """All types with one to four channels."""
    original = image(kind, channels)
    message = BRIDGE.cv2_to_imgmsg(original, header=Header(frame_id='camera'))
    assert message.header.frame_id == 'camera'
    assert (message.height, message.width) == (5, 7)
    assert message.step == 7 * channels * original.itemsize
    assert BRIDGE.encoding_to_dtype_with_channels(message.encoding) == (kind, channels)
    found = BRIDGE.imgmsg_to_cv2(message)
    assert found.dtype == original.dtype
    np.testing.assert_array_equal(found, original)


@pytest.mark.parametrize(('encoding', 'kind', 'channels'), [
    ('mono8', 'uint8', 1), ('mono16', 'uint16', 1), ('bgr8', 'uint8', 3), ('rgba16', 'uint16', 4),
    ('bayer_rggb8', 'uint8', 1), ('yuv422_yuy2', 'uint8', 2), ('32FC1', 'float32', 1),
    ('8UC', 'uint8', 1), ('8UC10', 'uint8', 10)])
def test_encodings(encoding, kind, channels):
    """Names of REP 118 and of array types."""
    assert BRIDGE.encoding_to_dtype_with_channels(encoding) == (kind, channels)
    assert BRIDGE.cv2_to_imgmsg(image(kind, channels), encoding).encoding == encoding


def test_padding_and_byte_order():
    """A step longer than the row, and bytes of the other order."""
    message = Image(height=2, width=2, encoding='16UC1', step=6, is_bigendian=True)
    message.data = array.array('B', np.array([[1, 2, 9], [3, 4, 9]], '>u2').tobytes())
    assert BRIDGE.imgmsg_to_cv2(message).tolist() == [[1, 2], [3, 4]]
    swapped = BRIDGE.cv2_to_imgmsg(np.array([[1, 2]], '>u2'))
    assert swapped.is_bigendian
    assert BRIDGE.imgmsg_to_cv2(swapped).tolist() == [[1, 2]]


@pytest.mark.parametrize(('source', 'pixel', 'desired', 'expected'), [
    ('rgb8', [10, 20, 30], 'bgr8', [30, 20, 10]),
    ('rgb8', [10, 20, 30], 'rgba8', [10, 20, 30, 255]),
    ('bgra8', [1, 2, 3, 4], 'rgba8', [3, 2, 1, 4]),
    ('bgra8', [1, 2, 3, 4], 'rgb8', [3, 2, 1]),
    ('mono8', 7, 'bgr8', [7, 7, 7]),
    ('rgb8', [255, 0, 0], 'mono8', 76),
    ('rgb8', [0, 255, 0], 'mono8', 150),
    ('bgr8', [255, 0, 0], 'mono8', 29),
    ('mono8', 255, 'mono16', 65535),
    ('mono16', 65535, 'mono8', 255),
    ('mono16', 129, 'mono8', 1),
    ('rgb16', [257, 0, 65535], 'bgr8', [255, 0, 1]),
    ('16UC1', 1000, '32FC1', 1000.0),
    ('32FC1', 2.5, '16UC1', 2),
    ('32FC1', -1.0, '8UC1', 0),
    ('mono8', 5, '8UC1', 5),
])
def test_conversions(source, pixel, desired, expected):
    """Numbers of OpenCV's cvtColor and convertTo."""
    kind, _ = BRIDGE.encoding_to_dtype_with_channels(source)
    found = BRIDGE.imgmsg_to_cv2(
        BRIDGE.cv2_to_imgmsg(np.array([[pixel]], kind), source), desired)
    assert found[0, 0].tolist() == expected
    assert found.dtype == BRIDGE.encoding_to_dtype_with_channels(desired)[0]


@pytest.mark.parametrize(('source', 'desired', 'text'), [
    ('16UC1', 'mono8', 'not a color format'),
    ('8UC3', '8UC1', 'same number of channels'),
    ('bayer_rggb8', 'rgb8', 'read and written only as it is'),
    ('mono8', 'nope', 'Unrecognized image encoding'),
])
def test_conversions_that_make_no_sense(source, desired, text):
    """The words are upstream's where it has some."""
    kind, channels = BRIDGE.encoding_to_dtype_with_channels(source)
    message = BRIDGE.cv2_to_imgmsg(image(kind, channels), source)
    with pytest.raises(CvBridgeError, match=text):
        BRIDGE.imgmsg_to_cv2(message, desired)


def test_what_is_no_image():
    """Wrong types, sizes and encodings."""
    with pytest.raises(CvBridgeError, match='image has incompatible type 16UC1'):
        BRIDGE.cv2_to_imgmsg(image('uint16', 1), 'mono8')
    with pytest.raises(CvBridgeError, match='cannot have the type'):
        BRIDGE.cv2_to_imgmsg(image('int64', 1))
    with pytest.raises(TypeError, match='not a numpy array'):
        BRIDGE.cv2_to_imgmsg([[1]])
    with pytest.raises(CvBridgeError, match='too few for 4 x 4 pixels of rgb8'):
        BRIDGE.imgmsg_to_cv2(Image(height=4, width=4, step=12, encoding='rgb8'))


def test_compressed_images_without_opencv(monkeypatch):
    """The error says what to install."""
    monkeypatch.setitem(sys.modules, 'cv2', None)
    with pytest.raises(CvBridgeError, match='pip install opencv-python-headless'):
        BRIDGE.compressed_imgmsg_to_cv2(CompressedImage())
    with pytest.raises(CvBridgeError, match='pip install opencv-python-headless'):
        BRIDGE.cv2_to_compressed_imgmsg(image('uint8', 3))
