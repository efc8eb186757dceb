# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""robot_state_publisher without a simulation: description and transforms of joint states."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.launch.mapping import DESCRIPTION_ONLY
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.latched_text import publish_text
from armsim_ros.nodes.originals.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.originals.spinning import spin
from armsim_ros.nodes.simulation.tf import Tf


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish until SIGINT or SIGTERM.

    :param argv: the words that the original would get; the first may be a URDF file.
    :returns: 0 after a signal, 2 without a robot description.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    try:
        arguments = read_node_arguments(ros_args, 'robot_state_publisher')
        robot = robot_of(_description(words, arguments))
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return USAGE_STATUS
    if arguments.values.get(DESCRIPTION_ONLY):
        return spin(arguments.name, ros_args,
                    lambda node: publish_text(node, 'robot_description', robot.urdf))
    return spin(arguments.name, ros_args, lambda node: StatePublisher(node, robot))


def robot_of(urdf: str) -> RobotModel:
    """
    Return the kinematic tree of a robot, without geometry.

    :raises ModelError: where the text is no URDF.
    """
    content = parse_urdf(urdf, 'robot_description', read_mesh=lambda uri, scale: None)
    return RobotModel(content.name, content.links, content.joints, content.root_link, urdf=urdf)


class StatePublisher:
    """
    Publishes ``robot_description``, ``/tf`` and ``/tf_static``.

    :param node: the node that publishes.
    :param robot: the robot.
    """

    def __init__(self, node: Node, robot: RobotModel) -> None:
        self._robot = robot
        self._positions: dict[str, float] = {}
        self._tf = Tf(node, robot, np.eye(4))
        self._kept = (
            publish_text(node, 'robot_description', robot.urdf),
            node.create_subscription(JointState, 'joint_states', self._on_joint_states, 10),
        )

    def _on_joint_states(self, message: JointState) -> None:
        active = self._robot.active_joints
        self._positions.update((name, position) for name, position in zip(
            message.name, message.position, strict=False) if name in active)
        full = self._robot.complete(self._positions)
        self._tf.publish(ns_from_time(message.header.stamp), np.array(list(full.values())))


def _description(words: Sequence[str], arguments: NodeArguments) -> str:
    given = arguments.values.get('robot_description')
    if given:
        return str(given)
    if words and Path(words[0]).is_file():
        return Path(words[0]).read_text(encoding='utf-8')
    raise UsageError("robot_state_publisher needs the parameter 'robot_description'")
