# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where links are for positions of a controller's joints, and how they move with them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.model.tree import joint_pose


class LinkMotion:
    """
    Some links of a robot.

    :param model: the robot.
    :param joints: (n,) those that move; all others are at 0.
    :param base: link before the joints, in whose frame everything is given.
    :param links: those that are asked for.
    :raises ControllerError: a link or joint that the robot lacks, or a base that moves.
    """

    def __init__(
        self, model: RobotModel, joints: Sequence[str], base: str, links: Iterable[str]
    ) -> None:
        for kind, names, known in (('link', (base, *links), tuple(model.links)),
                                   ('joint', joints, tuple(model.joints))):
            for name in names:
                if name not in known:
                    hint = nearest(name, known) or f'known: {", ".join(known)}'
                    raise ControllerError(
                        f"'{name}' is not a {kind} of robot '{model.name}'; {hint}")
        self._base = base
        self._columns = {name: column for column, name in enumerate(joints)}
        self._paths = {link: _path(model, link) for link in (base, *links)}
        for joint in self._paths[base]:
            if joint.name in self._columns:
                raise ControllerError(f"'{base}' moves with '{joint.name}' and cannot be the "
                                      f"base; choose '{joint.parent}' or what is before it")

    def poses(self, positions: Vector) -> dict[str, Matrix]:
        """Return the pose (4, 4) of each link for positions (n,) [rad or m]."""
        reached: dict[str, Matrix] = {}
        for link, path in self._paths.items():
            pose: Matrix = np.eye(4)
            for joint in path:
                if joint.child not in reached:
                    reached[joint.child] = pose @ joint_pose(joint, self._at(joint, positions))
                pose = reached[joint.child]
            reached[link] = pose
        root = inverse_pose(reached[self._base])
        return {link: root @ reached[link] for link in self._paths}

    def jacobian(self, link: str, positions: Vector) -> Matrix:
        """
        Return how a link's origin moves with the joints (6, n): linear above angular.

        :param positions: (n,) [rad or m].
        """
        found = np.zeros((6, len(self._columns)))
        base: Matrix = np.eye(4)
        for joint in self._paths[self._base]:
            base = base @ joint_pose(joint, self._at(joint, positions))
        frames, pose = [], inverse_pose(base)
        for joint in self._paths[link]:
            pose = pose @ joint_pose(joint, self._at(joint, positions))
            frames.append((joint, pose))
        for joint, frame in frames:
            column = self._columns.get(joint.name)
            if column is None:
                continue
            # A joint turns about its axis, or slides along it, in both its frames alike.
            axis = frame[:3, :3] @ joint.axis
            if joint.type is JointType.PRISMATIC:
                found[:3, column] = axis
            else:
                found[:3, column] = np.cross(axis, pose[:3, 3] - frame[:3, 3])
                found[3:, column] = axis
        return found

    def _at(self, joint: Joint, positions: Vector) -> float:
        column = self._columns.get(joint.name)
        return 0.0 if column is None else float(positions[column])


def _path(model: RobotModel, link: str) -> list[Joint]:
    """Return the joints from the root link to a link."""
    parents: Mapping[str, str] = model.parent_joint
    path: list[Joint] = []
    while (name := parents.get(link)) is not None:
        path.append(model.joints[name])
        link = model.joints[name].parent
    return path[::-1]
