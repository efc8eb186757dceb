# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point clouds and depth images to points in arrays, and back."""

from __future__ import annotations

from array import array
import sys
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from armsim_ros.arrays import Mask
from armsim_ros.config.sensors_3d import DepthImageSensor

Floats = NDArray[np.float32]

#: Encodings of depth images -> type of a pixel, and its unit [m].
_DEPTHS = {'32FC1': ('f4', 1.0), '16UC1': ('u2', 1e-3), 'mono16': ('u2', 1e-3)}


def points_of_cloud(message: PointCloud2, subsample: int = 1) -> Floats:
    """
    Return the points (k, 3) [m] of a cloud that are finite.

    :param subsample: every n-th row and column counts.
    :raises ValueError: the message is not a cloud with x, y and z.
    """
    fields = {field.name: field for field in message.fields}
    missing = [name for name in 'xyz' if name not in fields]
    if missing:
        raise ValueError(f"the cloud has no field {', '.join(missing)}; its fields: "
                         f"{', '.join(fields) or 'none'}")
    height, width, step = message.height, message.width, message.point_step
    for name in 'xyz':
        field = fields[name]
        if field.datatype != PointField.FLOAT32:
            raise ValueError(f"the field '{name}' of the cloud has the type {field.datatype}; "
                             f'allowed: {PointField.FLOAT32} (FLOAT32)')
        if field.offset + 4 > step:
            raise ValueError(f"the field '{name}' of the cloud begins at byte {field.offset} of "
                             f'points of {step} bytes')
    row = max(message.row_step, width * step)
    if message.row_step < width * step and height > 1:
        raise ValueError(f'the rows of the cloud have {message.row_step} bytes, but {width} '
                         f'points of {step} bytes')
    needed = (height - 1) * row + width * step if height and width else 0
    if len(message.data) < needed:
        raise ValueError(f'the cloud has {len(message.data)} bytes; {height} x {width} points of '
                         f'{step} bytes need {needed}')
    if not needed:
        return np.zeros((0, 3), dtype=np.float32)
    kind = np.dtype('>f4' if message.is_bigendian else '<f4')
    data = np.frombuffer(message.data, dtype=np.uint8)
    found = np.empty((3, len(range(0, height, subsample)) * len(range(0, width, subsample))),
                     dtype=np.float32)
    for axis, name in enumerate('xyz'):
        view: NDArray[np.float32] = np.ndarray(
            (height, width), kind, data, fields[name].offset, (row, step))
        found[axis] = view[::subsample, ::subsample].ravel()
    finite = np.isfinite(found[0]) & np.isfinite(found[1]) & np.isfinite(found[2])
    points: Floats = found.T[finite]
    return points


class DepthPoints(NamedTuple):
    """
    What a depth image shows in its optical frame.

    :param points: (k, 3) [m].
    :param pixels: (k,) their places in the image, row by row.
    :param beyond: (j, 3) [m] on the far plane, of the pixels that see nothing before it.
    """

    points: Floats
    pixels: NDArray[np.int64]
    beyond: Floats


def points_of_depth(message: Image, info: CameraInfo, sensor: DepthImageSensor) -> DepthPoints:
    """
    Return the points of a depth image.

    :param info: how the camera maps points to pixels.
    :param sensor: range and border.
    :raises ValueError: the messages are not a depth image and its camera.
    """
    depth = depth_image(message)
    focal_x, focal_y, u, v = info.k[0], info.k[4], info.k[2], info.k[5]
    if not (focal_x > 0.0 and focal_y > 0.0):
        raise ValueError(f'the camera_info has the focal lengths {focal_x} and {focal_y}')
    if (info.height, info.width) != depth.shape:
        raise ValueError(f'the depth image has {depth.shape[1]} x {depth.shape[0]} pixels, its '
                         f'camera_info {info.width} x {info.height}')
    rows, columns = sensor.skip_vertical_pixels, sensor.skip_horizontal_pixels
    height, width = depth.shape
    inner = np.zeros(depth.shape, dtype=bool)
    inner[rows:height - rows, columns:width - columns] = True
    far = sensor.far_clipping_plane_distance
    with np.errstate(invalid='ignore'):
        seen = inner & (depth >= sensor.near_clipping_plane_distance) & (depth <= far)
        empty = inner & (depth > far)

    def ways(pixels: NDArray[np.int64]) -> Floats:
        line, column = np.divmod(pixels, width)
        made: Floats = np.stack([(column - u) / focal_x, (line - v) / focal_y,
                                 np.ones(len(pixels))], axis=-1).astype(np.float32)
        return made

    pixels = np.flatnonzero(seen)
    return DepthPoints(ways(pixels) * depth.ravel()[pixels, None], pixels,
                       ways(np.flatnonzero(empty)) * np.float32(far))


def depth_image(message: Image) -> Floats:
    """
    Return depths (h, w) [m]; 0 of whole numbers is no depth.

    :raises ValueError: it is not a depth image.
    """
    if message.encoding not in _DEPTHS:
        raise ValueError(f"the image has the encoding '{message.encoding}'; allowed: "
                         f"{', '.join(_DEPTHS)}")
    name, unit = _DEPTHS[message.encoding]
    kind = np.dtype(('>' if message.is_bigendian else '<') + name)
    height, width, step = message.height, message.width, message.step
    if step < width * kind.itemsize or len(message.data) < height * step:
        raise ValueError(f'the image has {len(message.data)} bytes in rows of {step}; {width} x '
                         f'{height} pixels of {kind.itemsize} bytes need more')
    pixels: NDArray[np.generic] = np.ndarray(
        (height, width), kind, np.frombuffer(message.data, np.uint8), 0, (step, kind.itemsize))
    depth: Floats = pixels.astype(np.float32) * np.float32(unit)
    if name == 'u2':
        depth[depth == 0.0] = np.nan
    return depth


def cloud_of_points(points: Floats, like: PointCloud2) -> PointCloud2:
    """Return points (k, 3) [m] as a cloud with a single row and another cloud's header."""
    data = array('B')
    data.frombytes(np.ascontiguousarray(points, dtype=np.float32).tobytes())
    fields = [PointField(name=name, offset=4 * k, datatype=PointField.FLOAT32, count=1)
              for k, name in enumerate('xyz')]
    return PointCloud2(header=like.header, height=1, width=len(points), fields=fields,
                       is_bigendian=sys.byteorder == 'big', point_step=12,
                       row_step=12 * len(points), is_dense=True, data=data)


def image_of_kept(message: Image, pixels: NDArray[np.int64], kept: Mask) -> Image:
    """Return a depth image (16UC1) [mm] of the pixels that are kept; all others are 0."""
    depth = depth_image(message).ravel()
    left = np.zeros(len(depth), dtype=np.uint16)
    which = pixels[kept]
    left[which] = np.clip(np.round(1000.0 * depth[which]), 0, 65535).astype(np.uint16)
    data = array('B')
    data.frombytes(left.tobytes())
    return Image(header=message.header, height=message.height, width=message.width,
                 encoding='16UC1', is_bigendian=sys.byteorder == 'big', step=2 * message.width,
                 data=data)
