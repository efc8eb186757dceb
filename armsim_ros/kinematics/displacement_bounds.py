# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How far the points of a robot move at most when its joints move."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import corner_points
from armsim_ros.model.robot_model import Joint, JointType

#: What a sliding joint without limits counts as [m].
LONGEST_TRAVEL = 1e3
#: Error of distances in states [m]: a root of what is left of squares that cancel.
_ROUNDING = 1e-6

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
        count = int(kinematics.model.njoints)
        #: (joints, n) the weights of every joint, 0 where it carries nothing.
        self._of_joints: Matrix = np.zeros((count, kinematics.n))
        self._of_joints[list(self.bodies)] = self.weights
        self._alone: Matrix = kinematics.cached(
            'joints that move a body and not another', lambda: _alone(kinematics))
        #: (joints, joints, n) like the weights, of what a joint carries as another joint sees it.
        self.relative: Matrix = (
            self._of_joints[:, None] * self._alone
            + self._of_joints * self._alone.transpose(1, 0, 2))
        self._frames: JointFrames = kinematics.cached(
            'frames of joints', lambda: JointFrames(kinematics))
        self._centres, self._radii = self._spheres(loads)
        #: (joints, n, n): 1 where the second is between what the first carries and the axis of
        #: the third.
        self._between: Matrix = kinematics.cached(
            'joints between a body and an axis', lambda: _between(kinematics))

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

    def frames(self, states: Matrix) -> tuple[Matrix, Matrix]:
        """Return the frames of all joints in states (k, n), see ``JointFrames.poses``."""
        return self._frames.poses(states)

    def weights_near(self, frames: tuple[Matrix, Matrix], reach: Matrix) -> Matrix:
        """
        Return the weights (k, joints, n) of all joints near some states, mostly half of all.

        How far a point is from a joint's axis depends on the joints between the two: it is
        measured in each state, and cannot grow by more than these joints move the point.

        :param frames: what :meth:`frames` returns for the states.
        :param reach: (k, n) motion of every joint to either side [rad or m] for which it holds.
        """
        rotations, origins = frames
        centres = origins + (rotations @ self._centres[..., None])[..., 0]
        axes = (rotations[:, 1:] @ self._frames.axes[..., None])[..., 0]
        ways = centres[:, :, None] - origins[:, None, 1:]
        along = np.einsum('kjna,kna->kjn', ways, axes)
        squares = np.einsum('kjna,kjna->kjn', ways, ways) - along * along
        near = np.sqrt(np.maximum(squares, 0.0)) + (self._radii[:, None] + _ROUNDING)
        # What the joints between an axis and what another joint carries add.
        moved = (self._of_joints * reach[:, None]).transpose(1, 0, 2)
        near += (moved @ self._between).transpose(1, 0, 2)
        near[:, :, self._frames.slides] = 1.0
        weights: Matrix = np.minimum(near, self._of_joints, out=near)
        return weights

    def relative_displacement(self, reach: Matrix, weights: Matrix | None = None) -> Matrix:
        """
        Return how far (k, joints, joints) [m] what joints carry moves against each other at most.

        :param reach: (k, n) motion of every joint to either side [rad or m].
        :param weights: (k, joints, n) of :meth:`weights_near`; None for those that hold anywhere.
        """
        moved = (self._of_joints if weights is None else weights) * reach[:, None]
        apart = (moved.transpose(1, 0, 2) @ self._alone.transpose(0, 2, 1)).transpose(1, 0, 2)
        relative: Matrix = apart + apart.transpose(0, 2, 1)
        return relative

    def _spheres(self, loads: Mapping[int, Matrix]) -> tuple[Matrix, Vector]:
        """Return centres (joints, 3) and radii [m] of spheres around what each joint carries."""
        centres, radii = self._kinematics.cached(
            'spheres of links', lambda: _link_spheres(self._kinematics))
        radii = radii.copy()
        for joint, points in loads.items():
            away = np.linalg.norm(points - centres[joint], axis=1)
            radii[joint] = max(radii[joint], float(away.max(initial=0.0)))
        return centres, radii

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
            from_axis = float(_off_axis(below[None], unit_axis(description))[0]) + reach
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


def _above(kinematics: KinematicModel) -> Mask:
    """Return (joints, n): whether a joint moves what another carries."""
    model = kinematics.model
    above = np.zeros((int(model.njoints), kinematics.n), dtype=bool)
    for joint in range(1, len(above)):
        above[joint] = above[int(model.parents[joint])]
        above[joint, joint - 1] = True
    return above


def _between(kinematics: KinematicModel) -> Matrix:
    """Return (joints, n, n): 1 where the second moves the first and is moved by the third."""
    above = _above(kinematics)
    moved = above[1:] & ~np.eye(kinematics.n, dtype=bool)
    between: Matrix = (above[:, :, None] & moved).astype(np.float64)
    return between


