# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.planning``."""

from armsim_ros.moveit_py.moveit_py import MoveItPy
from armsim_ros.moveit_py.planning_component import (
    MultiPipelinePlanRequestParameters,
    PlanningComponent,
    PlanRequestParameters,
)
from armsim_ros.moveit_py.planning_scene_monitor import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    PlanningSceneMonitor,
)
from armsim_ros.moveit_py.trajectory_execution_manager import TrajectoryExecutionManager

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
