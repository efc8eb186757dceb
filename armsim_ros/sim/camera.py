# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A camera: where it sits, how it sees, what it draws from, and the picture that it makes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import math
import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix
from armsim_ros.config.simulation import CameraSettings
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import pose_matrix

#: Of a camera's body, x forward and z up, to its optical frame, z forward and x right (REP 103).
TO_OPTICAL = pose_matrix(rpy=(-math.pi / 2, 0.0, -math.pi / 2))
#: What is nearer is not seen, so that a camera sees through its own housing [m].
NEAR = 0.02


@dataclass(frozen=True)
class Camera:
    """
    A camera of colour and depth.

    :param name: its topics begin with it.
    :param body: MuJoCo's name of the body that carries it.
    :param mount: (16,) row by row, pose of its optical frame in that body.
    :param parent: frame that carries it, '' where the URDF has the camera's frames.
    :param focal: focal length [pixels]; pixels are square.
    :param range: nearest and farthest depth [m].
    :param period_ns: time between two pictures [ns].
    """

    name: str
    body: str
    mount: tuple[float, ...]
    parent: str
    width: int
    height: int
    focal: float
    range: tuple[float, float]
    period_ns: int

    @property
    def optical_frame(self) -> str:
        """The frame of its pictures."""
        return f'{self.name}_color_optical_frame'

    @property
    def centre(self) -> tuple[float, float]:
        """Where its axis meets the picture [pixels]; a pixel's centre has whole coordinates."""
        return (self.width - 1) / 2.0, (self.height - 1) / 2.0

    @property
    def optical_pose(self) -> Matrix:
        """Pose of its optical frame in the body (4, 4)."""
        return np.array(self.mount).reshape(4, 4)

    @property
    def transforms(self) -> tuple[tuple[str, str, Matrix], ...]:
        """Parent, child and pose (4, 4) of the frames that the URDF has not."""
        if not self.parent:
            return ()
        link = f'{self.name}_link'
        return ((self.parent, link, self.optical_pose @ np.linalg.inv(TO_OPTICAL)),
                (link, self.optical_frame, TO_OPTICAL))


def cameras_of(settings: Mapping[str, CameraSettings], model: RobotModel) -> tuple[Camera, ...]:
    """
    Return the cameras that simulation.yaml names.

    :raises SimulationError: a camera is on a link that is not there, or has a frame of the URDF.
    """
    return tuple(_camera(name, camera, model) for name, camera in settings.items())


def _camera(name: str, settings: CameraSettings, model: RobotModel) -> Camera:
    optical, link = f'{name}_color_optical_frame', settings.link
    links = tuple(model.links)
    if not link:
        if optical not in links:
            raise SimulationError(
                f"camera '{name}': robot '{model.name}' has no link '{optical}'; give with 'link' "
                'and xyz, rpy where the camera sits')
        body, mount = f'{model.name}/{optical}', np.eye(4)
    else:
        own = [frame for frame in (f'{name}_link', optical) if frame in links]
        if own:
            raise SimulationError(
                f"camera '{name}': robot '{model.name}' has the link '{own[0]}' already; leave "
                "'link' out, or give the camera another name")
        if link not in (*links, model.parent_frame):
            raise SimulationError(
                f"camera '{name}' sits on '{link}', which is not a link of robot '{model.name}'; "
                + (nearest(link, links) or 'see its URDF; for a camera beside the robot add a '
                   'virtual_joint with this parent_frame to its SRDF'))
        body = f'{model.name}/{link}' if link in links else 'world'
        mount = pose_matrix(settings.xyz, settings.rpy) @ TO_OPTICAL
    return Camera(
        name=name, body=body, mount=tuple(mount.ravel().tolist()), parent=link,
        width=settings.width, height=settings.height,
        focal=settings.focal_length * settings.height, range=settings.range,
        period_ns=round(1e9 / settings.rate))


Depths = NDArray[np.float32]


class Picture(NamedTuple):
    """
    Colour and depth of a moment.

    :param colour: (h, w, 3) red, green, blue.
    :param depth: (h, w) along the camera's axis [m]; +inf where nothing is within the range, -inf
        where something is nearer than it (REP 118).
    """

    colour: NDArray[np.uint8]
    depth: Depths


def measured(depth: Depths, limits: tuple[float, float]) -> Depths:
    """Return depths [m] with what lies beyond the range (nearest, farthest) [m] as infinite."""
    nearest, farthest = limits
    depth = np.where(depth > farthest, np.float32(np.inf), depth)
    return np.where(depth < nearest, np.float32(-np.inf), depth)


def points(picture: Picture, camera: Camera) -> NDArray[np.float32]:
    """
    Return the points that the pixels show.

    :returns: (h, w, 4) x, y, z in the optical frame [m], NaN where no depth is, and the colour
        as PCL has it: three bytes in a float.
    """
    depth = np.where(np.isfinite(picture.depth), picture.depth, np.float32(np.nan))
    centre_u, centre_v = camera.centre
    columns = (np.arange(camera.width, dtype=np.float32) - centre_u) / camera.focal
    lines = (np.arange(camera.height, dtype=np.float32) - centre_v) / camera.focal
    found = np.empty((*depth.shape, 4), np.float32)
    found[..., 0] = depth * columns.astype(np.float32)
    found[..., 1] = depth * lines.astype(np.float32)[:, None]
    found[..., 2] = depth
    packed = picture.colour.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    found[..., 3] = packed.view(np.float32)
    return found


_HEAD = struct.Struct('<Hq')


class Snapshot(NamedTuple):
    """
    The poses of all bodies at a time.

    :param camera: number of the camera that is to show it.
    :param time_ns: simulated time [ns].
    :param places: positions of all joints, then of all bodies in their parents, then quaternions
        of these: fixed objects can be moved, too.
    """

    camera: int
    time_ns: int
    places: bytes

    def to_bytes(self) -> bytes:
        """Return it as a message."""
        return _HEAD.pack(self.camera, self.time_ns) + self.places

    @staticmethod
    def from_bytes(message: bytes) -> Snapshot:
        """Return the snapshot of a message."""
        camera, time_ns = _HEAD.unpack_from(message)
        return Snapshot(camera, time_ns, message[_HEAD.size :])


def take_snapshot(camera: int, time_ns: int, model: Any, data: Any) -> Snapshot:
    """Return the present state of an ``MjModel`` and its ``MjData``."""
    return Snapshot(camera, time_ns, b''.join(
        (data.qpos.tobytes(), model.body_pos.tobytes(), model.body_quat.tobytes())))
