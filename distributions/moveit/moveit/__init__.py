# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MoveIt's Python interface, answered by armsim_ros."""

from moveit.core import (
    collision_detection,
    controller_manager,
    kinematic_constraints,
    planning_interface,
    planning_scene,
    robot_model,
    robot_state,
    robot_trajectory,
    World,
)
from moveit.planning import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    MoveItPy,
    MultiPipelinePlanRequestParameters,
    PlanningComponent,
    PlanningSceneMonitor,
    PlanRequestParameters,
    TrajectoryExecutionManager,
)
from moveit.utils import get_launch_params_filepaths

__all__ = [
    'LockedPlanningSceneContextManagerRO',
    'LockedPlanningSceneContextManagerRW',
    'MoveItPy',
    'MultiPipelinePlanRequestParameters',
    'PlanRequestParameters',
    'PlanningComponent',
    'PlanningSceneMonitor',
    'TrajectoryExecutionManager',
    'World',
    'collision_detection',
    'controller_manager',
    'get_launch_params_filepaths',
    'kinematic_constraints',
    'planning_interface',
    'planning_scene',
    'robot_model',
    'robot_state',
    'robot_trajectory',
]
