# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Poses that satisfy a goal: the wanted one, or random ones that it allows."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.kinematics.inverse import IKTarget
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.transforms import matrix_from_axis_angle, pose_from_parts
from armsim_ros.planning.constraint_terms import OrientationTerm, PositionTerm
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.regions import random_point, region_center, region_size

Vector = NDArray[np.float64]


class PoseSampler:
    """
    Turns position and orientation constraints into targets of inverse kinematics.

    :param model: the robot's kinematics.
    :param group: the group that is planned for.
    :param bounds: lower and upper values (m,) that random states are drawn from.
    :param rng: source of chance.
    """

    def __init__(
        self, model: KinematicModel, group: str, bounds: tuple[Vector, Vector],
        rng: np.random.Generator,
    ) -> None:
        """Keep the parts."""
        self._model = model
        self._group = group
        self._bounds = bounds
        self._rng = rng

    def targets(self, goal: ConstraintSet, seed: Vector, middle: bool) -> list[IKTarget]:
        """Return a pose for every constrained frame: the wanted one, or a random allowed one."""
        poses = goal.poses(seed)
        free = seed
        if not middle:
            low, high = self._bounds
            free = self._model.insert(seed, self._group, self._rng.uniform(low, high))
        targets: list[IKTarget] = []
        used: set[int] = set()
        for position in goal.positions:
            frame = poses[position.frame.link] @ position.frame.offset
            partner = next(
                (k for k, term in enumerate(goal.orientations)
                 if term.target.link == position.target.link and k not in used), None,
            )
            point = (frame @ np.append(self._point(position, middle), 1.0))[:3]
            if partner is None:
                targets.append(IKTarget(
                    position.target.link, pose_from_parts(point, np.eye(3)),
                    position.target.offset, position_only=True,
                ))
                continue
            used.add(partner)
            orientation = goal.orientations[partner]
            rotation = self._rotation(orientation, poses, middle)
            # The wanted rotation is that of the orientation's frame on the link.
            link_rotation = rotation @ orientation.target.offset[:3, :3].T
            pose = pose_from_parts(point, link_rotation @ position.target.offset[:3, :3])
            targets.append(IKTarget(position.target.link, pose, position.target.offset))
        for k, orientation in enumerate(goal.orientations):
            if k in used:
                continue
            link = orientation.target.link
            rotation = self._rotation(orientation, poses, middle)
            here = self._model.link_pose(free, link) @ orientation.target.offset
            targets.append(IKTarget(
                link, pose_from_parts(here[:3, 3], rotation), orientation.target.offset
            ))
        return targets

    def _point(self, term: PositionTerm, middle: bool) -> Vector:
        if middle:
            return region_center(term.regions[0])
        return random_point(term.regions[int(self._rng.integers(len(term.regions)))], self._rng)

    def _rotation(
        self, term: OrientationTerm, poses: dict[str, Vector], middle: bool
    ) -> Vector:
        frame = (poses[term.frame.link] @ term.frame.offset)[:3, :3]
        wanted = term.wanted
        if not middle:
            reach = np.minimum(term.tolerances, math.pi)
            angles = self._rng.uniform(-reach, reach)
            wanted = _small_rotation(angles, term.rotation_vector) @ wanted
        result: Vector = frame @ wanted
        return result


def has_room(goal: ConstraintSet) -> bool:
    """Return whether the goal leaves more than a point to choose from."""
    linked = {term.target.link for term in goal.orientations}
    return (
        any(len(term.regions) > 1 or region_size(term.regions[0]) > 2e-3
            for term in goal.positions)
        or any(float(np.max(term.tolerances)) > 0.02 for term in goal.orientations)
        or any(term.target.link not in linked for term in goal.positions)
        or (bool(goal.orientations) and not goal.positions)
    )


def _small_rotation(angles: Vector, rotation_vector: bool) -> Vector:
    if rotation_vector:
        angle = float(np.linalg.norm(angles))
        return np.eye(3) if angle < 1e-12 else matrix_from_axis_angle(angles / angle, angle)
    x, y, z = np.eye(3)
    return (
        matrix_from_axis_angle(x, float(angles[0]))
        @ matrix_from_axis_angle(y, float(angles[1]))
        @ matrix_from_axis_angle(z, float(angles[2]))
    )
