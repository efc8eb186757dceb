# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Draws the plant without a screen, and measures depths by rays without graphics."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix
from armsim_ros.sim.camera import Camera, measured, NEAR, Picture, Snapshot
from armsim_ros.sim.physics.compiler import model_from_bytes

#: What is farther is not drawn [m].
_FAR = 100.0
_MOST_GEOMS = 10_000
#: Light that comes from the camera: of all sides, of its own, mirrored.
_LIGHT = {'ambient': 0.45, 'diffuse': 0.55, 'specular': 0.05}


class SceneRenderer:
    """
    Draws pictures of a plant; only one thread may use it.

    :param cameras: all whose pictures are asked for.
    """

    def __init__(self, cameras: Iterable[Camera]) -> None:
        self._cameras = tuple(cameras)
        self._size = (max(camera.width for camera in self._cameras),
                      max(camera.height for camera in self._cameras))
        self._window = mujoco.GLContext(*self._size)
        self._window.make_current()
        self._context: Any = None

    def load(self, model: bytes) -> None:
        """Take another plant, an ``MjModel`` as bytes, and be ready to draw it."""
        self._plant = PlantCopy(model)
        visual = self._plant.model.vis
        visual.global_.offwidth, visual.global_.offheight = self._size
        # One sample a pixel: depths of two surfaces have no mean.
        visual.quality.offsamples = 0
        for part, strength in _LIGHT.items():
            getattr(visual.headlight, part)[:] = strength
        self._scene = mujoco.MjvScene(self._plant.model, _MOST_GEOMS)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        if self._context is not None:
            self._context.free()
        self._context = mujoco.MjrContext(self._plant.model, mujoco.mjtFontScale.mjFONTSCALE_50)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        # The first picture of a plant takes ten times as long as those after it.
        self._draw(self._cameras[0])

    def draw(self, snapshot: Snapshot) -> Picture:
        """Return what the snapshot's camera sees of it."""
        self._plant.show(snapshot)
        return self._draw(self._cameras[snapshot.camera])

    def _draw(self, camera: Camera) -> Picture:
        model, data = self._plant.model, self._plant.data
        mujoco.mjv_updateScene(
            model, data, mujoco.MjvOption(), None, mujoco.MjvCamera(),
            mujoco.mjtCatBit.mjCAT_ALL, self._scene)
        self._look_through(camera)
        # Once more: the light that comes from the camera.
        mujoco.mjv_makeLights(model, data, self._scene)
        place = mujoco.MjrRect(0, 0, camera.width, camera.height)
        mujoco.mjr_render(place, self._scene, self._context)
        colour = np.empty((camera.height, camera.width, 3), np.uint8)
        buffer = np.empty((camera.height, camera.width), np.float32)
        mujoco.mjr_readPixels(colour, buffer, place, self._context)
        return Picture(colour[::-1], measured(_metres(buffer)[::-1], camera.range))

    def close(self) -> None:
        """Give back what the graphics library holds."""
        if self._context is not None:
            self._context.free()
        self._window.free()

    def _look_through(self, camera: Camera) -> None:
        """Put both eyes of the scene where the camera is."""
        data = self._plant.data
        body = self._plant.model.body(camera.body).id
        carrier = data.xmat[body].reshape(3, 3)
        mount = camera.optical_pose
        axes = carrier @ mount[:3, :3]
        half = NEAR * 0.5 * camera.height / camera.focal
        for eye in self._scene.camera:
            eye.pos[:] = data.xpos[body] + carrier @ mount[:3, 3]
            eye.forward[:], eye.up[:] = axes[:, 2], -axes[:, 1]
            eye.frustum_center, eye.frustum_width = 0.0, 0.0
            eye.frustum_bottom, eye.frustum_top = -half, half
            eye.frustum_near, eye.frustum_far = NEAR, _FAR
            eye.orthographic = 0


def _metres(buffer: Any) -> Any:
    """Return depths along the axis [m] from a buffer that is 1 at ``NEAR`` and 0 at ``_FAR``."""
    return np.float32(NEAR * _FAR) / (buffer * np.float32(_FAR - NEAR) + np.float32(NEAR))


class PlantCopy:
    """
    A plant that does not move until a snapshot is shown.

    :param content: its ``MjModel`` as bytes.
    """

    def __init__(self, content: bytes) -> None:
        self.model = model_from_bytes(content)
        # What sleeps, and what never moves, would stay where it is.
        self.model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        self.data = mujoco.MjData(self.model)
        self._place()

    def show(self, snapshot: Snapshot) -> None:
        """Put all bodies where they were."""
        model, values = self.model, np.frombuffer(snapshot.places)
        joints, bodies = model.nq, model.nq + 3 * model.nbody
        self.data.qpos[:] = values[:joints]
        model.body_pos[:] = values[joints:bodies].reshape(-1, 3)
        model.body_quat[:] = values[bodies:].reshape(-1, 4)
        self._place()

    def _place(self) -> None:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)


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
