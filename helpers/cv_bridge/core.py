# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The converter of cv_bridge."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
import numpy.typing as npt
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from cv_bridge.encodings import convert, CvBridgeError, parse, TYPE_NAMES

__all__ = ['CvBridge', 'CvBridgeError']


class CvBridge:
    """Converts between messages and the arrays that OpenCV uses: height, width, channels."""

    def imgmsg_to_cv2(self, img_msg: Image,
                      desired_encoding: str = 'passthrough') -> npt.NDArray[Any]:
        """
        Return the array of an image; with one channel it has two dimensions.

        :param desired_encoding: of sensor_msgs, such as bgr8 (default: the message's).
        :raises CvBridgeError: the encoding is not known, or cannot be converted to the desired.
        """
        encoding = parse(img_msg.encoding)
        kind = encoding.dtype.newbyteorder('>' if img_msg.is_bigendian else '<')
        pixel = kind.itemsize * encoding.channels
        if img_msg.step < img_msg.width * pixel or (
                len(img_msg.data) < img_msg.height * img_msg.step):
            raise CvBridgeError(
                f'{len(img_msg.data)} bytes with a step of {img_msg.step} are too few for '
                f'{img_msg.width} x {img_msg.height} pixels of {img_msg.encoding}')
        image: npt.NDArray[Any] = np.ndarray(
            (img_msg.height, img_msg.width, encoding.channels), kind,
            memoryview(img_msg.data), strides=(img_msg.step, pixel, kind.itemsize))
        if encoding.channels == 1:
            image = image[..., 0]
        image = np.ascontiguousarray(image, encoding.dtype)
        if desired_encoding == 'passthrough':
            return image
        return convert(image, img_msg.encoding, desired_encoding)

    def cv2_to_imgmsg(self, cvim: npt.NDArray[Any], encoding: str = 'passthrough',
                      header: Header | None = None) -> Image:
        """
        Return the message of an array.

        :param encoding: of sensor_msgs, such as bgr8 (default: the array's type, such as 8UC3).
        :raises CvBridgeError: the array does not have the encoding's type.
        """
        if not isinstance(cvim, (np.ndarray, np.generic)):
            raise TypeError('Your input type is not a numpy array')
        kind = self.dtype_with_channels_to_cvtype2(
            cvim.dtype, 1 if cvim.ndim < 3 else cvim.shape[2])
        if encoding != 'passthrough' and parse(encoding).name != kind:
            raise CvBridgeError(
                f'encoding specified as {encoding}, but image has incompatible type {kind}')
        message = Image(
            height=cvim.shape[0], width=cvim.shape[1],
            encoding=kind if encoding == 'passthrough' else encoding,
            is_bigendian=cvim.dtype.byteorder == '>')
        if header is not None:
            message.header = header
        message.data = array.array('B', cvim.tobytes())
        message.step = len(message.data) // message.height if message.height else 0
        return message

    def compressed_imgmsg_to_cv2(self, cmprs_img_msg: CompressedImage,
                                 desired_encoding: str = 'passthrough') -> npt.NDArray[Any]:
        """
        Return the array of a compressed image; needs OpenCV.

        :param desired_encoding: of sensor_msgs (default: as OpenCV decodes it, bgr8 or mono8).
        :raises CvBridgeError: the data is not an image, or OpenCV is not installed.
        """
        cv2 = _opencv()
        image = cv2.imdecode(np.frombuffer(cmprs_img_msg.data, np.uint8), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise CvBridgeError(f'OpenCV cannot decode the {len(cmprs_img_msg.data)} bytes of '
                                f"format '{cmprs_img_msg.format}'")
        if desired_encoding == 'passthrough':
            return np.asarray(image)
        depth = '16' if image.dtype == np.uint16 else '8'
        kind = 'mono' if image.ndim == 2 else {3: 'bgr', 4: 'bgra'}[image.shape[2]]
        return convert(image, kind + depth, desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim: npt.NDArray[Any],
                                 dst_format: str = 'jpg') -> CompressedImage:
        """
        Return the compressed message of an array; needs OpenCV.

        :param dst_format: jpg, png or another of OpenCV's file name extensions.
        :raises CvBridgeError: OpenCV cannot write that, or is not installed.
        """
        if not isinstance(cvim, (np.ndarray, np.generic)):
            raise TypeError('Your input type is not a numpy array')
        cv2 = _opencv()
        try:
            done, data = cv2.imencode(f'.{dst_format}', cvim)
        except cv2.error as error:
            raise CvBridgeError(str(error)) from None
        if not done:
            raise CvBridgeError(f"OpenCV cannot write this image as '{dst_format}'")
        message = CompressedImage(format=dst_format)
        message.data = array.array('B', data.tobytes())
        return message

    def dtype_with_channels_to_cvtype2(self, dtype: np.dtype[Any], n_channels: int) -> str:
        """Return the name of an array's type, such as 8UC3."""
        try:
            return f'{TYPE_NAMES[np.dtype(dtype).name]}C{n_channels}'
        except KeyError:
            raise CvBridgeError(f'images cannot have the type {dtype}; allowed: '
                                f'{", ".join(TYPE_NAMES)}') from None

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return the array's type and number of channels of an encoding."""
        parsed = parse(encoding)
        return parsed.dtype.name, parsed.channels


def _opencv() -> Any:
    try:
        import cv2
    except ImportError as error:
        raise CvBridgeError('compressed images need OpenCV: pip install opencv-python-headless '
                            f'({error})') from None
    return cv2
