# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far the points of a robot move at most when its joints move."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import Joint, JointType
from armsim_ros.model.shape_points import corner_points

#: What a sliding joint without limits counts as [m].
LONGEST_TRAVEL = 1e3

Extent = tuple[float, float]
"""Largest distances [m] from a joint's axis and from its origin."""

_NONE: Extent = (0.0, 0.0)


class DisplacementBounds:
    """
    Bounds of link displacement by joint displacement.

    A point that a turning joint carries moves by at most the angle times its distance from
    the axis; that distance is at most the sum of the lengths between the joints that lie
    between, wherever these are. A sliding joint moves a point by its own travel. So the
    motion of a link is at most the sum over the joints above it of weight times travel.

    :param kinematics: the robot.
    :param loads: Pinocchio's joint number -> points (k, 3) [m] around what it carries besides
        the links.
    """

    def __init__(self, kinematics: KinematicModel, loads: Mapping[int, Matrix]) -> None:
        self._kinematics = kinematics
        links: dict[int, Extent] = kinematics.cached('extents of links', lambda: {
            body: _extent(kinematics, body, points)
            for body, points in _link_points(kinematics).items()})
        carried = {body: _extent(kinematics, body, points)
                   for body, points in loads.items()}
        #: Joint numbers of Pinocchio that carry any shape, a row each of ``weights``.
        self.bodies: tuple[int, ...] = tuple(sorted({*links, *carried} - {0}))
        rows = [
            self._row(body, _both(links.get(body, _NONE), carried.get(body, _NONE)))
            for body in self.bodies
        ]
        #: (bodies, n) [m/rad] for turning joints, [m/m] for sliding ones.
        self.weights: Matrix = np.array(rows).reshape(len(rows), kinematics.n)
        self._group_rows: dict[str, Matrix] = {}
        #: (joints, joints, n) like the weights, of what a joint carries as another joint sees it.
        self.relative: Matrix = self._relative()

    def displacement_bound(self, q1: Vector, q2: Vector, group: str | None = None) -> float:
        """
        Return a distance [m] that no point exceeds on the straight segment from q1 to q2.

        :param q1: (n,).
        :param q2: (n,).
        :param group: look only at links that this group moves.
        """
        weights = self.weights if group is None else self._rows(group)
        if not len(weights):
            return 0.0
        return float((weights @ np.abs(q2 - q1)).max())

    def _relative(self) -> Matrix:
        """Leave out the joints that carry both: these do not move relative to each other."""
        count = int(self._kinematics.model.njoints)
        weights = np.zeros((count, self._kinematics.n))
        weights[list(self.bodies)] = self.weights
        alone: Matrix = self._kinematics.cached(
            'joints that move a body and not another', self._alone)
        relative: Matrix = (
            weights[:, None] * alone + weights[None, :] * alone.transpose(1, 0, 2)
        )
        return relative

    def _alone(self) -> Matrix:
        """Return (joints, joints, n): 1 where a joint moves the first and not the second."""
        model = self._kinematics.model
        above = np.zeros((int(model.njoints), self._kinematics.n), dtype=bool)
        for joint in range(1, len(above)):
            above[joint] = above[int(model.parents[joint])]
            above[joint, joint - 1] = True
        alone: Matrix = (above[:, None] & ~above[None, :]).astype(np.float64)
        return alone

    def _rows(self, group: str) -> Matrix:
        found = self._group_rows.get(group)
        if found is None:
            joints = {
                self._kinematics.link_joint(link)[0]
                for link in self._kinematics.moved_links(group)
            }
            rows = [row for row, body in enumerate(self.bodies) if body in joints]
            found = self._group_rows[group] = self.weights[rows]
        return found

    def _row(self, body: int, extent: Extent) -> Vector:
        """Return how far each joint moves the points that a body's joint carries at most."""
        of_origin, turning = self._kinematics.cached(
            ('motion of the origin', body), lambda: self._origin_row(body))
        row: Vector = of_origin + extent[1] * turning
        if turning[body - 1]:
            row[body - 1] = extent[0]
        return row

    def _origin_row(self, body: int) -> tuple[Vector, Vector]:
        """Walk to the root; add up how far a joint's origin can be from each axis above it."""
        kinematics = self._kinematics
        model = kinematics.model
        weights, turning = np.zeros(kinematics.n), np.zeros(kinematics.n)
        joint = body
        #: Largest distance of the body's origin from the origin of the joint below this joint.
        reach = 0.0
        below: Vector = np.zeros(3)
        while joint:
            description = kinematics.robot.joints[kinematics.names[joint - 1]]
            from_axis = float(_off_axis(below[None], _axis(description))[0]) + reach
            reach += float(np.linalg.norm(below))
            if description.type is JointType.PRISMATIC:
                weights[joint - 1] = 1.0
                limits = description.limits
                reach += min(max(abs(limits.lower), abs(limits.upper)), LONGEST_TRAVEL)
            else:
                weights[joint - 1], turning[joint - 1] = from_axis, 1.0
            below = np.array(model.jointPlacements[joint].translation)
            joint = int(model.parents[joint])
        return weights, turning


def _extent(kinematics: KinematicModel, body: int, points: Matrix) -> Extent:
    """Return how far points (k, 3) that a joint carries are from it; nothing moves for joint 0."""
    if not body:
        return _NONE
    axis = _axis(kinematics.robot.joints[kinematics.names[body - 1]])
    return (float(_off_axis(points, axis).max(initial=0.0)),
            float(np.linalg.norm(points, axis=1).max(initial=0.0)))


def _both(first: Extent, other: Extent) -> Extent:
    return max(first[0], other[0]), max(first[1], other[1])


def _axis(joint: Joint) -> Vector:
    axis = np.asarray(joint.axis, dtype=np.float64)
    unit: Vector = axis / np.linalg.norm(axis)
    return unit


def _off_axis(points: Matrix, axis: Vector) -> Vector:
    """Return the distances (k,) [m] of points (k, 3) from an axis through the origin."""
    along = points @ axis
    off: Vector = np.linalg.norm(points - np.outer(along, axis), axis=1)
    return off


def _link_points(kinematics: KinematicModel) -> dict[int, Matrix]:
    """Return Pinocchio's joint number -> points (k, 3) [m] around the links that it carries."""
    points: dict[int, list[Matrix]] = {}
    for name, link in kinematics.robot.links.items():
        joint, offset = kinematics.link_joint(name)
        for item in link.collisions:
            points.setdefault(joint, []).append(
                corner_points(item.geometry, offset @ item.origin))
    return {joint: np.vstack(parts) for joint, parts in points.items()}