def _alone(kinematics: KinematicModel) -> Matrix:
    """Return (joints, joints, n): 1 where a joint moves the first and not the second."""
    above = _above(kinematics)
    alone: Matrix = (above[:, None] & ~above[None, :]).astype(np.float64)
    return alone


def _extent(kinematics: KinematicModel, body: int, points: Matrix) -> Extent:
    """Return how far points (k, 3) that a joint carries are from it; nothing moves for joint 0."""
    if not body:
        return _NONE
    axis = unit_axis(kinematics.robot.joints[kinematics.names[body - 1]])
    return (float(_off_axis(points, axis).max(initial=0.0)),
            float(np.linalg.norm(points, axis=1).max(initial=0.0)))


def _both(first: Extent, other: Extent) -> Extent:
    return max(first[0], other[0]), max(first[1], other[1])


def _off_axis(points: Matrix, axis: Vector) -> Vector:
    """Return the distances (k,) [m] of points (k, 3) from an axis through the origin."""
    along = points @ axis
    off: Vector = np.linalg.norm(points - np.outer(along, axis), axis=1)
    return off


def _link_spheres(kinematics: KinematicModel) -> tuple[Matrix, Vector]:
    """Return centres (joints, 3) and radii [m] of spheres around the links."""
    count = int(kinematics.model.njoints)
    centres, radii = np.zeros((count, 3)), np.zeros(count)
    for joint, points in _link_points(kinematics).items():
        if len(points):
            centres[joint] = 0.5 * (points.min(axis=0) + points.max(axis=0))
            radii[joint] = np.linalg.norm(points - centres[joint], axis=1).max()
    return centres, radii


def _link_points(kinematics: KinematicModel) -> dict[int, Matrix]:
    """Return Pinocchio's joint number -> points (k, 3) [m] around the links that it carries."""
    points: dict[int, list[Matrix]] = {}
    for name, link in kinematics.robot.links.items():
        joint, offset = kinematics.link_joint(name)
        for item in link.collisions:
            points.setdefault(joint, []).append(
                corner_points(item.geometry, offset @ item.origin))
    return {joint: np.vstack(parts) for joint, parts in points.items()}


class JointFrames:
    """
    The frames of all joints, 0 for the model frame.

    :param kinematics: the robot.
    """

    def __init__(self, kinematics: KinematicModel) -> None:
        model = kinematics.model
        self._parents = [int(parent) for parent in model.parents]
        joints = [kinematics.robot.joints[name] for name in kinematics.names]
        #: (n, 3) unit vectors in the joints' frames.
        self.axes: Matrix = np.array([unit_axis(joint) for joint in joints]).reshape(-1, 3)
        #: (n,) which joints slide.
        self.slides = np.array([joint.type is JointType.PRISMATIC for joint in joints], bool)
        placements = [model.jointPlacements[joint] for joint in range(1, len(self._parents))]
        at_zero = np.array([each.rotation for each in placements]).reshape(-1, 3, 3)
        cross = np.cross(np.eye(3), self.axes[:, None])
        # Rodrigues' formula: the first, the second by the sine, the third by 1 - the cosine.
        self._terms = at_zero, at_zero @ cross, at_zero @ cross @ cross
        self._offsets = np.array([each.translation for each in placements]).reshape(-1, 3)
        self._slopes = np.einsum('nab,nb->na', at_zero, self.axes)

    def poses(self, states: Matrix) -> tuple[Matrix, Matrix]:
        """
        Return rotations (k, joints, 3, 3) and origins (k, joints, 3) [m] in the model frame.

        :param states: (k, n) [rad or m].
        """
        turned = np.where(self.slides, 0.0, states)[..., None, None]
        first, second, third = self._terms
        steps = first + np.sin(turned) * second + (1.0 - np.cos(turned)) * third
        offsets = self._offsets + np.where(self.slides, states, 0.0)[..., None] * self._slopes
        count = len(self._parents)
        rotations = np.empty((len(states), count, 3, 3))
        origins = np.zeros((len(states), count, 3))
        rotations[:, 0] = np.eye(3)
        for joint in range(1, count):
            parent = self._parents[joint]
            np.matmul(rotations[:, parent], steps[:, joint - 1], out=rotations[:, joint])
            way = rotations[:, parent] @ offsets[:, joint - 1, :, None]
            np.add(origins[:, parent], way[..., 0], out=origins[:, joint])
        return rotations, origins


def unit_axis(joint: Joint) -> Vector:
    """Return the axis (3,) of a joint in its own frame."""
    axis = np.asarray(joint.axis, dtype=np.float64)
    unit: Vector = axis / np.linalg.norm(axis)
    return unit
