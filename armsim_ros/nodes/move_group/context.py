# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the endpoints of move_group share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import time
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile

from armsim_ros.config.planning_parameters import PlanningParameters
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.trajectory_execution import TrajectoryExecutionSettings
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.move_group.joint_states import StateMonitor
from armsim_ros.nodes.move_group.worker import Worker
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.scene import PlanningScene


@dataclass(eq=False)
class Context:
    """
    The parts of move_group.

    Everything runs in the executor's thread, except what is handed to a worker: ``planning``
    searches for motions and may be busy for seconds, ``queries`` answers at once. Each worker
    has a planner (with a collision checker) of its own and works on snapshots of the scene.

    :param node: has the endpoints.
    :param scene: the monitored scene.
    :param planning_parameters: what the robot's files and the command line say.
    :param execution_settings: may be replaced while the program runs.
    :param robots: the joints of each robot; several where it is a cell.
    :param record_frequency: states a second in executed_trajectory [Hz]; may be replaced too.
    """

    node: Node
    settings: RobotSettings
    robot: RobotModel
    scene: PlanningScene
    states: StateMonitor
    planning: Worker
    queries: Worker
    planner: MotionPlanner
    query_planner: MotionPlanner
    planning_parameters: PlanningParameters
    execution_settings: TrajectoryExecutionSettings
    robots: tuple[frozenset[str], ...] = ()
    record_frequency: float = 0.0
    group: ReentrantCallbackGroup = field(default_factory=ReentrantCallbackGroup)
    clock: Callable[[], float] = time.monotonic
    _warned: set[str] = field(default_factory=set)

    @property
    def logger(self) -> Any:
        """The node's logger."""
        return self.node.get_logger()

    @property
    def frame(self) -> str:
        """The model frame."""
        return self.robot.model_frame

    def serve(self, kind: Any, name: str, answer: Callable[..., Any]) -> None:
        """Make a service; its coroutines may run side by side."""
        self.node.create_service(kind, name, answer, callback_group=self.group)

    def subscribe(
        self, kind: Any, name: str, receive: Callable[[Any], None], profile: QoSProfile | int = 10
    ) -> None:
        """Subscribe to a topic, reliable and 10 messages deep unless a profile is given."""
        self.node.create_subscription(kind, name, receive, profile, callback_group=self.group)

    def warn_once(self, text: str) -> None:
        """Log a warning the first time that it is said."""
        if text not in self._warned:
            self._warned.add(text)
            self.logger.warning(text)
