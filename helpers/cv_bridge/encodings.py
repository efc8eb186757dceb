# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Image encodings of REP 118 and conversions between colours."""

from __future__ import annotations

from dataclasses import dataclass
import re
from typing import Any

import numpy as np
import numpy.typing as npt


class CvBridgeError(TypeError):
    """An image cannot be converted."""


@dataclass(frozen=True)
class Encoding:
    """
    The meaning of an encoding.

    :param name: of the array's type, such as 8UC3.
    :param order: the channels' colours, such as bgr; empty where they are not colours.
    """

    name: str
    dtype: np.dtype[Any]
    channels: int
    order: str


TYPE_NAMES = {'uint8': '8U', 'int8': '8S', 'uint16': '16U', 'int16': '16S', 'int32': '32S',
              'float32': '32F', 'float64': '64F'}
_TYPES = {short: np.dtype(name) for name, short in TYPE_NAMES.items()}
_CHANNELS = {'mono': 1, 'bgr': 3, 'rgb': 3, 'bgra': 4, 'rgba': 4}
#: Two bytes a pixel; converted by OpenCV alone.
_YUV = {'yuv422', 'uyvy', 'yuv422_yuy2', 'yuyv'}
#: Weights of red, green and blue in grey, as integers of 15 bits.
_GREY = np.array([9798, 19235, 3735], np.int64)


def parse(encoding: str) -> Encoding:
    """
    Return the meaning of an encoding.

    :raises CvBridgeError: it is not known.
    """
    raw = re.fullmatch(r'(8U|8S|16U|16S|32S|32F|64F)C?(\d+)?', encoding)
    if raw:
        channels = int(raw[2] or 1)
        return Encoding(f'{raw[1]}C{channels}', _TYPES[raw[1]], channels, '')
    colour = re.fullmatch(r'(mono|bgra?|rgba?)(8|16)', encoding)
    if colour:
        kind, order = f'{colour[2]}U', colour[1]
        channels = _CHANNELS[order]
        return Encoding(f'{kind}C{channels}', _TYPES[kind], channels, order)
    bayer = re.fullmatch(r'bayer_(rggb|bggr|gbrg|grbg)(8|16)', encoding)
    if bayer:
        return Encoding(f'{bayer[2]}UC1', _TYPES[f'{bayer[2]}U'], 1, f'bayer_{bayer[1]}')
    if encoding in _YUV:
        return Encoding('8UC2', _TYPES['8U'], 2, 'yuv')
    raise CvBridgeError(f'Unrecognized image encoding [{encoding}]')


def convert(image: npt.NDArray[Any], source: str, desired: str) -> npt.NDArray[Any]:
    """
    Return an image in another encoding.

    :param source: the image's encoding.
    :raises CvBridgeError: there is no such conversion.
    """
    before, after = parse(source), parse(desired)
    if source == desired:
        return image
    if not before.order or not after.order:
        if not before.order and after.order:
            raise CvBridgeError(f'[{source}] is not a color format. but [{desired}] is. '
                                'The conversion does not make sense')
        if before.channels != after.channels:
            raise CvBridgeError(
                f'[{source}] and [{desired}] do not have the same number of channels')
    elif before.order != after.order:
        image = _recoloured(image, before, after, source, desired)
    return _as_depth(image, before.dtype, after.dtype)


def _recoloured(image: npt.NDArray[Any], before: Encoding, after: Encoding, source: str,
                desired: str) -> npt.NDArray[Any]:
    for encoding, name in ((before, source), (after, desired)):
        if encoding.order not in _CHANNELS:
            raise CvBridgeError(f'conversion from [{source}] to [{desired}] is not supported: '
                                f'[{name}] can be read and written only as it is')
    if before.order == 'mono':
        colours = np.repeat(image[..., np.newaxis], 3, axis=2)
    else:
        colours = image[..., [before.order.index(colour) for colour in 'rgb']]
    if after.order == 'mono':
        return ((colours @ _GREY + (1 << 14)) >> 15).astype(image.dtype)
    if 'a' in after.order:
        alpha = image[..., 3:] if 'a' in before.order else np.full(
            (*image.shape[:2], 1), np.iinfo(image.dtype).max, image.dtype)
        colours = np.concatenate([colours, alpha], axis=2)
    return np.ascontiguousarray(colours[..., ['rgba'.index(colour) for colour in after.order]])


def _as_depth(image: npt.NDArray[Any], before: np.dtype[Any],
              after: np.dtype[Any]) -> npt.NDArray[Any]:
    """Return an image with another type: 8 and 16 bits are scaled, others are clipped."""
    if before == after:
        return image
    if (before.name, after.name) == ('uint8', 'uint16'):
        return image.astype(np.uint16) * np.uint16(257)
    if (before.name, after.name) == ('uint16', 'uint8'):
        return np.rint(image / 257.0).astype(np.uint8)
    if after.kind == 'f':
        return image.astype(after)
    limits = np.iinfo(after)
    return np.asarray(np.clip(np.rint(image), limits.min, limits.max)).astype(after)
