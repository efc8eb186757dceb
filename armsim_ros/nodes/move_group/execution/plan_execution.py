# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The execution of a planned trajectory, watched for changes of the scene."""

from __future__ import annotations

from collections.abc import Callable

from armsim_ros.nodes.move_group.execution.execution import ExecutionOutcome, ExecutionWatch
from armsim_ros.nodes.move_group.execution.path_watch import PathWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import TrajectoryExecutionManager
from armsim_ros.trajectory import JointTrajectory


async def execute_plan(
    execution: TrajectoryExecutionManager,
    trajectory: JointTrajectory,
    path: PathWatch,
    cancelled: Callable[[], bool],
    observe: Callable[[float], None] = lambda elapsed: None,
) -> ExecutionOutcome:
    """
    Execute a planned trajectory and return the outcome.

    :param path: ends the execution where the rest of the path has become invalid.
    :param cancelled: whether the client has cancelled its goal.
    :param observe: called with the seconds since the start, every 20 ms.
    """
    outcome = await execution.run(
        trajectory, ExecutionWatch(cancelled=cancelled, invalid=path.invalid, observe=observe))
    return outcome.of_plan(cancelled=cancelled())
