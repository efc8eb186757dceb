# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node that does robot_state_publisher's work: descriptions and transforms."""

from __future__ import annotations

from functools import partial

from rclpy.node import Node

from armsim_ros.config.base import parameter, Settings
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import matrix_from_rpy, pose_from_parts
from armsim_ros.nodes.latched_text import publish_descriptions
from armsim_ros.nodes.parameters import SettingsParameters
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.tf import Tf
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.simulation import Simulation


class RobotStatePublisherParameters(Settings):
    """Parameters that clients read from robot_state_publisher."""

    robot_description: str = parameter('', 'the URDF', read_only=True)
    robot_description_semantic: str = parameter('', 'the SRDF', read_only=True)
    publish_frequency: float = parameter(
        50.0, 'messages on /tf a second of simulated time [Hz]', read_only=True, gt=0.0, le=1000.0
    )


class RobotStatePublisher:
    """
    Publishes ``/robot_description``, ``/robot_description_semantic``, ``/tf``, ``/tf_static``.

    :param node: the node of that name.
    :param simulation: whose joints are shown.
    """

    def __init__(self, node: Node, model: RobotModel, simulation: Simulation) -> None:
        parameters = SettingsParameters(
            node,
            RobotStatePublisherParameters(
                robot_description=model.urdf, robot_description_semantic=model.srdf
            ),
        )
        self._period_ns = round(1e9 / parameters.settings.publish_frequency)
        self._simulation = simulation
        placement = simulation.settings.placement
        self._tf = Tf(
            node, model, pose_from_parts(placement.xyz, matrix_from_rpy(placement.rpy))
        )
        self._kept = publish_descriptions(node, model.urdf, model.srdf)

    def follow(self, loop: ControlLoop, dispatcher: Dispatcher) -> None:
        """Publish transforms in the loop's time; the positions are those of the stamp."""
        position = self._simulation.state.position
        post = dispatcher.bounded()
        loop.every(
            self._period_ns,
            lambda time_ns: post(partial(self._tf.publish, time_ns, position.copy())),
        )
