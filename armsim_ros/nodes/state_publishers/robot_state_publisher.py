# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node robot_state_publisher: description and transforms of a robot."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import TransformStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Vector
from armsim_ros.errors import ConfigError, ModelError, Problem
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.qos import WantedPublisher
from armsim_ros.nodes.state_publishers.joint_transforms import JointTransforms

DESCRIPTION = 'robot_description'
_FREQUENCY = 'publish_frequency'
_MOST_HZ = 1000.0
_DEFAULTS = {DESCRIPTION: '', _FREQUENCY: 20.0, 'frame_prefix': '', 'ignore_timestamp': False}


class RobotStatePublisher:
    """
    Publishes ``robot_description``, ``/tf`` and ``/tf_static``.

    All parameters can be changed while it runs; a new description replaces the robot, and static
    transforms of earlier ones stay, as tf2's broadcaster keeps them.

    :param node: the node, without these parameters.
    :param urdf: the description where no parameter gives it.
    :param fixed: further static transforms.
    :raises ConfigError: a parameter is wrong, or the description is missing or not a URDF.
    """

    def __init__(self, node: Node, urdf: str = '', fixed: Sequence[TransformStamped] = ()
                 ) -> None:
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
    content = parse_urdf(
        urdf, DESCRIPTION, read_mesh=lambda uri, scale: None, with_hardware=False)
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
