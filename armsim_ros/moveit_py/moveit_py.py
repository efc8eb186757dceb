# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MoveItPy: the face of planning and execution for a script."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
import weakref

from armsim_ros.errors import PlanningError
from armsim_ros.moveit_py.answers import ExecutionStatus
from armsim_ros.moveit_py.description import node_arguments
from armsim_ros.moveit_py.moveit_cpp import MoveItCpp
from armsim_ros.moveit_py.planning_component import PlanningComponent
from armsim_ros.moveit_py.planning_scene_monitor import PlanningSceneMonitor
from armsim_ros.moveit_py.robot_model import RobotModel
from armsim_ros.moveit_py.robot_trajectory import RobotTrajectory
from armsim_ros.moveit_py.trajectory_execution_manager import TrajectoryExecutionManager
from armsim_ros.moveit_py.utils import get_launch_params_filepaths, logger


class MoveItPy:
    """
    Plans and executes in the script's process; joint states and controllers are those of ROS.

    :param node_name: of the node.
    :param name_space: of the node; topics and services are relative to it.
    :param launch_params_filepaths: parameter files, in order; None for those of the command line.
    :param config_dict: parameters, nested; they win over the files.
    :param provide_planning_service: whether the service ``get_planning_scene`` is offered.
    :param remappings: name -> other name.
    :raises RuntimeError: the robot's description is missing, or no complete robot state came.
    :raises ConfigError: a parameter or a description is wrong.
    """

    def __init__(
        self, node_name: str = 'moveit_py', name_space: str = '',
        launch_params_filepaths: Sequence[str] | None = None,
        config_dict: Mapping[str, Any] | None = None, provide_planning_service: bool = True,
        remappings: Mapping[str, str] | None = None
    ) -> None:
        files = launch_params_filepaths
        if files is None:
            files = get_launch_params_filepaths()
        self._cpp = cpp = MoveItCpp(
            node_arguments(node_name, name_space, files, config_dict, remappings),
            provide_planning_service=provide_planning_service)
        # The thread of the node must not outlive the interpreter.
        self._end = weakref.finalize(self, cpp.close)
        context = cpp.context
        self._model = RobotModel._of(context.scene.kinematic_model, context.planner.settings)
        self._monitor = PlanningSceneMonitor(cpp, self._model)
        self._execution = TrajectoryExecutionManager(cpp)

    def get_planning_component(self, planning_component_name: str) -> PlanningComponent:
        """
        Return what plans for a group.

        :raises RuntimeError: there is no such group; lists those that there are.
        """
        return PlanningComponent(planning_component_name, self)

    def get_robot_model(self) -> RobotModel:
        """Return the robot."""
        return self._model

    def get_planning_scene_monitor(self) -> PlanningSceneMonitor:
        """Return what keeps the planning scene."""
        return self._monitor

    def get_trajectory_execution_manager(self) -> TrajectoryExecutionManager:
        """Return what sends trajectories to controllers."""
        return self._execution

    def execute(
        self, robot_trajectory: RobotTrajectory | None, controllers: Sequence[str]
    ) -> ExecutionStatus:
        """
        Execute a trajectory and wait for its end; it moves the joints of its planning group.

        :param controllers: names of the controllers to use; an empty list for a choice by joints.
        :returns: ABORTED for a trajectory that is empty or has no group, too.
        """
        if robot_trajectory is None or not len(robot_trajectory):
            logger().error('execute: there is no trajectory')
            return ExecutionStatus('ABORTED')
        if not robot_trajectory.joint_model_group_name:
            logger().error('execute: the trajectory has no planning group; set '
                           'joint_model_group_name')
            return ExecutionStatus('ABORTED')
        try:
            return self._execution._execute_now(robot_trajectory._selected(), controllers)
        except PlanningError as error:
            logger().error(f'execute: {error}')
            return ExecutionStatus('ABORTED')

    def shutdown(self) -> None:
        """End the node, and what it plans or executes; the script's own rclpy goes on."""
        self._end()
