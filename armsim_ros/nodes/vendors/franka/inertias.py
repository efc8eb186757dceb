# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Masses at the flange: the end effector's, the load's, and both together."""

from __future__ import annotations

from dataclasses import dataclass, field

from geometry_msgs.msg import Inertia, Vector3
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import inverse_pose


def vector(values: Vector) -> Vector3:
    """Return a vector (3,) as a message."""
    x, y, z = map(float, values)
    return Vector3(x=x, y=y, z=z)


@dataclass(frozen=True, eq=False)
class Mass:
    """
    A rigid body in the axes of the flange.

    :param mass: [kg].
    :param centre: of mass (3,) [m].
    :param inertia: at the centre of mass (3, 3) [kg*m^2].
    """

    mass: float = 0.0
    centre: Vector = field(default_factory=lambda: np.zeros(3))
    inertia: Matrix = field(default_factory=lambda: np.zeros((3, 3)))

    def __add__(self, other: Mass) -> Mass:
        """Return both as a single body; a body without mass has no inertia."""
        parts = [part for part in (self, other) if part.mass > 0.0]
        mass = sum(part.mass for part in parts)
        if not parts:
            return Mass()
        centre = np.asarray(sum(part.mass * part.centre for part in parts)) / mass
        inertia = np.zeros((3, 3))
        for part in parts:
            way = part.centre - centre
            inertia += part.inertia + part.mass * (way @ way * np.eye(3) - np.outer(way, way))
        return Mass(mass, centre, inertia)

    def message(self) -> Inertia:
        """Return it as a message."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.inertia.tolist()
        return Inertia(m=self.mass, com=vector(self.centre),
                       ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)


def end_effector(model: RobotModel, arm: ArmDynamics, flange: str) -> Mass:
    """Return what is mounted at the flange, all of its joints at 0."""
    whole, to_flange = Mass(), inverse_pose(arm.frame(flange))
    for name, link in model.links.items():
        if link.inertial is None or not _carries(model, flange, name):
            continue
        pose = to_flange @ arm.frame(name) @ link.inertial.origin
        turn = pose[:3, :3]
        whole += Mass(link.inertial.mass, pose[:3, 3], turn @ link.inertial.inertia @ turn.T)
    return whole


def _carries(model: RobotModel, flange: str, link: str) -> bool:
    """Return whether a link is beyond the flange."""
    while (joint := model.parent_joint.get(link)) is not None:
        link = model.joints[joint].parent
        if link == flange:
            return True
    return False
