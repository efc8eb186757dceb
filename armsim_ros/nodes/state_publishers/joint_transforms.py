# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From joint states to the messages of ``/tf``, as robot_state_publisher makes them."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import TransformStamped
import numpy as np
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.log import Log
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import time_from_ns

#: Positions that differ by less are shown as the same [rad or m].
SAME_POSITION = 1e-9
#: Joints of other types never move; a floating joint appears nowhere.
_STATIC = (JointType.FIXED, JointType.PLANAR)


class JointTransforms:
    """
    The transforms of a robot, and when they are due.

    :param robot: the robot.
    :param log: receives dropped messages and jumps of the clock.
    """

    def __init__(self, robot: RobotModel, log: Log) -> None:
        self.robot = robot
        self._log = log
        self._mimics = sorted(
            (name, joint.mimic) for name, joint in robot.joints.items() if joint.mimic is not None)
        #: Joint -> stamp of its last message that was published [ns].
        self._published: dict[str, int] = {}
        self._last_call_ns = 0
        self._moving: _MovingTransforms | None = None

    def continue_from(self, other: JointTransforms) -> None:
        """Keep the times of the transforms that were published of another description."""
        self._published, self._last_call_ns = other._published, other._last_call_ns

    def message(
        self, names: Sequence[str], positions: Sequence[float] | Vector, stamp_ns: int,
        now_ns: int, *, frequency: float, prefix: str = '', ignore_timestamp: bool = False,
    ) -> bytes | None:
        """
        Return the serialized message for a joint state, None where none is due.

        :param positions: [rad or m].
        :param stamp_ns: of the joint state [ns].
        :param now_ns: the node's time [ns].
        :param frequency: messages a second at most [Hz]; 0 is no bound.
        :param prefix: precedes every frame.
        :param ignore_timestamp: whether every message is due.
        """
        if len(names) != len(positions):
            if len(positions):
                self._log.error('ignored a JointState with '
                                f'{len(names)} names and {len(positions)} positions')
            else:
                self._log.warning('ignored a JointState without positions, of joint '
                                  f"'{names[0]}' and others")
            return None
        if self._last_call_ns > now_ns:
            self._log.warning('time moved backwards: joint transforms are published again')
            self._published.clear()
        self._last_call_ns = now_ns
        oldest = min((self._published.get(name, 0) for name in names), default=now_ns)
        period_ns = int(1000.0 / frequency) * 1_000_000 if frequency else 0
        if not ignore_timestamp and stamp_ns < min(oldest, now_ns) + period_ns:
            return None
        self._published.update(dict.fromkeys(names, stamp_ns))
        return self._transforms(names, positions, prefix).at(max(stamp_ns, 0))

    def static(self, prefix: str, now_ns: int) -> list[TransformStamped]:
        """
        Return the transforms of the joints that never move.

        :param now_ns: their stamp [ns].
        """
        joints = self.robot.joints
        return [transform(prefix + joint.parent, prefix + joint.child, joint.origin, now_ns)
                for _, joint in sorted(joints.items()) if joint.type in _STATIC]

    def _transforms(
        self, names: Sequence[str], positions: Sequence[float] | Vector, prefix: str
    ) -> _MovingTransforms:
        values: dict[str, float] = {}
        for name, value in zip(names, positions, strict=True):
            values.setdefault(name, value)
        for name, mimic in self._mimics:
            if mimic.joint in values:
                values.setdefault(name, values[mimic.joint] * mimic.multiplier + mimic.offset)
        joints = self.robot.joints
        moved = tuple(name for name in sorted(values) if name in joints and joints[name].movable)
        if self._moving is None or (self._moving.names, self._moving.prefix) != (moved, prefix):
            self._moving = _MovingTransforms([joints[name] for name in moved], prefix)
        self._moving.move(np.array([values[name] for name in moved]))
        return self._moving


class _MovingTransforms:
    """
    A message with the transforms of some joints.

    :param joints: movable ones; there may be none.
    :param prefix: precedes every frame.
    """

    def __init__(self, joints: Sequence[Joint], prefix: str) -> None:
        self.names = tuple(joint.name for joint in joints)
        self.prefix = prefix
        self._sliding = np.array([joint.type is JointType.PRISMATIC for joint in joints], bool)
        self._axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
        self._origins = np.array([joint.origin[:3, 3] for joint in joints]).reshape(-1, 3)
        self._rotations = np.array(
            [quat_xyzw_from_matrix(joint.origin) for joint in joints]
        ).reshape(-1, 4)
        self._slides = np.array([joint.origin[:3, :3] @ joint.axis for joint in joints])
        self._slides = self._slides.reshape(-1, 3)
        stamped = [transform(prefix + joint.parent, prefix + joint.child) for joint in joints]
        self._message = SerializedMessage(
            TFMessage(transforms=stamped),
            [message.header.stamp for message in stamped],
            [(getattr(message.transform, part), name) for message in stamped
             for part, names in (('translation', 'xyz'), ('rotation', 'xyzw'))
             for name in names],
        )
        self._shown = np.full(len(joints), np.nan)

    def at(self, time_ns: int) -> bytes:
        """Return what is to be sent at a time [ns]."""
        return self._message.at(time_ns)

    def move(self, positions: Matrix) -> None:
        """Write the links' transforms at positions (n,) [rad or m] into the message."""
        if np.abs(positions - self._shown).max(initial=0.0) <= SAME_POSITION:
            return
        self._shown = positions
        half = np.where(self._sliding, 0.0, 0.5 * positions)
        quaternions = _product(
            self._rotations, np.column_stack([self._axes * np.sin(half)[:, None], np.cos(half)])
        )
        slides = np.where(self._sliding, positions, 0.0)
        translations = self._origins + self._slides * slides[:, None]
        self._message.set_numbers(np.column_stack([translations, quaternions]).ravel())


def transform(
    parent: str, child: str, pose: Matrix | None = None, time_ns: int = 0
) -> TransformStamped:
    """
    Return a transform message between two frames; without a pose (4, 4) they coincide.

    :param time_ns: its stamp [ns].
    """
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp = time_from_ns(time_ns)
    if pose is not None:
        translation, rotation = message.transform.translation, message.transform.rotation
        translation.x, translation.y, translation.z = pose[:3, 3].tolist()
        xyzw = quat_xyzw_from_matrix(pose).tolist()
        rotation.x, rotation.y, rotation.z, rotation.w = xyzw
    return message


def _product(left: Matrix, right: Matrix) -> Matrix:
    """Return the products (n, 4) of quaternions xyzw (n, 4), row by row."""
    vector = (
        left[:, 3:] * right[:, :3]
        + right[:, 3:] * left[:, :3]
        + np.cross(left[:, :3], right[:, :3])
    )
    scalar = left[:, 3] * right[:, 3] - np.einsum('ij,ij->i', left[:, :3], right[:, :3])
    return np.column_stack([vector, scalar])
