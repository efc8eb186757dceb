# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a depth camera measures, by rays and without graphics."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix
from armsim_ros.sim.camera.camera import Camera, NEAR

#: Groups of geoms that are drawn, and so are seen.
_SEEN = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)
#: An argument that came with a later release.
_NO_NORMALS = {'normal': None} if 'normal:' in str(mujoco.mj_multiRay.__doc__) else {}


class RayPicture(NamedTuple):
    """
    Depth as points.

    :param points: (k, 3) [m] in the camera's optical frame.
    :param beyond: (j, 3) [m] ends of the rays that have hit nothing within the range.
    :param pose: (4, 4) of the optical frame in the world.
    """

    points: NDArray[np.float32]
    beyond: NDArray[np.float32]
    pose: Matrix


def ray_picture(camera: Camera, model: Any, data: Any, every: int) -> RayPicture:
    """
    Return what every n-th pixel of every n-th line measures.

    :param model: ``MjModel``, whose state is ``data``.
    :param every: 1 for all pixels.
    """
    body = model.body(camera.body).id
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
    pose = pose @ camera.optical_pose
    u, v = camera.centre
    columns, lines = np.meshgrid(
        (np.arange(0, camera.width, every) - u) / camera.focal,
        (np.arange(0, camera.height, every) - v) / camera.focal)
    ways = np.stack([columns.ravel(), lines.ravel(), np.ones(columns.size)], axis=-1)
    count = len(ways)
    found, depths = np.zeros(count, dtype=np.int32), np.zeros(count)
    # A ray's length is counted in lengths of its vector, which is 1 m along the axis.
    mujoco.mj_multiRay(
        m=model, d=data, pnt=pose[:3, 3].copy(), vec=(ways @ pose[:3, :3].T).ravel(),
        geomgroup=_SEEN, flg_static=1, bodyexclude=body, geomid=found, dist=depths, nray=count,
        cutoff=mujoco.mjMAXVAL, **_NO_NORMALS)
    # What is as near as that is not drawn either: the camera's housing.
    for ray in np.flatnonzero((found >= 0) & (depths < NEAR)):
        way = pose[:3, :3] @ ways[ray]
        depths[ray] = NEAR + mujoco.mj_ray(
            m=model, d=data, pnt=pose[:3, 3] + NEAR * way, vec=way, geomgroup=_SEEN,
            flg_static=1, bodyexclude=body, geomid=found[ray:ray + 1], **_NO_NORMALS)
    nearest, farthest = camera.range
    hit = found >= 0
    seen = hit & (depths >= nearest) & (depths <= farthest)
    empty = ~hit | (depths > farthest)
    return RayPicture((ways[seen] * depths[seen, None]).astype(np.float32),
                      (ways[empty] * farthest).astype(np.float32), pose)
