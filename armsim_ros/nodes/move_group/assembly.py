# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group as a whole: its parts, put together once at the start."""

from __future__ import annotations

from rclpy.executors import Executor

from armsim_ros.counting_clock import CountingClock
from armsim_ros.execution.controller_selection import coverage_report
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.cell import Cell
from armsim_ros.model.tree import standing_links
from armsim_ros.nodes.move_group.capabilities import ALL, Parts, wanted_capabilities
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.descriptions import Descriptions
from armsim_ros.nodes.move_group.execution.manager_parameters import ControllerManagerNode
from armsim_ros.nodes.move_group.execution.simulation_sync import SimulationSync
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    TrajectoryExecutionEvent,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.fixed_parameters import declare_fixed, planning_parameters
from armsim_ros.nodes.move_group.parameters import MoveGroupParameters
from armsim_ros.nodes.move_group.planning.display import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob
from armsim_ros.nodes.move_group.planning.sequence_job import SequenceJob
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.nodes.move_group.scene.monitored_planning_scene import MonitoredPlanningScene
from armsim_ros.nodes.move_group.scene.scene_topics import (
    AttachedCollisionObjectTopic,
    AttachHint,
    CollisionObjectTopic,
    PlanningSceneTopics,
)
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.nodes.move_group.worker import Ticker, Worker
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.planning.planner import MotionPlanner, warm_up
from armsim_ros.planning.settings import settings_from_config
from armsim_ros.scene_sources.simulated_world import (
    initial_scene,
    WorldOwnership,
)

READY = 'You can start planning now!'
#: Relative, as upstream's: a server in a namespace reads that of the namespace.
DEFAULT_JOINT_STATES = 'joint_states'


class MoveGroup:
    """
    Every endpoint of the program.

    :param node: has the endpoints.
    :param executor: the executor that spins the node.
    :param cell: the robot, or all robots of a cell.
    """

    def __init__(self, node: PollingNode, executor: Executor, cell: Cell) -> None:
        """Build the parts; the ready line comes when all of them answer."""
        settings = cell.settings
        robot = planning_robot(cell.model, settings.joint_limits)
        model = KinematicModel(robot)
        parameters = planning_parameters(node, settings)
        scene = initial_scene(model, settings, parameters, name='default')
        topics = parameters.joint_state_topics or (
            settings.joint_states_topic,
            node.resolve_topic_name(DEFAULT_JOINT_STATES),
        )
        planning = settings_from_config(parameters, settings.ompl, settings.kinematics)
        planner, query_planner = (
            MotionPlanner(scene, settings=planning, log=node.get_logger()) for _ in range(2)
        )
        self._context = context = Context(
            node=node,
            settings=settings,
            robot=robot,
            scene=scene,
            states=StateMonitor(node, scene, tuple(dict.fromkeys(topics))),
            planning=Worker('planning', executor),
            queries=Worker('queries', executor),
            edits=Worker('edits', executor),
            ticker=Ticker(node),
            planner=planner,
            query_planner=query_planner,
            planning_parameters=parameters,
            execution_settings=settings.trajectory_execution,
            ownership=WorldOwnership(scene, standing_links(robot), node.get_logger().info),
            robots=tuple(frozenset(each.model.active_joints) for each in cell.robots),
        )
        if settings.simulation.deterministic:
            context.planning_clock = CountingClock
            context.states.asks = SimulationSync(context)
        self._parameters = MoveGroupParameters(context)
        self._manager = ControllerManagerNode(context)
        executor.add_node(self._manager.node)
        self._endpoints = endpoints(context)
        declare_fixed(node, settings, parameters, robot)
        self._parameters.warn_from_now_on()
        if self.execution.controllers.active is None:
            for line in coverage_report(robot, settings.moveit_controllers):
                context.logger.warning(line)
        ready = context.planning.submit(warm_up)
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

    def end(self, sentence: str) -> None:
        """Cancel what is planned and executed; their clients get the reason."""
        self._context.ending = sentence
        self._context.ticker.wake()

    def close(self) -> None:
        """End the workers and the second node."""
        self._manager.node.destroy_node()
        self._context.planning.close()
        self._context.queries.close()
        self._context.edits.close()


def endpoints(context: Context) -> tuple[object, ...]:
    """Create every endpoint; they live as long as the tuple does."""
    display = DisplayPlannedPath(context.node, context.robot.name, context.settings.ompl)
    job = PlanningJob(context, display)
    execution = TrajectoryExecutionManager(context)
    parts = Parts(context, job, execution, display, SequenceJob(context, job, display))
    requested = wanted_capabilities(context.node, context.planning_parameters, context.logger)
    return (
        display,
        execution,
        *(item for name in requested for item in ALL[name](parts)),
        PlanningSceneTopics(context),
        CollisionObjectTopic(context),
        AttachedCollisionObjectTopic(context),
        MonitoredPlanningScene(context),
        TrajectoryExecutionEvent(context, execution),
        Transforms(context),
        Descriptions(context),
        AttachHint(context),
    )
