# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Watches an executing trajectory: the rest of its path, and the states it passes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rclpy.task import Future

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.trajectory import JointTrajectory

#: A joint of another robot that has moved this far triggers a new check [rad or m].
MOVED = 0.03


class PathWatch:
    """
    Checks the rest of a trajectory for collisions in the monitored scene.

    As in MoveIt, links are not padded, path constraints are not checked, and the goal's own
    changes of the scene count.

    :param context: the parts of move_group.
    :param trajectory: that is being executed.
    :param group: planning group that it moves.
    :param overlaid: returns a scene with the goal's scene difference.
    """

    def __init__(
        self, context: Context, trajectory: JointTrajectory, group: str,
        overlaid: Callable[[PlanningScene], PlanningScene],
    ) -> None:
        self._context = context
        self._trajectory = trajectory
        self._group = group
        self._overlaid = overlaid
        joints = set(trajectory.joint_names)
        self._others = sorted(
            name for robot in context.robots if not robot & joints for name in robot
        )
        self._seen = self._versions()
        self._checked = self._positions()
        self._pending: Future | None = None

    def invalid(self, elapsed: float) -> str:
        """
        Return why the rest of the path has become invalid, '' while it is valid.

        It never waits: a check that was started is asked for its result the next time.

        :param elapsed: [s] since the start of the trajectory.
        """
        if self._pending is not None:
            if not self._pending.done():
                return ''
            sentence = str(self._pending.result())
            self._pending = None
            if sentence:
                return sentence
        versions, positions = self._versions(), self._positions()
        moved = any(abs(now - old) > MOVED
                    for now, old in zip(positions, self._checked, strict=True))
        if moved or versions != self._seen:
            self._seen, self._checked = versions, positions
            context, scene = self._context, self._context.scene.snapshot()
            self._pending = context.queries.submit(
                lambda: context.query_planner.path_fault(
                    self._trajectory, elapsed, self._overlaid(scene), self._group
                )
            )
        return ''

    def _positions(self) -> list[float]:
        """Return the joint positions of other robots [rad or m]."""
        positions = self._context.states.positions
        return [positions.get(name, 0.0) for name in self._others]

    def _versions(self) -> tuple[int, int]:
        scene = self._context.scene
        return scene.geometry_version, scene.transform_version


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
