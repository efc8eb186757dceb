# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is seen of a task besides robot and objects: cameras, a light, the mark of the target."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.env.variation import field_of_view
from armsim_ros.tasks.workspace import Workspace

TARGET = 'target'
#: Camera -> where it is from the middle of the workspace [m], and its focal length [heights].
CAMERAS: dict[str, tuple[tuple[float, float, float], float]] = {
    'front': ((0.0, 0.45, 0.35), 1.1),
    'side': ((0.5, 0.05, 0.25), 1.1),
    'top': ((0.0, 0.02, 0.6), 1.1),
}
LARGEST_PICTURE = 640


def decorate(spec: Any, place: Workspace, mark: str) -> None:
    """
    Add cameras, light and mark to a specification.

    :param spec: the ``MjSpec``.
    :param mark: ``disc`` on the table, ``ball`` in the air, or nothing.
    """
    middle = np.array([*place.centre, place.surface + 0.03])
    away = middle[:2] / max(1e-9, float(np.linalg.norm(middle[:2])))
    turn = np.array([[away[1], away[0]], [-away[0], away[1]]])  # y points away from the robot
    for name, (offset, focal) in CAMERAS.items():
        position = middle + np.append(turn @ np.array(offset[:2]), offset[2])
        spec.worldbody.add_camera(
            name=name, pos=position, quat=_looking(middle - position),
            fovy=field_of_view(focal))
    spec.worldbody.add_light(
        name='light', pos=[*place.centre, place.surface + 1.5], dir=[0.0, 0.0, -1.0],
        diffuse=[0.5, 0.5, 0.5], castshadow=False)
    size = spec.visual.global_
    size.offwidth, size.offheight = LARGEST_PICTURE, LARGEST_PICTURE
    if mark:
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER if mark == 'disc' else mujoco.mjtGeom.mjGEOM_SPHERE
        spec.worldbody.add_site(
            name=TARGET, pos=middle, type=kind, rgba=[0.1, 0.7, 0.2, 0.6],
            size=[0.03, 0.001, 0.0] if mark == 'disc' else [0.015, 0.0, 0.0])


def _looking(way: Vector) -> Vector:
    """Return the quaternion wxyz of a camera of MuJoCo's that looks along a way, upright."""
    back = -way / np.linalg.norm(way)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    quaternion = np.empty(4)
    matrix = np.column_stack((right, np.cross(back, right), back))
    mujoco.mju_mat2Quat(quaternion, matrix.ravel())
    return quaternion
