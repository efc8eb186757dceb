# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers run a trajectory, and what each of them gets."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.config.move_group.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.execution.controller_selection import controlled_joints, select_controllers
from armsim_ros.execution.multi_dof import MultiDofTrajectory
from armsim_ros.execution.rules import check_points, Tolerances
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.controller_managers import SimpleControllerManager
from armsim_ros.trajectory import JointTrajectory

#: The part of a controller.
Part = tuple[MoveItControllerSettings, JointTrajectory, MultiDofTrajectory | None]


def start_tolerances(context: Context) -> Tolerances:
    """Return how far a trajectory may begin from where the robot is."""
    settings = context.execution_settings
    return Tolerances(settings.allowed_start_tolerance, settings.allowed_start_tolerance_joints)


def selected_controllers(
    context: Context, controllers: SimpleControllerManager, trajectory: JointTrajectory,
    names: Sequence[str], multi_dof: MultiDofTrajectory | None = None,
) -> tuple[MoveItControllerSettings, ...]:
    """
    Return the controllers of a trajectory; none where it has no points.

    :raises PlanningError: CONTROL_FAILED where it cannot be executed.
    """
    check_points(trajectory)
    joints = [*(trajectory.joint_names if len(trajectory) else ()),
              *(multi_dof.joint_names if multi_dof is not None else ())]
    if not len(trajectory) and multi_dof is None:
        return ()
    return select_controllers(
        controlled_joints(joints, context.robot), controllers.controllers, names=tuple(names),
        active=controllers.active,
        manages=context.execution_settings.moveit_manage_controllers)


def multi_dof_part(
    controller: MoveItControllerSettings, multi_dof: MultiDofTrajectory | None,
    settings: TrajectoryExecutionSettings,
) -> MultiDofTrajectory | None:
    """Return what the multi-DOF joints of a controller do, None where it has none."""
    names = [name for name in (multi_dof.joint_names if multi_dof is not None else ())
             if name in controller.joints]
    if multi_dof is None or not names:
        return None
    return multi_dof.of_joints(sorted(names), settings.execution_velocity_scaling)
