# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What was measured during a motion: ``executed_trajectory``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.trajectory import JointTrajectory


class TrajectoryMonitor:
    """
    Records positions while it is entered, with the times at which they were measured.

    :param joint_names: the joints to record.
    :param frequency: states per second of their stamps at most [Hz]; 0 for none.
    """

    def __init__(
        self, states: StateMonitor, joint_names: Sequence[str], frequency: float
    ) -> None:
        self._states, self._joint_names = states, tuple(joint_names)
        self._frequency = frequency
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
        if any(name not in positions for name in self._joint_names):
            return
        if self._times and time_ns - self._times[-1] < 1e9 / self._frequency:
            return
        self._times.append(time_ns)
        self._rows.append([positions[name] for name in self._joint_names])

    @property
    def trajectory(self) -> JointTrajectory:
        """What was recorded, from time 0; without joints where that is nothing."""
        if not self._times:
            return JointTrajectory(())
        times = (np.array(self._times) - self._times[0]) * 1e-9
        return JointTrajectory(self._joint_names, times, np.array(self._rows))
