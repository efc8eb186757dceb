# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node robot_state_publisher: description and transforms of a robot."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import TransformStamped
import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import ConfigError, ModelError, Problem
from armsim_ros.log import Log
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import time_from_ns
from armsim_ros.nodes.qos import WantedPublisher

#: Positions that differ by less are shown as the same [rad or m].
SAME_POSITION = 1e-9
#: Joints of other types never move; a floating joint appears nowhere.
_STATIC = (JointType.FIXED, JointType.PLANAR)


class JointTransforms:
    """
    The transforms of a robot, and when they are due.

    :param log: receives dropped messages and jumps of the clock.
    """

    def __init__(self, robot: RobotModel, log: Log) -> None:
        self.robot, self._log = robot, log
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
            [quat_xyzw_from_matrix(joint.origin) for joint in joints]).reshape(-1, 4)
        self._slides = np.array([joint.origin[:3, :3] @ joint.axis for joint in joints])
        self._slides = self._slides.reshape(-1, 3)
        stamped = [transform(prefix + joint.parent, prefix + joint.child) for joint in joints]
        self._message = SerializedMessage(
            TFMessage(transforms=stamped),
            [message.header.stamp for message in stamped],
            [(getattr(message.transform, part), name) for message in stamped
             for part, names in (('translation', 'xyz'), ('rotation', 'xyzw'))
             for name in names])
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
            self._rotations, np.column_stack([self._axes * np.sin(half)[:, None], np.cos(half)]))
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
        + np.cross(left[:, :3], right[:, :3]))
    scalar = left[:, 3] * right[:, 3] - np.einsum('ij,ij->i', left[:, :3], right[:, :3])
    return np.column_stack([vector, scalar])


DESCRIPTION = 'robot_description'
_FREQUENCY = 'publish_frequency'
_MOST_HZ = 1000.0
_DEFAULTS = {DESCRIPTION: '', _FREQUENCY: 20.0, 'frame_prefix': '', 'ignore_timestamp': False}


class RobotStatePublisher:
    """
    Publishes ``robot_description``, ``/tf`` and ``/tf_static``.

    All parameters can be changed while it runs; a new description replaces the robot, and static
    transforms of earlier ones stay, as tf2's broadcaster keeps them.

    :param urdf: the description where no parameter gives it.
    :param fixed: further static transforms.
    :raises ConfigError: a parameter is wrong, or the description is missing or not a URDF.
    """

    def __init__(self, node: Node, urdf: str = '', fixed: Sequence[TransformStamped] = ()) -> None:
        self._node = node
        try:
            for name, default in _DEFAULTS.items():
                node.declare_parameter(name, default)
        except InvalidParameterTypeException as error:
            raise ConfigError(Problem(str(error))) from None
        urdf = str(node.get_parameter(DESCRIPTION).value) or urdf
        if not urdf:
            raise ConfigError(Problem(f"the parameter '{DESCRIPTION}' is empty",
                                      remedy='give it the text of the URDF'))
        wrong = _objection(node.get_parameter(_FREQUENCY))
        if wrong:
            raise ConfigError(Problem(wrong))
        self._static = {transform.child_frame_id: transform for transform in fixed}
        self._tf = WantedPublisher(node, TFMessage, '/tf', qos.TF)
        self._tf_static = node.create_publisher(TFMessage, '/tf_static', qos.LATCHED)
        self._description = node.create_publisher(String, DESCRIPTION, qos.LATCHED)
        self._transforms = JointTransforms(robot_of(urdf), node.get_logger())
        node.set_parameters([Parameter(DESCRIPTION, value=urdf)])
        self._publish_description(urdf)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)

    def take(self, names: Sequence[str], positions: Sequence[float] | Vector, stamp_ns: int, *,
             now_ns: int | None = None) -> None:
        """
        Publish the transforms of a joint state, if they are due.

        :param positions: [rad or m].
        :param stamp_ns: its stamp [ns].
        :param now_ns: the node's time [ns].
        """
        node = self._node
        if now_ns is None:
            now_ns = node.get_clock().now().nanoseconds
        message = self._transforms.message(
            names, positions, stamp_ns, now_ns,
            frequency=node.get_parameter(_FREQUENCY).value, prefix=self._prefix,
            ignore_timestamp=node.get_parameter('ignore_timestamp').value)
        if message is not None and self._tf.wanted(stamp_ns):
            self._tf.publish(message, stamp_ns)

    @property
    def _prefix(self) -> str:
        return str(self._node.get_parameter('frame_prefix').value)

    def _publish_description(self, urdf: str) -> None:
        self._description.publish(String(data=urdf))
        now_ns = self._node.get_clock().now().nanoseconds
        found = self._transforms.static(self._prefix, now_ns)
        self._static.update((transform.child_frame_id, transform) for transform in found)
        self._tf_static.publish(TFMessage(transforms=list(self._static.values())))
        self._node.get_logger().info('Robot initialized')

    def _check(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        wrong = next(filter(None, map(_objection, parameters)), '')
        return SetParametersResult(successful=not wrong, reason=wrong)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == DESCRIPTION:
                previous = self._transforms
                self._transforms = JointTransforms(
                    robot_of(parameter.value), self._node.get_logger())
                self._transforms.continue_from(previous)
                self._publish_description(parameter.value)


def robot_of(urdf: str) -> RobotModel:
    """
    Return the kinematic tree of a robot, without geometry and hardware.

    :raises ModelError: where the text is not a URDF.
    """
    content = parse_urdf(urdf, DESCRIPTION, read_mesh=lambda uri, scale: None, with_hardware=False)
    return RobotModel(content.name, content.links, content.joints, content.root_link, urdf=urdf)


def _objection(parameter: Parameter) -> str:
    """Return why a value is refused, '' where it is not."""
    if parameter.name == _FREQUENCY and not 0.0 <= parameter.value <= _MOST_HZ:
        return f'{_FREQUENCY} is {parameter.value:g}; allowed: 0.0 to {_MOST_HZ:g}'
    if parameter.name == DESCRIPTION:
        if not parameter.value:
            return 'an empty URDF is not allowed'
        try:
            robot_of(parameter.value)
        except ModelError as error:
            return str(error)
    return ''
