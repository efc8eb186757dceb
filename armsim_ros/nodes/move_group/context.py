# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the endpoints of move_group share, and how they answer."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
import time
import traceback
from typing import Any

from moveit_msgs.msg import MoveItErrorCodes
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from armsim_ros.config.ompl_planning import PipelineSettings, PlanningParameters
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.trajectory_execution import TrajectoryExecutionSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.nodes.move_group.worker import Ticker, Worker
from armsim_ros.nodes.polling_node import KeptResults, PollingNode
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

    @property
    def pipelines(self) -> dict[str, PipelineSettings]:
        """The planning pipelines that are offered."""
        return {name: self.settings.pipelines[name]
                for name in self.planning_parameters.planning_pipelines}

    def pipeline_of(self, pipeline_id: str) -> str:
        """Return the name of the pipeline for a request: the default where it names none."""
        return pipeline_id or self.planning_parameters.default_planning_pipeline

    async def present_scene(self) -> PlanningScene:
        """Return a snapshot with all edits that came before, and the newest robot state."""
        await self.edits.idle()
        self.states.update_scene()
        return self.scene.snapshot()

    def started(self, scene: PlanningScene, start: StartState) -> PlanningScene:
        """Return a snapshot with a client's start state, as configured."""
        return scene.with_start_state(start, strict=self.planner.settings.strict_start_state)

    def serve(
        self, kind: Any, name: str, fill: Callable[[Any, Any], Awaitable[None]],
        error_code: Callable[[Any], MoveItErrorCodes] | None = None,
    ) -> None:
        """
        Create a service; its coroutines may run concurrently.

        :param fill: gets the request, and the response to fill; its errors are logged.
        :param error_code: response -> where its errors are written, too.
        """
        async def answer(request: Any, response: Any) -> Any:
            code = error_code(response) if error_code is not None else None
            with reported(self.logger, name, code):
                await fill(request, response)
            return response

        self.node.create_service(kind, name, answer, callback_group=self.group)

    def subscribe(
        self, kind: Any, name: str, receive: Callable[[Any], None], profile: QoSProfile | int = 10
    ) -> Subscription:
        """Subscribe to a topic, reliable and 10 messages deep unless a profile is given."""
        made = self.node.create_subscription(
            kind, name, receive, profile, callback_group=self.group)
        assert made is not None  # that to /clock may be None
        return made

    def end(self, reason: str) -> None:
        """Give up all that is planned, executed or waited for; from any thread."""
        self.ending = reason
        self.states.patient = False

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


@contextmanager
def reported(logger: Any, source: str, error_code: MoveItErrorCodes | None) -> Iterator[None]:
    """
    Turn exceptions raised inside into the error code of an answer.

    :param source: the endpoint, where the error does not name a stage itself.
    :param error_code: to be filled; None for an answer without.
    """
    try:
        yield
    except PlanningError as error:
        logger.error(f'{source}: {error}')
        fill_error(error_code, error.code, str(error), error.source or source)
    except Exception as error:  # noqa: BLE001 - no node dies of a message
        text = ''.join(traceback.format_exception(error))
        logger.error(f'{source}: internal error, please report it:\n{text}')
        fill_error(error_code, MoveItErrorCode.FAILURE, f'internal error: {error}', source)


def fill_error(
    error_code: MoveItErrorCodes | None, code: int, text: str = '', source: str = ''
) -> None:
    """Write a code, its sentence and its source into an answer."""
    if error_code is not None:
        error_code.val, error_code.message, error_code.source = int(code), text, source


#: How long results are kept for clients that ask late [s], and how many of them.
RESULT_TIMEOUT, MOST_RESULTS = 60, 50


class MoveGroupActionServer(ActionServer):
    """
    Accepts every goal and keeps the results of those that ended last.

    :param execute: goal handle -> result; it calls :meth:`end` at last.
    """

    def __init__(
        self, context: Context, kind: Any, name: str,
        execute: Callable[[ServerGoalHandle], Awaitable[Any]],
    ) -> None:
        super().__init__(  # type: ignore[no-untyped-call] # rclpy's
            context.node, kind, name, execute, callback_group=context.group,
            cancel_callback=lambda goal: CancelResponse.ACCEPT, result_timeout=RESULT_TIMEOUT,
            **qos.ACTION_SERVICES)
        self._results = KeptResults(self, MOST_RESULTS)

    def end(self, goal: ServerGoalHandle, code: int) -> None:
        """
        Give a goal its terminal status.

        SUCCESS succeeds; PREEMPTED after a cancel request is canceled; all else is aborted.
        """
        if code == MoveItErrorCode.SUCCESS:
            goal.succeed()
        elif code == MoveItErrorCode.PREEMPTED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        self._results.add(goal)
