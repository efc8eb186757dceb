# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which of move_group's services and actions are offered, by the names of their plugins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node

from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.errors import nearest
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.execute_trajectory import (
    ExecuteTaskSolution,
    ExecuteTrajectory,
)
from armsim_ros.nodes.move_group.execution.trajectory_execution import TrajectoryExecutionManager
from armsim_ros.nodes.move_group.planning.move_actions import (
    MoveAction,
    SequenceJob,
    SequenceMoveGroup,
)
from armsim_ros.nodes.move_group.planning.planner_services import (
    DisplayPlannedPath,
    PlannerParams,
    QueryPlannerInterface,
)
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob
from armsim_ros.nodes.move_group.planning.planning_services import (
    ComputeCartesianPath,
    PlanKinematicPath,
    PlanSequencePath,
)
from armsim_ros.nodes.move_group.query_services import (
    CheckStateValidity,
    ComputeFk,
    ComputeIk,
    GetUrdf,
)
from armsim_ros.nodes.move_group.scene.octomap_monitor import OctomapMonitor
from armsim_ros.nodes.move_group.scene.scene_services import (
    ApplyPlanningScene,
    ClearOctomap,
    GeometryFiles,
    GetPlanningScene,
    SceneFrames,
)

#: The action's name in ROS 1.
OLD_NAME = 'move_group'


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts that capabilities are built from."""

    context: Context
    job: PlanningJob
    execution: TrajectoryExecutionManager
    display: DisplayPlannedPath
    sequence: SequenceJob
    octomap: OctomapMonitor


#: Plugin -> what makes its endpoints. All are on unless they are disabled, those of Pilz too.
CAPABILITIES: Mapping[str, Callable[[Parts], tuple[object, ...]]] = {
    'move_group/LoadGeometryFromFileService': lambda parts: (
        GeometryFiles(parts.context, save=False),
    ),
    'move_group/SaveGeometryToFileService': lambda parts: (
        GeometryFiles(parts.context, save=True),
    ),
    'move_group/GetUrdfService': lambda parts: (GetUrdf(parts.context),),
    'move_group/MoveGroupCartesianPathService': lambda parts: (
        ComputeCartesianPath(parts.context, parts.job, parts.display),
    ),
    'move_group/MoveGroupKinematicsService': lambda parts: (
        ComputeIk(parts.context),
        ComputeFk(parts.context)),
    'move_group/MoveGroupExecuteTrajectoryAction': lambda parts: (
        ExecuteTrajectory(parts.context, parts.execution),
    ),
    'move_group/ExecuteTaskSolutionCapability': lambda parts: (
        ExecuteTaskSolution(parts.context, parts.execution),
    ),
    'move_group/MoveGroupMoveAction': lambda parts: (
        MoveAction(parts.context, parts.job, parts.execution),
        MoveAction(parts.context, parts.job, parts.execution, name=OLD_NAME)),
    'move_group/MoveGroupPlanService': lambda parts: (
        PlanKinematicPath(parts.context, parts.job),
    ),
    'move_group/MoveGroupQueryPlannersService': lambda parts: (
        QueryPlannerInterface(parts.context),
        PlannerParams(parts.context)),
    'move_group/MoveGroupStateValidationService': lambda parts: (
        CheckStateValidity(parts.context),
    ),
    'move_group/MoveGroupGetPlanningSceneService': lambda parts: (
        GetPlanningScene(parts.context),
    ),
    'move_group/ApplyPlanningSceneService': lambda parts: (
        ApplyPlanningScene(parts.context),
    ),
    'move_group/ClearOctomapService': lambda parts: (
        ClearOctomap(parts.context, parts.octomap.forget),
    ),
    'pilz_industrial_motion_planner/MoveGroupSequenceAction': lambda parts: (
        SequenceMoveGroup(parts.context, parts.sequence, parts.execution),
    ),
    'pilz_industrial_motion_planner/MoveGroupSequenceService': lambda parts: (
        PlanSequencePath(parts.context, parts.sequence),
    ),
}

#: Capabilities that are off unless they are asked for.
OPTIONAL: Mapping[str, Callable[[Parts], tuple[object, ...]]] = {
    'move_group/TfPublisher': lambda parts: (SceneFrames(parts.context),),
}
ALL = {**CAPABILITIES, **OPTIONAL}


def wanted_capabilities(node: Node, planning: PlanningParameters, logger: Any) -> list[str]:
    """
    Return the plugins to offer; an unknown name is logged and left out.

    :param planning: what to add to the usual ones and what to take away.
    """
    added = list(planning.capabilities)
    for pipeline in planning.planning_pipelines:
        parameter = f'{pipeline}.capabilities'
        if node.has_parameter(parameter):
            added += str(node.get_parameter(parameter).value).split()
    disabled = set(_known(planning.disable_capabilities, 'disable_capabilities', logger))
    requested = dict.fromkeys([*CAPABILITIES, *_known(added, 'capabilities', logger)])
    return [name for name in requested if name not in disabled]


def _known(names: Iterable[str], parameter: str, logger: Any) -> Iterable[str]:
    for name in names:
        if name in ALL:
            yield name
        else:
            hint = nearest(name, tuple(ALL)) or f"known: {', '.join(ALL)}"
            logger.error(f"{parameter}: capability '{name}' is not known; {hint}")
