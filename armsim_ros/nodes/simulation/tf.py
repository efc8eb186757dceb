# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``/tf`` and ``/tf_static``."""

from __future__ import annotations

from geometry_msgs.msg import TransformStamped
import numpy as np
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.model.transforms import Matrix, quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher

#: Positions that differ by less are shown as the same [rad or m].
SAME_POSITION = 1e-9


class Tf:
    """
    Publishes the transform of every link relative to its parent.

    :param node: the node that publishes.
    :param robot: the robot; its fixed joints go to ``/tf_static`` once.
    :param placement: (4, 4) pose of the root link in the model frame, where the SRDF's virtual
        joint gives that frame a name of its own.
    """

    def __init__(self, node: Node, robot: RobotModel, placement: Matrix) -> None:
        joints = [robot.joints[name] for name in robot.movable_joints]
        self._sliding = np.array([joint.type is JointType.PRISMATIC for joint in joints], bool)
        self._axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
        self._origins = np.array([joint.origin[:3, 3] for joint in joints]).reshape(-1, 3)
        self._rotations = np.array(
            [quat_xyzw_from_matrix(joint.origin) for joint in joints]
        ).reshape(-1, 4)
        self._slides = np.array([joint.origin[:3, :3] @ joint.axis for joint in joints])
        self._slides = self._slides.reshape(-1, 3)
        stamped = [transform(joint.parent, joint.child) for joint in joints]
        self._message = SerializedMessage(
            TFMessage(transforms=stamped),
            [one.header.stamp for one in stamped],
            [(getattr(one.transform, part), name) for one in stamped
             for part, names in (('translation', 'xyz'), ('rotation', 'xyzw'))
             for name in names],
        )
        self._shown = np.full(len(joints), np.nan)
        self._publisher = WantedPublisher(node, TFMessage, '/tf', qos.TF)
        self._static_publisher = node.create_publisher(TFMessage, '/tf_static', qos.LATCHED)
        self._static_publisher.publish(TFMessage(transforms=_static(robot, placement)))

    def publish(self, time_ns: int, positions: Matrix) -> None:
        """
        Publish the transforms of the movable joints, if anybody subscribes.

        :param time_ns: [ns] of the simulation.
        :param positions: (n,) [rad or m] in the order of ``robot.movable_joints``.
        """
        if not self._publisher.wanted(time_ns):
            return
        if not np.abs(positions - self._shown).max(initial=0.0) <= SAME_POSITION:
            self._move(positions)
        self._publisher.publish(self._message.at(time_ns), time_ns)

    def _move(self, positions: Matrix) -> None:
        """Write the links' transforms into the message."""
        self._shown = np.array(positions)
        half = np.where(self._sliding, 0.0, 0.5 * positions)
        quaternions = _product(
            self._rotations, np.column_stack([self._axes * np.sin(half)[:, None], np.cos(half)])
        )
        slides = np.where(self._sliding, positions, 0.0)
        translations = self._origins + self._slides * slides[:, None]
        self._message.set_numbers(np.column_stack([translations, quaternions]).ravel())


def transform(parent: str, child: str, pose: Matrix | None = None) -> TransformStamped:
    """Return a transform message between two frames; without a pose (4, 4) they are one."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    if pose is not None:
        _fill(message, pose[:3, 3].tolist(), quat_xyzw_from_matrix(pose).tolist())
    return message


def _static(robot: RobotModel, placement: Matrix) -> list[TransformStamped]:
    poses = [
        (joint.parent, joint.child, joint.origin)
        for joint in robot.joints.values()
        if joint.type is JointType.FIXED
    ]
    if robot.model_frame != robot.root_link:
        poses.append((robot.model_frame, robot.root_link, placement))
    return [transform(*one) for one in poses]


def _fill(message: TransformStamped, xyz: list[float], xyzw: list[float]) -> None:
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = xyz
    rotation.x, rotation.y, rotation.z, rotation.w = xyzw


def _product(left: Matrix, right: Matrix) -> Matrix:
    """Return the products (n, 4) of quaternions xyzw (n, 4), row by row."""
    vector = (
        left[:, 3:] * right[:, :3]
        + right[:, 3:] * left[:, :3]
        + np.cross(left[:, :3], right[:, :3])
    )
    scalar = left[:, 3] * right[:, 3] - np.einsum('ij,ij->i', left[:, :3], right[:, :3])
    return np.column_stack([vector, scalar])
