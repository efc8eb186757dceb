# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A frame of a link taken along a curve, from one joint state to the next."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.inverse import IKResult, IKTarget
from armsim_ros.model.transforms import rotation_angle, skew
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints.terms import Frame
from armsim_ros.planning.context import PlanningContext

_DAMPING = 1e-6


class CurveFollower:
    """
    Inverse kinematics that stays in the basin of the state before.

    :param context: the robot and its solvers.
    :param validity: of the group that moves.
    :param frame: what follows the curve, a frame fixed to a link of the group.
    """

    def __init__(
        self, context: PlanningContext, validity: StateValidity, frame: Frame
    ) -> None:
        self.frame = frame
        #: Whether orientations are left free.
        self.position_only = validity.group in context.settings.position_only_ik
        self._validity = validity
        self._model = context.model
        self._inverse = context.inverse(validity.group)

    def pose(self, values: Vector) -> Matrix:
        """Return where the frame is, (4, 4), for the group's values (m,)."""
        link = self._model.link_pose(self._validity.full(values), self.frame.link)
        pose: Matrix = link @ self.frame.offset
        return pose

    def solve(self, pose: Matrix, *starts: Vector) -> tuple[Vector | None, IKResult]:
        """
        Return the state (m,) with the frame at a pose (4, 4), None where there is none nearby.

        :param starts: (m,) states to start from, the first one first.
        """
        target = IKTarget(self.frame.link, pose, self.frame.offset, self.position_only)
        for start in starts:
            result = self._inverse.solve([target], self._validity.full(start), max_starts=0)
            if result.q is not None:
                return self._model.extract(result.q, self._validity.group), result
        return None, result

    def distance(self, values: Vector, pose: Matrix) -> tuple[float, float]:
        """Return how far the frame is from a pose (4, 4): [m] and [rad], 0 where it is free."""
        here = self.pose(values)
        turn = 0.0 if self.position_only else rotation_angle(here, pose)
        return float(np.linalg.norm(here[:3, 3] - pose[:3, 3])), turn

    def slope(self, values: Vector, twist: Vector) -> Vector:
        """
        Return how the joints (m,) move with the place on a curve.

        :param twist: (6,) linear and angular velocity of the frame over the place.
        """
        q = self._validity.full(values)
        jacobian = self._model.jacobian(q, self.frame.link, self._validity.group)
        arm = self._model.link_pose(q, self.frame.link)[:3, :3] @ self.frame.offset[:3, 3]
        jacobian[:3] -= skew(arm) @ jacobian[3:]
        rows = 3 if self.position_only else 6
        used = jacobian[:rows]
        square = used @ used.T + _DAMPING * np.eye(rows)
        slope: Vector = used.T @ np.linalg.solve(square, twist[:rows])
        return slope
