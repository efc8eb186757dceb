# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What was measured during a motion: ``executed_trajectory``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.trajectory import JointTrajectory


class TrajectoryMonitor:
    """
    Records positions while it is entered, with the times at which they were measured.

    :param robot: whose active joints are recorded; one that is not measured is at its default.
    :param frequency: states per second of their stamps at most [Hz]; 0 for none.
    """

    def __init__(self, states: StateMonitor, robot: RobotModel, frequency: float) -> None:
        self._states, self._robot, self._frequency = states, robot, frequency
        self._times: list[int] = []
        self._rows: list[list[float]] = []

    def __enter__(self) -> TrajectoryMonitor:
        """Begin to record."""
        if self._frequency > 0.0:
            self._states.recorders.append(self._record)
        return self

    def __exit__(self, *_: object) -> None:
        """Record no more."""
        if self._frequency > 0.0:
            self._states.recorders.remove(self._record)

    def _record(self, time_ns: int, positions: Mapping[str, float]) -> None:
        if self._times and time_ns - self._times[-1] < 1e9 / self._frequency:
            return
        self._times.append(time_ns)
        self._rows.append([positions.get(name, self._robot.default_position(name))
                           for name in self._robot.active_joints])

    @property
    def trajectory(self) -> JointTrajectory:
        """What was recorded, from time 0; without joints where that is nothing."""
        if not self._times:
            return JointTrajectory(())
        times = (np.array(self._times) - self._times[0]) * 1e-9
        return JointTrajectory(tuple(self._robot.active_joints), times, np.array(self._rows))
