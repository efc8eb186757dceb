# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What other threads leave in a trajectory controller's mailbox for its control loop."""

from __future__ import annotations

from dataclasses import dataclass

from armsim_ros.config.joint_trajectory_controller import JointTrajectoryControllerParameters
from armsim_ros.control.sampling import PreparedTrajectory
from armsim_ros.control.tolerances import SegmentTolerances
from armsim_ros.control.trajectory_goal import TrajectoryGoal


@dataclass(frozen=True, slots=True, eq=False)
class StartRequest:
    """
    Follow a trajectory.

    :param goal: None for a trajectory from the topic.
    :param step: whether a first point at time 0 is jumped to.
    """

    prepared: PreparedTrajectory
    stamp_ns: int
    tolerances: SegmentTolerances
    goal: TrajectoryGoal | None = None
    step: bool = False


@dataclass(frozen=True, slots=True)
class CancelRequest:
    """Cancel a goal; None cancels whatever is active."""

    goal: TrajectoryGoal | None


@dataclass(frozen=True, slots=True)
class StopRequest:
    """Stop and cancel what is active; a goal that asked for it has succeeded then."""

    goal: TrajectoryGoal | None


@dataclass(frozen=True, slots=True)
class ScalingRequest:
    """Change the pace of trajectories."""

    factor: float


@dataclass(frozen=True, slots=True, eq=False)
class ParameterRequest:
    """Work with new parameters from now on."""

    parameters: JointTrajectoryControllerParameters


Request = StartRequest | CancelRequest | StopRequest | ScalingRequest | ParameterRequest
