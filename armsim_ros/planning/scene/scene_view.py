# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a planning scene holds, and where its frames are."""

from __future__ import annotations

from collections.abc import Mapping

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.content import (
    Color,
    frame_pose,
    link_of_frame,
    robot_frame,
    SceneContent,
    transform,
)
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject
from armsim_ros.planning.scene.octomap import Octomap


class SceneView:
    """
    A scene that can be read.

    :param kinematics: the robot.
    :param content: all that the scene holds.
    """

    def __init__(self, kinematics: KinematicModel, content: SceneContent) -> None:
        self.kinematic_model, self._content = kinematics, content

    @property
    def content(self) -> SceneContent:
        """All that the scene holds now, immutable."""
        return self._content

    @property
    def robot(self) -> RobotModel:
        """The robot."""
        return self.kinematic_model.robot

    @property
    def model_frame(self) -> str:
        """The frame of all poses without a frame."""
        return self.robot.model_frame

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._content.name

    @property
    def q(self) -> Vector:
        """Robot state (n,), read-only."""
        return self._content.q

    @property
    def objects(self) -> Mapping[str, CollisionObject]:
        """Objects in the world, by id."""
        return self._content.objects

    @property
    def attached(self) -> Mapping[str, AttachedObject]:
        """Objects on the robot, by id."""
        return self._content.attached

    @property
    def acm(self) -> AllowedCollisionMatrix:
        """Which pairs may touch."""
        return self._content.acm

    @property
    def link_padding(self) -> Mapping[str, float]:
        """Padding of links against the world [m]."""
        return self._content.link_padding

    @property
    def link_scale(self) -> Mapping[str, float]:
        """Factors of the links' size against the world."""
        return self._content.link_scale

    @property
    def colors(self) -> Mapping[str, Color]:
        """Colours of objects, rgba."""
        return self._content.colors

    @property
    def octomap(self) -> Octomap | None:
        """What cameras see; None where there is no map."""
        return self._content.octomap

    # ---------------------------------------------------------------- frames

    def frame_pose(self, frame: str, q: Vector | None = None) -> Matrix:
        """
        Return the pose (4, 4) of a link, object, ``object/subframe`` or fixed frame.

        :param q: (n,) robot state; None for the scene's.
        :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
        """
        return frame_pose(self.kinematic_model, self._content, frame, q)

    def link_of_frame(self, frame: str) -> tuple[str, Matrix]:
        """
        Return the link that carries a frame and the frame's pose (4, 4) on that link.

        Frames of the world belong to the root link, further frames too, where they are now.

        :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
        """
        return link_of_frame(self.kinematic_model, self._content, frame)

    def has_frame(self, frame: str) -> bool:
        """Return whether a frame is known."""
        try:
            self.link_of_frame(frame)
        except PlanningError:
            return False
        return True

    def transform(self, frame: str) -> Matrix:
        """
        Return the pose (4, 4) of a frame as TF has it now: links and published frames.

        :raises PlanningError: FRAME_TRANSFORM_FAILURE for any other frame.
        """
        return transform(self.kinematic_model, self._content, frame)

    def robot_frame(self, frame: str) -> tuple[str, Matrix] | None:
        """Return link and pose on it of a link, an attached object or its subframe, else None."""
        return robot_frame(self.kinematic_model, self._content, frame)
