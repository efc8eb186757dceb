# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Visibility constraints: a disc that a sensor must see.

The rules are those of MoveIt's ``kinematic_constraint.cpp``, VisibilityConstraint.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
import math
import sys
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.coal_shapes import exact_shape
from armsim_ros.planning.constraint_terms import ConstraintResult, Frame, Poses
from armsim_ros.planning.request import VisibilityConstraint


@dataclass(frozen=True, slots=True, eq=False)
class LinkShape:
    """
    A collision shape of a link.

    :param pose: (4, 4) on the link.
    :param shape: of coal.
    """

    link: str
    pose: Matrix
    shape: Any


def link_shapes(model: KinematicModel, exempt: Iterable[str]) -> tuple[LinkShape, ...]:
    """Return the collision shapes of all links but those that may be inside the cone."""
    return tuple(
        LinkShape(name, item.origin, exact_shape(item.geometry))
        for name, link in model.robot.links.items() if name not in exempt
        for item in link.collisions)


@dataclass(frozen=True, slots=True, eq=False)
class VisibilityTerm:
    """
    A disc that faces a sensor, in its field of view, with no link in between.

    :param given: radius, angles and number of sides.
    :param sensor: the frame whose axis is the direction of view.
    :param target: the frame of the disc, which lies in its x-y plane.
    :param shapes: those that must not touch the cone between the sensor and the disc.
    """

    given: VisibilityConstraint
    sensor: Frame
    target: Frame
    shapes: tuple[LinkShape, ...]

    @property
    def links(self) -> tuple[str, ...]:
        """All links whose poses are needed."""
        return self.sensor.link, self.target.link, *(each.link for each in self.shapes)

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """Return the result for poses of the links; the distance is how deep a link reaches in."""
        given, sensor, target = self.given, self.sensor.pose(poses), self.target.pose(poses)
        axis: Vector = sensor[:3, 2 - given.sensor_view_direction]
        way = target[:3, 3] - sensor[:3, 3]
        length = float(np.linalg.norm(way))
        for name, direction, limit in (
            ('view', -target[:3, 2], given.max_view_angle),
            ('range', way / length if length > 0.0 else axis, given.max_range_angle),
        ):
            angle = math.acos(min(1.0, max(-1.0, float(axis @ direction))))
            if enabled(limit) and angle > min(limit, 0.5 * math.pi):
                return ConstraintResult(False, 0.0, (
                    f"the {name} angle from '{given.sensor_frame_id}' to "
                    f"'{given.target_frame_id}' is {angle:.4f} rad, above {limit:.4f}"))
        link, depth = self._deepest(sensor, target, poses)
        return ConstraintResult(not link, depth, (
            f"link '{link}' is between the sensor in '{given.sensor_frame_id}' and the target in "
            f"'{given.target_frame_id}'" if link else
            f"the target in '{given.target_frame_id}' is visible"))

    def _deepest(self, sensor: Matrix, target: Matrix, poses: Poses) -> tuple[str, float]:
        """Return the link that is deepest in the cone and how deep [m]; '' where none is."""
        if not enabled(abs(self.given.target_radius)):
            return '', 0.0
        cone = self._cone(sensor, target)
        request = coal.CollisionRequest()
        link, deepest = '', 0.0
        for each in self.shapes:
            pose = poses[each.link] @ each.pose
            result = coal.CollisionResult()
            coal.collide(cone, coal.Transform3s.Identity(), each.shape,
                         coal.Transform3s(pose[:3, :3], pose[:3, 3]), request, result)
            if result.isCollision():
                depth = abs(float(result.getContact(0).penetration_depth))
                if not link or depth > deepest:
                    link, deepest = each.link, depth
        return link, deepest

    def _cone(self, sensor: Matrix, target: Matrix) -> Any:
        """Return the solid between the sensor and the disc as coal's shape."""
        sides = max(3, self.given.cone_sides)
        angles = 2.0 * math.pi / sides * np.arange(sides)
        rim = self.given.target_radius * np.array([np.sin(angles), np.cos(angles), 0.0 * angles])
        corners = coal.StdVec_Vec3s()
        corners.extend([sensor[:3, 3], target[:3, 3], *(target[:3, :3] @ rim).T + target[:3, 3]])
        return coal.Convex(corners, _triangles(sides))


@lru_cache(8)
def _triangles(sides: int) -> Any:
    """Return the triangles of a cone whose corners are its tip, the disc's middle and its rim."""
    triangles = coal.StdVec_Triangle()
    for side in range(sides):
        for middle in (0, 1):
            triangles.append(coal.Triangle(2 + side, middle, 2 + (side + 1) % sides))
    return triangles


def enabled(value: float) -> bool:
    """Return whether a radius [m] or an angle [rad] is a condition."""
    return value > sys.float_info.epsilon
