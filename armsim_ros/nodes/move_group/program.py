# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program from start to end."""

from __future__ import annotations

from contextlib import ExitStack
import inspect
import sys
import time
from typing import Any, ClassVar

from rcl_interfaces.msg import ParameterDescriptor
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import Executor
from rclpy.node import Node
from std_srvs.srv import Trigger

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import coverage_report
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.cell import Cell
from armsim_ros.model.tree import standing_links
from armsim_ros.nodes import qos
from armsim_ros.nodes.executor_program import ExecutorProgram, failures_logged
from armsim_ros.nodes.move_group.capabilities import ALL, Parts, wanted_capabilities
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    TrajectoryExecutionEvent,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.parameters import (
    ControllerManagerNode,
    declare_fixed,
    MoveGroupParameters,
    planning_parameters,
)
from armsim_ros.nodes.move_group.planning.move_actions import SequenceJob
from armsim_ros.nodes.move_group.planning.planner_services import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob, PlanTopics
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.nodes.move_group.scene.octomap_monitor import octomap_settings, OctomapMonitor
from armsim_ros.nodes.move_group.scene.scene_services import MapFiles
from armsim_ros.nodes.move_group.scene.scene_topics import (
    AttachedCollisionObjectTopic,
    AttachHint,
    CollisionObjectTopic,
    MonitoredPlanningScene,
    PlanningSceneTopic,
    PlanningSceneWorldTopic,
    RejectedSceneChanges,
)
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.nodes.move_group.worker import Ticker, Worker
from armsim_ros.nodes.parameters import parameters_by_prefix
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.qos import publish_text
from armsim_ros.nodes.robot_program import LAST_ANSWERS_TIME
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor
from armsim_ros.planning.budget import CountingClock
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner, warm_up
from armsim_ros.scene_sources.simulated_world import initial_scene, WorldOwnership

#: Wall time to wait for the simulation [s].
ANSWER_TIMEOUT = 5.0


class SimulationSync:
    """Finds out which joint states are current."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._client = context.node.create_client(
            Trigger, '/simulation/sync', qos_profile=qos.SERVICES, callback_group=context.group)

    async def __call__(self) -> int:
        """
        Return the simulation's time [ns]; the joint states of it are on their way.

        :raises PlanningError: no answer, or the program ends.
        """
        context = self._context
        deadline = context.clock() + ANSWER_TIMEOUT
        while not self._client.service_is_ready() and context.clock() < deadline:
            context.check_ending('joint_states')
            await context.ticker.next()
        answer = self._client.call_async(Trigger.Request())
        while not answer.done() and context.clock() < deadline:
            context.check_ending('joint_states')
            await context.ticker.next()
        if not answer.done() or not answer.result().success:
            raise PlanningError(
                MoveItErrorCode.ROBOT_STATE_STALE,
                "the simulation does not answer on '/simulation/sync'; does it run in lockstep?",
                'joint_states')
        return int(answer.result().message)


class Descriptions:
    """Publishes a description whose parameter ``publish_...`` is true, as upstream does."""

    def __init__(self, context: Context) -> None:
        robot, node = context.robot, context.node
        texts = {'robot_description': robot.urdf, 'robot_description_semantic': robot.srdf}
        self._kept = [publish_text(node, name, text) for name, text in texts.items()
                      if node.has_parameter(f'publish_{name}')
                      and node.get_parameter(f'publish_{name}').value is True]


READY = 'You can start planning now!'
#: Relative, as upstream's: a server in a namespace reads that of the namespace.
DEFAULT_JOINT_STATES = 'joint_states'


class MoveGroup:
    """Every endpoint of the program."""

    def __init__(self, node: PollingNode, executor: Executor, cell: Cell) -> None:
        """Build the parts; the ready line comes when all of them answer."""
        self._context = context = make_context(node, executor, cell)
        settings, robot = context.settings, context.robot
        self._parameters = MoveGroupParameters(context)
        self._manager = ControllerManagerNode(context)
        executor.add_node(self._manager.node)
        self._endpoints = endpoints(context)
        declare_fixed(node, settings, context.planning_parameters, robot)
        self._parameters.warn_from_now_on()
        if self.execution.controllers.active is None:
            for line in coverage_report(robot, settings.moveit_controllers):
                context.logger.warning(line)
        ready = context.planning.submit(warm_up_with_log)
        # As upstream: printed, not logged, so that it is there at every log level.
        ready.add_done_callback(lambda _: print(f'\n{READY}\n', flush=True))

    @property
    def execution(self) -> TrajectoryExecutionManager:
        """What sends trajectories to the controllers."""
        return next(
            item for item in self._endpoints if isinstance(item, TrajectoryExecutionManager))

    def catch_up(self) -> None:
        """Bring clock, robot state and scene up to date; called before each callback."""
        self._context.node.catch_up()
        self._context.states.update_scene()

    def give_up(self) -> None:
        """Cancel what is planned and executed; their clients get the reason. From any thread."""
        self._context.end('move_group is shutting down')

    def end(self) -> None:
        """Give up, and let coroutines see that at once; from the executor's thread."""
        self.give_up()
        self._context.ticker.wake()

    def close(self) -> None:
        """End the workers and the second node."""
        self._manager.node.destroy_node()
        self._context.close()
        for item in self._endpoints:
            if isinstance(item, OctomapMonitor):
                item.close()


def warm_up_with_log() -> None:
    """
    Warm the planner up, and the log.

    A logger looks up its caller among the files of all modules: at first with thousands of system
    calls, each of which yields to a plan for a millisecond. The planner imports many modules.
    """
    warm_up()
    inspect.getmodule(inspect.currentframe())


