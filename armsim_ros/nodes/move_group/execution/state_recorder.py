# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The states that a robot goes through while it executes (``executed_trajectory``)."""

from __future__ import annotations

import numpy as np

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.trajectory import JointTrajectory


class StateRecorder:
    """
    Records measured positions at a limited rate.

    :param context: has the frequency and the states.
    :param joint_names: the joints to note.
    """

    def __init__(self, context: Context, joint_names: tuple[str, ...]) -> None:
        self._states = context.states
        self._frequency = context.record_frequency
        self._joint_names = joint_names
        self._times: list[float] = []
        self._rows: list[list[float]] = []

    def note(self, elapsed: float) -> None:
        """
        Record the newest state if a record is due.

        :param elapsed: [s] since the start.
        """
        positions = self._states.positions
        if self._frequency <= 0.0 or any(name not in positions for name in self._joint_names):
            return
        if self._times and elapsed - self._times[-1] < 1.0 / self._frequency:
            return
        self._times.append(max(elapsed, 0.0))
        self._rows.append([positions[name] for name in self._joint_names])

    @property
    def trajectory(self) -> JointTrajectory:
        """What was noted; without joints where that is nothing."""
        if not self._times:
            return JointTrajectory(())
        return JointTrajectory(self._joint_names, np.array(self._times), np.array(self._rows))
