# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the endpoints of move_group share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import time
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import QoSProfile

from armsim_ros.config.move_group.ompl_planning import PlanningParameters
from armsim_ros.config.move_group.trajectory_execution import TrajectoryExecutionSettings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.nodes.move_group.worker import Ticker, Worker
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from armsim_ros.scene_sources.simulated_world import WorldOwnership


@dataclass(eq=False)
class Context:
    """
    The parts of move_group.

    Everything runs in the executor's thread, except what is handed to a worker: ``planning``
    searches for motions and may be busy for seconds, ``queries`` answers at once, ``edits``
    changes the scene and writes it into messages. Planning and queries have each a planner
    (with a collision checker) of their own and work on snapshots of the scene.

    :param node: has the endpoints.
    :param scene: the monitored scene.
    :param planning_parameters: from the robot's files and the command line.
    :param ownership: knows what of the scene belongs to a simulated world.
    :param execution_settings: may be replaced while the program runs.
    :param robots: the joints of each robot; several where it is a cell.
    :param ending: why the program ends; '' while it does not.
    :param record_frequency: states a second in executed_trajectory [Hz]; may be replaced too.
    :param scene_log: gets why a change of the scene is refused; None for the node's logger.
    :param planning_clock: makes the clock by which a request's time is measured.
    """

    node: PollingNode
    settings: RobotSettings
    robot: RobotModel
    scene: PlanningScene
    states: StateMonitor
    planning: Worker
    queries: Worker
    edits: Worker
    ticker: Ticker
    planner: MotionPlanner
    query_planner: MotionPlanner
    planning_parameters: PlanningParameters
    execution_settings: TrajectoryExecutionSettings
    ownership: WorldOwnership
    robots: tuple[frozenset[str], ...] = ()
    record_frequency: float = 0.0
    ending: str = ''
    group: ReentrantCallbackGroup = field(default_factory=ReentrantCallbackGroup)
    clock: Callable[[], float] = time.monotonic
    planning_clock: Callable[[], Callable[[], float]] = lambda: time.monotonic
    scene_log: Any = None
    _warned: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        """Log refused changes of the scene to the node until another log takes them."""
        self.scene_log = self.scene_log or self.logger

    @property
    def logger(self) -> Any:
        """The node's logger."""
        return self.node.get_logger()

    @property
    def frame(self) -> str:
        """The model frame."""
        return self.robot.model_frame

    async def present_scene(self) -> PlanningScene:
        """Return a snapshot with all edits that came before, and the newest robot state."""
        await self.edits.idle()
        self.states.update_scene()
        return self.scene.snapshot()

    def started(self, scene: PlanningScene, start: StartState) -> PlanningScene:
        """Return a snapshot with a client's start state, as configured."""
        return scene.with_start_state(start, strict=self.planner.settings.strict_start_state)

    def serve(self, kind: Any, name: str, answer: Callable[..., Any]) -> None:
        """Create a service; its coroutines may run concurrently."""
        self.node.create_service(kind, name, answer, callback_group=self.group)

    def subscribe(
        self, kind: Any, name: str, receive: Callable[[Any], None], profile: QoSProfile | int = 10
    ) -> None:
        """Subscribe to a topic, reliable and 10 messages deep unless a profile is given."""
        self.node.create_subscription(kind, name, receive, profile, callback_group=self.group)

    def or_ending(self, cancelled: Callable[[], bool]) -> Callable[[], bool]:
        """Return a predicate that is true once a request is cancelled or the program ends."""
        return lambda: bool(self.ending) or cancelled()

    def check_ending(self, source: str) -> None:
        """
        Do nothing while the program goes on.

        :raises PlanningError: it ends.
        """
        if self.ending:
            raise PlanningError(MoveItErrorCode.FAILURE, self.ending, source)

    def close(self) -> None:
        """End the workers; each finishes the job that it does."""
        for worker in (self.planning, self.queries, self.edits):
            worker.close()

    def warn_once(self, text: str) -> None:
        """Log a warning once."""
        if text not in self._warned:
            self._warned.add(text)
            self.logger.warning(text)
