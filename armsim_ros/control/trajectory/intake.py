# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The border between the senders of trajectories and the control loop.

Everything here runs in the sender's thread: checks, sorting, polynomials. What comes out is a
request that the control loop takes up at the start of an update. In the manner of ROS 1 an empty
trajectory is the request to stop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.hardware_interface import JointProperties
from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.control.trajectory.goal import (
    RefusedTrajectoryError,
    StartRequest,
    StopRequest,
    TrajectoryGoal,
)
from armsim_ros.control.trajectory.sampling import PreparedTrajectory
from armsim_ros.control.trajectory.tolerances import JointTolerance, SegmentTolerances
from armsim_ros.control.trajectory.validation import beyond_limits, start_of, validate
from armsim_ros.trajectory import JointTrajectory


class TrajectoryIntake:
    """
    Turns trajectories into requests.

    :param properties: types and limits of the controller's joints.
    :param snapshot: gives the newest state of the controller.
    """

    def __init__(
        self, properties: JointProperties, snapshot: Callable[[], ControllerSnapshot | None]
    ) -> None:
        self._properties = properties
        self._snapshot = snapshot

    def topic(
        self,
        trajectory: JointTrajectory,
        parameters: JointTrajectoryControllerParameters,
        now_ns: int,
    ) -> tuple[StartRequest | StopRequest, str]:
        """
        Return the request for a trajectory from the topic, and which limit it exceeds.

        The tolerances are those of the parameters.

        :raises RefusedTrajectoryError: the trajectory is not taken.
        """
        if parameters.compat == 'ros1' and not len(trajectory):
            return StopRequest(None), ''
        tolerances = SegmentTolerances.of(parameters)
        return self._request(trajectory, parameters, now_ns, tolerances, None)

    def goal(
        self,
        trajectory: JointTrajectory,
        path: Sequence[JointTolerance],
        goal: Sequence[JointTolerance],
        goal_time: float,
        parameters: JointTrajectoryControllerParameters,
        now_ns: int,
    ) -> tuple[StartRequest | StopRequest, TrajectoryGoal, list[str]]:
        """
        Return the request for a goal, the goal, and warnings: tolerances, limits.

        :raises RefusedTrajectoryError: the trajectory is not taken.
        """
        defaults = SegmentTolerances.of(parameters)
        tolerances, complaint = defaults.overridden(parameters.joints, path, goal, goal_time)
        warnings = [f"the goal's tolerances are replaced by the defaults: {complaint}"]
        warnings = warnings if complaint else []
        accepted = TrajectoryGoal(trajectory, tolerances)
        if (
            parameters.compat == 'ros1'
            and not len(trajectory)
            and set(trajectory.joint_names) == set(parameters.joints)
        ):
            return StopRequest(accepted), accepted, warnings
        request, beyond = self._request(trajectory, parameters, now_ns, tolerances, accepted)
        return request, accepted, [*warnings, *([beyond] if beyond else [])]

    def _request(
        self,
        trajectory: JointTrajectory,
        parameters: JointTrajectoryControllerParameters,
        now_ns: int,
        tolerances: SegmentTolerances,
        goal: TrajectoryGoal | None,
    ) -> tuple[StartRequest, str]:
        waypoints = validate(trajectory, parameters, now_ns)
        beyond, start = beyond_limits(waypoints, self._properties), None
        snapshot = self._snapshot()
        if trajectory.stamp_ns <= now_ns and snapshot is not None:
            elapsed = (now_ns - trajectory.stamp_ns) * 1e-9 if trajectory.stamp_ns else 0.0
            reference = np.stack((snapshot.reference.positions, snapshot.reference.velocities))
            start, far = start_of(
                waypoints, elapsed, reference, snapshot.feedback.positions, self._properties)
            beyond = beyond or far
        if beyond and parameters.reject_beyond_limits:
            raise RefusedTrajectoryError(f'{beyond}; reject_beyond_limits is true')
        prepared = PreparedTrajectory(
            waypoints,
            self._properties.continuous,
            splines=parameters.interpolation_method == 'splines',
            effort='effort' in parameters.command_interfaces,
            rest_at_end='position' in parameters.command_interfaces,
        )
        return StartRequest(prepared, trajectory.stamp_ns, tolerances, goal, start), beyond
