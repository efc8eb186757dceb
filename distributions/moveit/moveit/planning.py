# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.planning``."""

from armsim_ros.moveit_py.planning.moveit_py import MoveItPy
from armsim_ros.moveit_py.planning.plan_parameters import (
    MultiPipelinePlanRequestParameters,
    PlanRequestParameters,
)
from armsim_ros.moveit_py.planning.planning_component import PlanningComponent
from armsim_ros.moveit_py.planning.planning_scene_monitor import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    PlanningSceneMonitor,
)
from armsim_ros.moveit_py.planning.trajectory_execution_manager import TrajectoryExecutionManager

__all__ = [
    'LockedPlanningSceneContextManagerRO',
    'LockedPlanningSceneContextManagerRW',
    'MoveItPy',
    'MultiPipelinePlanRequestParameters',
    'PlanRequestParameters',
    'PlanningComponent',
    'PlanningSceneMonitor',
    'TrajectoryExecutionManager',
]
