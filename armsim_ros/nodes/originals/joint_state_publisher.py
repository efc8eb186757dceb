# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""joint_state_publisher without a simulation: every joint where it stands, or at its middle."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.originals.description_topic import wait_for_descriptions
from armsim_ros.nodes.originals.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.originals.robot_state_publisher import robot_of
from armsim_ros.nodes.originals.spinning import spin

_DESCRIPTION = 'robot_description'
_RATE = 10.0


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish until SIGINT or SIGTERM.

    :param argv: the words that the original would get; the first may be a URDF file.
    :returns: 0 after a signal, 2 where the description is none.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    try:
        arguments = read_node_arguments(ros_args, 'joint_state_publisher')
        robot = robot_of(_description(words, arguments))
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return USAGE_STATUS
    except KeyboardInterrupt:
        return 0
    return spin(arguments.name, ros_args,
                lambda node: JointStatePublisher(node, robot, arguments.values))


class JointStatePublisher:
    """
    Publishes ``joint_states``.

    :param node: the node that publishes.
    :param robot: the robot.
    :param values: parameters: ``rate``, ``source_list``, ``zeros.JOINT``.
    """

    def __init__(self, node: Node, robot: RobotModel, values: dict[str, Any]) -> None:
        self._node = node
        self._robot = robot
        zeros = {name.removeprefix('zeros.'): float(value) for name, value in values.items()
                 if name.startswith('zeros.')}
        self._positions = {name: value for name, value in zeros.items()
                           if name in robot.active_joints}
        self._publisher = node.create_publisher(JointState, 'joint_states', 10)
        self._kept = [node.create_subscription(JointState, topic, self._take, 10)
                      for topic in values.get('source_list') or ()]
        node.create_timer(1.0 / float(values.get('rate') or _RATE), self._publish)

    def _take(self, message: JointState) -> None:
        self._positions.update((name, position) for name, position in zip(
            message.name, message.position, strict=False) if name in self._robot.active_joints)

    def _publish(self) -> None:
        full = self._robot.complete(self._positions)
        message = JointState(name=list(full), position=list(full.values()))
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


def _description(words: Sequence[str], arguments: NodeArguments) -> str:
    given = arguments.values.get(_DESCRIPTION)
    if given:
        return str(given)
    if words and Path(words[0]).is_file():
        return Path(words[0]).read_text(encoding='utf-8')
    return wait_for_descriptions(arguments, (_DESCRIPTION,))[_DESCRIPTION]
