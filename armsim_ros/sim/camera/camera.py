# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A camera: where it sits, how it sees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

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
        if link not in (*links, model.model_frame):
            raise SimulationError(
                f"camera '{name}' sits on '{link}', which is not a link of robot '{model.name}'; "
                + (nearest(link, links) or 'see its URDF'))
        body = f'{model.name}/{link}' if link in links else 'world'
        mount = pose_matrix(settings.xyz, settings.rpy) @ TO_OPTICAL
    return Camera(
        name=name, body=body, mount=tuple(mount.ravel().tolist()), parent=link,
        width=settings.width, height=settings.height,
        focal=settings.focal_length * settings.height, range=settings.range,
        period_ns=round(1e9 / settings.rate),
    )
