# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The rest of a path, checked again when the world changes while the robot moves."""

from __future__ import annotations

from rclpy.task import Future

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.request import MotionPlanRequest
from armsim_ros.trajectory import JointTrajectory


class PathWatch:
    """
    Checks what is left of a trajectory against the monitored scene.

    :param context: the parts of move_group.
    :param trajectory: the one that is being executed.
    :param request: names the group and the path constraints.
    """

    def __init__(
        self, context: Context, trajectory: JointTrajectory, request: MotionPlanRequest
    ) -> None:
        """Take the present world as checked."""
        self._context = context
        self._trajectory = trajectory
        self._request = request
        self._seen = self._versions()
        self._pending: Future | None = None

    def invalid(self, elapsed: float) -> str:
        """
        Return why the rest of the path is not valid any more, '' while it is.

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
        versions = self._versions()
        if versions != self._seen:
            self._seen = versions
            context, scene = self._context, self._context.scene.snapshot()
            self._pending = context.queries.submit(
                lambda: context.query_planner.path_fault(
                    self._trajectory,
                    elapsed,
                    scene,
                    self._request.group_name,
                    self._request.path_constraints,
                )
            )
        return ''

    def _versions(self) -> tuple[int, int]:
        scene = self._context.scene
        return scene.geometry_version, scene.transform_version
