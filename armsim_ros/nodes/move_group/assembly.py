# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group as a whole: its parts, put together once at the start."""

from __future__ import annotations

from rclpy.executors import Executor
from rclpy.node import Node

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell import Cell
from armsim_ros.nodes.move_group.attach_hint import AttachHint
from armsim_ros.nodes.move_group.attached_collision_object import AttachedCollisionObject
from armsim_ros.nodes.move_group.capabilities import CAPABILITIES, Parts, wanted_capabilities
from armsim_ros.nodes.move_group.collision_object import CollisionObject
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.display_planned_path import DisplayPlannedPath
from armsim_ros.nodes.move_group.fixed_parameters import declare_fixed, planning_parameters
from armsim_ros.nodes.move_group.joint_states import StateMonitor
from armsim_ros.nodes.move_group.monitored_planning_scene import MonitoredPlanningScene
from armsim_ros.nodes.move_group.parameters import MoveGroupParameters
from armsim_ros.nodes.move_group.planning_job import PlanningJob
from armsim_ros.nodes.move_group.planning_scene import PlanningSceneTopics
from armsim_ros.nodes.move_group.sequence_job import SequenceJob
from armsim_ros.nodes.move_group.trajectory_execution import TrajectoryExecution
from armsim_ros.nodes.move_group.trajectory_execution_event import TrajectoryExecutionEvent
from armsim_ros.nodes.move_group.transforms import Transforms
from armsim_ros.nodes.move_group.worker import Worker
from armsim_ros.planning.controller_selection import coverage_report
from armsim_ros.planning.initial_scene import initial_scene
from armsim_ros.planning.planner import MotionPlanner, warm_up
from armsim_ros.planning.settings import settings_from_config

READY = 'You can start planning now!'
DEFAULT_JOINT_STATES = '/joint_states'


class MoveGroup:
    """
    Every endpoint of the program.

    :param node: has the endpoints.
    :param executor: the one that spins the node.
    :param cell: the robot, or all robots of a cell.
    """

    def __init__(self, node: Node, executor: Executor, cell: Cell) -> None:
        """Build the parts; the ready line comes when all of them answer."""
        settings, robot = cell.settings, cell.model
        model = KinematicModel(robot)
        parameters = planning_parameters(node, settings)
        scene = initial_scene(model, settings, parameters, name='default')
        topics = parameters.joint_state_topics or (
            settings.joint_states_topic,
            DEFAULT_JOINT_STATES,
        )
        planning = settings_from_config(parameters, settings.ompl, settings.kinematics)
        planner, query_planner = (
            MotionPlanner(
                scene, settings=planning, log=node.get_logger(), second_attempt_delay=delay)
            for delay in (settings.ompl.second_attempt_delay, 0.0)
        )
        self._context = context = Context(
            node=node,
            settings=settings,
            robot=robot,
            scene=scene,
            states=StateMonitor(node, scene, tuple(dict.fromkeys(topics))),
            planning=Worker('planning', executor),
            queries=Worker('queries', executor),
            planner=planner,
            query_planner=query_planner,
            planning_parameters=parameters,
            execution_settings=settings.trajectory_execution,
            robots=tuple(frozenset(each.model.active_joints) for each in cell.robots),
        )
        self._endpoints = endpoints(context)
        self._parameters = MoveGroupParameters(context)
        declare_fixed(node, settings, parameters, robot)
        for line in coverage_report(robot, settings.moveit_controllers):
            context.logger.warning(line)
        ready = context.planning.submit(warm_up)
        ready.add_done_callback(lambda _: context.logger.info(READY))

    @property
    def execution(self) -> TrajectoryExecution:
        """What sends trajectories to the controllers."""
        return next(item for item in self._endpoints if isinstance(item, TrajectoryExecution))

    def close(self) -> None:
        """End the workers."""
        self._context.planning.close()
        self._context.queries.close()
        self._context.planner.close()


def endpoints(context: Context) -> tuple[object, ...]:
    """Make every endpoint; they live as long as the tuple does."""
    display = DisplayPlannedPath(context.node, context.robot.name)
    job = PlanningJob(context, display)
    execution = TrajectoryExecution(context)
    parts = Parts(context, job, execution, display, SequenceJob(context, job, display))
    wanted = wanted_capabilities(context.node, context.planning_parameters, context.logger)
    return (
        display,
        execution,
        *(item for name in wanted for item in CAPABILITIES[name](parts)),
        PlanningSceneTopics(context),
        CollisionObject(context),
        AttachedCollisionObject(context),
        MonitoredPlanningScene(context),
        TrajectoryExecutionEvent(context, execution),
        Transforms(context),
        AttachHint(context),
    )