def make_context(node: PollingNode, executor: Executor, cell: Cell) -> Context:
    """
    Return scene, planners, state monitor and workers for the robot of a node.

    :raises ConfigError: a parameter of the node is wrong.
    """
    settings = cell.settings
    robot = planning_robot(cell.model, settings.joint_limits)
    parameters = planning_parameters(node, settings)
    scene = initial_scene(KinematicModel(robot), settings, parameters, name='default')
    topics = parameters.joint_state_topics or (
        settings.joint_states_topic,
        node.resolve_topic_name(DEFAULT_JOINT_STATES))
    planning = settings_from_config(parameters, settings.pipelines, settings.kinematics)
    planner, query_planner = (
        MotionPlanner(scene, settings=planning, log=node.get_logger()) for _ in range(2))
    context = Context(
        node=node, settings=settings, robot=robot, scene=scene,
        states=StateMonitor(node, scene, tuple(dict.fromkeys(topics))),
        planning=Worker('planning', executor), queries=Worker('queries', executor),
        edits=Worker('edits', executor), ticker=Ticker(node), planner=planner,
        query_planner=query_planner, planning_parameters=parameters,
        execution_settings=settings.trajectory_execution,
        ownership=WorldOwnership(
            scene, standing_links(robot), node.get_logger().info, time.monotonic),
        robots=tuple(frozenset(each.model.active_joints) for each in cell.robots))
    if settings.simulation.deterministic:
        context.planning_clock = CountingClock
        context.states.asks = SimulationSync(context)
    return context


def endpoints(context: Context) -> tuple[object, ...]:
    """Create every endpoint; they live as long as the tuple does."""
    display = DisplayPlannedPath(context.node, context.robot.name, context.pipelines)
    job = PlanningJob(context, PlanTopics(context, display))
    execution = TrajectoryExecutionManager(context)
    octomap = OctomapMonitor(context, octomap_settings(context))
    parts = Parts(context, job, execution, display, SequenceJob(context, job), octomap)
    requested = wanted_capabilities(context.node, context.planning_parameters, context.logger)
    return (
        display, octomap, execution, *(item for name in requested for item in ALL[name](parts)),
        RejectedSceneChanges(context), PlanningSceneTopic(context),
        PlanningSceneWorldTopic(context), CollisionObjectTopic(context),
        AttachedCollisionObjectTopic(context), MonitoredPlanningScene(context),
        MapFiles(context, octomap.load), TrajectoryExecutionEvent(context, execution),
        Transforms(context), Descriptions(context), AttachHint(context))


#: Time for goals to be aborted at shutdown, and how often they are checked meanwhile [s].
_END_TIME, _CHECK_PERIOD = 1.0, 0.02
#: A client that has just sent a goal asks for its result this late [s].
_LATE_TIME = 0.2
#: How often the planner's thread yields the interpreter, so that answers do not wait [s].
_SWITCH_INTERVAL = 0.001


class MoveGroupProgram(ExecutorProgram):
    """Plans and executes: endpoints run in this thread, planning in worker threads."""

    NODE = 'move_group'
    NODE_OPTIONS: ClassVar[dict[str, Any]] = {
        'allow_undeclared_parameters': True,
        'automatically_declare_parameters_from_overrides': True,
    }

    _move_group: MoveGroup | None = None

    def stop(self) -> None:
        """End ``run``; a plan ends at once, whatever the executor's thread does."""
        if self._move_group is not None:
            self._move_group.give_up()
        super().stop()

    def _serve(
        self, executor: WaitSetExecutor, node: PollingNode, afterwards: ExitStack
    ) -> int:
        sys.setswitchinterval(_SWITCH_INTERVAL)
        name_with_dots(node)
        self._move_group = move_group = MoveGroup(node, executor, self._cell)
        afterwards.callback(move_group.close)
        self._spin(executor, node, move_group)
        return 0

    def _spin(self, executor: WaitSetExecutor, node: Node, move_group: MoveGroup) -> None:
        """Run callbacks until a stop is requested, and a little longer if clients wait."""
        ending, busy_at = False, -_LATE_TIME

        def to_end() -> bool:
            return self._stop_wanted() and not ending

        def step() -> None:
            """Run a callback, with the newest state and time."""
            nonlocal busy_at
            with failures_logged(node):
                # Always the same arguments: with others, callbacks that are ready would be lost.
                callback, *_ = executor.wait_for_ready_callbacks(None, None, to_end)
                move_group.catch_up()
                callback()
                if executor.has_unfinished:
                    busy_at = time.monotonic()
                callback.result()  # raises what the callback raised

        while not self._stop_wanted() and rclpy.ok():
            step()
        if time.monotonic() - busy_at < _LATE_TIME or executor.has_unfinished:
            ending = True
            move_group.end()
            node.create_timer(  # ends each wait
                _CHECK_PERIOD, lambda: None, clock=Clock(clock_type=ClockType.STEADY_TIME))
            begin = time.monotonic()
            while rclpy.ok() and (elapsed := time.monotonic() - begin) < _END_TIME:
                if elapsed > _LATE_TIME and not executor.has_unfinished:
                    break
                step()
            time.sleep(LAST_ANSWERS_TIME)


def name_with_dots(node: Node) -> None:
    """Give parameters of ``--ros-args`` whose names have the slashes of ROS 1 their own names."""
    for name, parameter in parameters_by_prefix(node, '').items():
        dotted = name.strip('/').replace('/', '.')
        if dotted != name and not node.has_parameter(dotted):
            node.declare_parameter(
                dotted, parameter.value, ParameterDescriptor(dynamic_typing=True))
