# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs joint_state_publisher (also _gui, without sliders) and robot_state_publisher."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys
from typing import Any

from rclpy.exceptions import ParameterAlreadyDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.cli.node_arguments import read_node_arguments
from armsim_ros.errors import ArmsimError, ModelError, USAGE_STATUS
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.upstream.joint_states import (
    DependentJointError,
    FIELDS,
    JointStateOptions,
    JointStates,
)
from armsim_ros.nodes.upstream.robot_state_publisher import DESCRIPTION, RobotStatePublisher
from armsim_ros.nodes.upstream.single_node import spin

#: Parameter -> its default; all are read once, at the start.
_DEFAULTS = {
    'publish_default_positions': True, 'publish_default_velocities': False,
    'publish_default_efforts': False, 'rate': 10, 'use_mimic_tags': True,
    'use_smallest_joint_limits': True, 'delta': 0.0,
}
_OF_DEPENDENT = ('parent', 'factor', 'offset')


def joint_state_publisher(argv: Sequence[str] | None = None) -> int:
    """
    Publish until SIGINT or SIGTERM.

    :param argv: the words that the upstream program would get; the first may be a URDF file.
    :returns: 0 after a signal, 1 where dependent joints follow each other in a circle, 2 where
        a parameter or the file is wrong.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words):
        print('usage: joint_state_publisher [-h] [description_file] [--ros-args ...]')
        return 0
    try:
        return spin(
            'joint_state_publisher', ros_args, lambda node: JointStatePublisher(node, words),
            automatically_declare_parameters_from_overrides=True)
    except DependentJointError as error:
        print(error, file=sys.stderr, flush=True)
        return 1
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return USAGE_STATUS


class JointStatePublisher:
    """
    Publishes ``joint_states`` of the description on ``robot_description``, or of a file.

    :param node: the node that publishes; it has declared the parameters that it was given.
    :param words: the first is a URDF file, if any.
    :raises ArmsimError: a parameter or the file is wrong.
    """

    def __init__(self, node: Node, words: Sequence[str] = ()) -> None:
        self._node = node
        given = {name: _declared(node, name, default) for name, default in _DEFAULTS.items()}
        _check_dependent(node)
        zeros: dict[str, Any] = dict(node.get_parameters_by_prefix('zeros'))
        self._options = JointStateOptions(
            use_mimic_tags=bool(given['use_mimic_tags']),
            use_smallest_joint_limits=bool(given['use_smallest_joint_limits']),
            zeros={name: _number(f'zeros.{name}', parameter.value)
                   for name, parameter in zeros.items()},
            defaults=[kind for kind, key in zip(
                FIELDS, ('positions', 'velocities', 'efforts'), strict=True)
                if given[f'publish_default_{key}']])
        rate, self._delta = (_number(name, given[name]) for name in ('rate', 'delta'))
        if not rate > 0.0:
            raise UsageError(f"the parameter 'rate' is {rate:g}; allowed: above 0")
        self._joints: JointStates | None = None
        if words:
            self._joints = JointStates(_read('file', words[0]), self._options)
        else:
            node.get_logger().info('waiting for the topic robot_description')
        node.create_subscription(String, 'robot_description', self._describe, qos.DESCRIPTION)
        for topic in _declared(node, 'source_list', []) or ():
            node.create_subscription(JointState, topic, self._take, 10)
        self._publisher = node.create_publisher(JointState, 'joint_states', 10)
        node.create_timer(1.0 / rate, self._publish)

    def _describe(self, message: String) -> None:
        try:
            self._joints = JointStates(message.data, self._options)
        except ModelError as error:
            self._node.get_logger().warning(str(error))

    def _take(self, message: JointState) -> None:
        if self._joints is not None:
            self._joints.take(message.name, **{kind: getattr(message, kind) for kind in FIELDS})

    def _publish(self) -> None:
        if self._joints is None or not self._joints.names:
            return
        if self._delta > 0.0:
            self._joints.step(self._delta)
        state: dict[str, Any] = self._joints.state()
        message = JointState(name=self._joints.names, **state)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


def _declared(node: Node, name: str, default: Any) -> Any:
    try:
        if default == []:
            node.declare_parameter(name, Parameter.Type.STRING_ARRAY)
            node.set_parameters([Parameter(name, Parameter.Type.STRING_ARRAY, [])])
        else:
            node.declare_parameter(name, default)
    except ParameterAlreadyDeclaredException:
        pass
    return node.get_parameter(name).value


def _number(name: str, value: Any) -> float:
    if isinstance(value, (int, float)):
        return float(value)
    raise UsageError(f"the parameter '{name}' is {value!r}; allowed: a number")


def _check_dependent(node: Node) -> None:
    """
    Check ``dependent_joints.JOINT.KEY``, which has no effect beyond that, as upstream.

    :raises UsageError: a key is unknown, or a joint has no parent.
    """
    joints: dict[str, set[str]] = {}
    for name in node.get_parameters_by_prefix('dependent_joints'):
        joint, _, key = name.partition('.')
        if key not in _OF_DEPENDENT:
            raise UsageError(f"unknown parameter 'dependent_joints.{name}'; allowed: "
                             f"dependent_joints.JOINT.{'|'.join(_OF_DEPENDENT)}")
        joints.setdefault(joint, set()).add(key)
    for joint, keys in joints.items():
        if 'parent' not in keys:
            raise UsageError(f"the parameter 'dependent_joints.{joint}.parent' is missing")
    if joints:
        node.get_logger().warning("dependent_joints has no effect: the URDF's <mimic> tags count")


def _read(kind: str, name: str) -> str:
    try:
        return Path(name).read_text(encoding='utf-8')
    except OSError as error:
        raise UsageError(f"the {kind} '{Path(name)}' cannot be read: {error.strerror}") from None


def robot_state_publisher(argv: Sequence[str] | None = None) -> int:
    """
    Publish until SIGINT or SIGTERM.

    :param argv: the words that the upstream program would get; the first may be a URDF file.
    :returns: 0 after a signal, 2 without a robot description.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    try:
        arguments = read_node_arguments(ros_args, 'robot_state_publisher')
        given = bool(arguments.values.get(DESCRIPTION))
        urdf = '' if given or not words else _read('URDF file', words[0])
        return spin('robot_state_publisher', ros_args, lambda node: _publish(node, urdf))
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return USAGE_STATUS


def _publish(node: Node, urdf: str) -> RobotStatePublisher:
    if urdf:
        node.get_logger().warning(
            f"no parameter '{DESCRIPTION}': the first argument is taken as a URDF file")
    publisher = RobotStatePublisher(node, urdf)

    def take(message: JointState) -> None:
        publisher.take(message.name, message.position, ns_from_time(message.header.stamp))

    node.create_subscription(
        JointState, 'joint_states', take,
        qos_profile_sensor_data,
        qos_overriding_options=QoSOverridingOptions.with_default_policies())
    return publisher
