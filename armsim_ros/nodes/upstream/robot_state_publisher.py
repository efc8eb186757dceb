# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program robot_state_publisher."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys

from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.state_publishers.robot_state_publisher import (
    DESCRIPTION,
    RobotStatePublisher,
)
from armsim_ros.nodes.upstream.node_parameters import read_node_arguments
from armsim_ros.nodes.upstream.spinning import spin

NAME = 'robot_state_publisher'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish until SIGINT or SIGTERM.

    :param argv: the words that the upstream program would get; the first may be a URDF file.
    :returns: 0 after a signal, 2 without a robot description.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    try:
        arguments = read_node_arguments(ros_args, NAME)
        given = bool(arguments.values.get(DESCRIPTION))
        urdf = '' if given or not words else _read(Path(words[0]))
        return spin(NAME, ros_args, lambda node: _publish(node, urdf))
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


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding='utf-8')
    except OSError as error:
        raise UsageError(f"the URDF file '{file}' cannot be read: {error.strerror}") from None
