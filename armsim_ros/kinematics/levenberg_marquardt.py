# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Damped least squares with bounds: from a start to a solution of inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import Indices, KinematicModel


@dataclass(frozen=True, slots=True, eq=False)
class PoseTask:
    """
    A pose that a link shall take.

    :param frame: Pinocchio's frame number of the link.
    :param target: ``pin.SE3`` of the link (full pose) or (3,) of the point (position only).
    :param point: (3,) the point in the link's frame, position only.
    """

    frame: int
    target: object
    point: Vector | None = None

    @property
    def rows(self) -> int:
        """Number of equations."""
        return 6 if self.point is None else 3


@dataclass(frozen=True, slots=True, eq=False)
class Convergence:
    """
    When a descent ends.

    :param position: [m] largest error that counts as solved.
    :param orientation: [rad] largest error that counts as solved.
    :param iterations: most evaluations of the Jacobian.
    """

    position: float = 1e-6
    orientation: float = 1e-6
    iterations: int = 100


class LevenbergMarquardt:
    """
    Descend from a start to the nearest configuration that fulfils all tasks.

    The step solves (J^T J + lambda I) dx = J^T e for the variables that are free; a variable
    at its bound that wants beyond it is held for that step (projected Levenberg-Marquardt,
    Kanzow, Yamashita, Fukushima 2004). Errors are logarithms of the pose difference in the
    link's frame.

    :param kinematics: the robot.
    :param group: planning group.
    :param variables: which of its active variables move, counted in the group.
    :param tasks: at least one.
    :param convergence: when it ends.
    :param bounds: (2, n) lower and upper bounds of the robot's state.
    """

    #: Iterations in which the squared error must fall below ``STALL_RATIO`` of what it was;
    #: where another start costs less than patience, and where it matters to end in the basin
    #: of this task.
    STALL_WINDOW, STALL_RATIO = 3, 0.6
    PATIENT_WINDOW, PATIENT_RATIO = 8, 0.8

    def __init__(
        self, kinematics: KinematicModel, group: str, variables: Indices,
        tasks: tuple[PoseTask, ...], convergence: Convergence, bounds: Matrix
    ) -> None:
        self._kinematics = kinematics
        self._indices = kinematics.group_indices(group)[variables]
        self._lower, self._upper = bounds[:, self._indices]
        self._gradient = kinematics.gradient(group)[:, variables]
        self._plain = bool((self._gradient.sum(axis=1) == self._gradient.any(axis=1)).all()
                           and self._gradient.sum() == len(self._indices))
        self._tasks, self._convergence = tasks, convergence
        self._rows = sum(task.rows for task in tasks)
        #: Errors where the last descent ended [m], [rad].
        self.position_error = math.inf
        self.orientation_error = math.inf

    def descend(self, q: Vector, start: Vector, *, patient: bool = False) -> Vector | None:
        """
        Return the full q of a solution, or None.

        A start at the target is the solution even where it is beyond the limits.

        :param q: (n,) state of all other joints.
        :param start: (m,) values of the moving variables to begin with.
        :param patient: give up later, because there is no better start.
        """
        window = self.PATIENT_WINDOW if patient else self.STALL_WINDOW
        ratio = self.PATIENT_RATIO if patient else self.STALL_RATIO
        full = self._full(q, start)
        error, cost = self._evaluate(full)
        if self._solved(error):
            return full
        x = np.minimum(np.maximum(start, self._lower), self._upper)
        if not np.array_equal(x, start):
            full = self._full(q, x)
            error, cost = self._evaluate(full)
        damping = 0.05
        history: list[float] = []
        for _ in range(self._convergence.iterations):
            if self._solved(error):
                return full
            history.append(cost)
            if len(history) > window and cost > ratio * history[-1 - window]:
                return None
            jacobian = self._jacobian(full)
            step = self._better(q, x, jacobian, error, cost, damping)
            if step is None:
                return None
            x, full, error, cost, damping = step
        return full if self._solved(error) else None

    def _better(
        self, q: Vector, x: Vector, jacobian: Matrix, error: Vector, cost: float, damping: float
    ) -> tuple[Vector, Vector, Vector, float, float] | None:
        """Return the next point with its error and damping, or None where nothing is better."""
        gradient = jacobian.T @ error
        normal = jacobian.T @ jacobian
        held = ((x <= self._lower) & (gradient < 0.0)) | ((x >= self._upper) & (gradient > 0.0))
        if held.any():
            if held.all():
                return None
            gradient[held] = 0.0
            normal[held, :] = 0.0
            normal[:, held] = 0.0
        diagonal = np.einsum('ii->i', normal)
        before = diagonal.copy()
        for _ in range(8):
            # The damping shrinks with the error, so that the end converges quadratically.
            diagonal[:] = before + damping * cost + 1e-12
            step = np.linalg.solve(normal, gradient)
            candidate = np.minimum(np.maximum(x + step, self._lower), self._upper)
            full = self._full(q, candidate)
            new_error, new_cost = self._evaluate(full)
            if new_cost < cost:
                return candidate, full, new_error, new_cost, max(damping * 0.8, 1e-6)
            damping = max(damping * 10.0, 1e-3)
        return None

    def _full(self, q: Vector, x: Vector) -> Vector:
        full = q.copy()
        full[self._indices] = x
        return full if self._plain else self._kinematics.apply_mimic(full)

    def _evaluate(self, full: Vector) -> tuple[Vector, float]:
        model, data = self._kinematics.model, self._kinematics.data
        pin.forwardKinematics(model, data, full)
        if len(self._tasks) == 1:
            error = _task_error(model, data, self._tasks[0])
        else:
            error = np.concatenate([_task_error(model, data, task) for task in self._tasks])
        return error, float(error @ error)

    def _jacobian(self, full: Vector) -> Matrix:
        model, data = self._kinematics.model, self._kinematics.data
        pin.computeJointJacobians(model, data, full)
        parts = [_task_jacobian(model, data, task) for task in self._tasks]
        stacked = parts[0] if len(parts) == 1 else np.vstack(parts)
        if self._plain:
            selected: Matrix = stacked[:, self._indices]
            return selected
        projected: Matrix = stacked @ self._gradient
        return projected

    def _solved(self, error: Vector) -> bool:
        at, position, orientation = 0, 0.0, 0.0
        for task in self._tasks:
            part = error[at : at + 3]
            position = max(position, math.sqrt(float(part @ part)))
            if task.point is None:
                part = error[at + 3 : at + 6]
                orientation = max(orientation, math.sqrt(float(part @ part)))
            at += task.rows
        self.position_error, self.orientation_error = position, orientation
        limit = self._convergence
        return position <= limit.position and orientation <= limit.orientation


def _task_error(model: object, data: object, task: PoseTask) -> Vector:
    placement = pin.updateFramePlacement(model, data, task.frame)
    if task.point is None:
        twist: Vector = pin.log6(placement.actInv(task.target)).vector
        return twist
    difference: Vector = task.target - placement.act(task.point)
    return difference


def _task_jacobian(model: object, data: object, task: PoseTask) -> Matrix:
    if task.point is None:
        local: Matrix = pin.getFrameJacobian(model, data, task.frame, pin.ReferenceFrame.LOCAL)
        return local
    aligned: Matrix = pin.getFrameJacobian(
        model, data, task.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    placement = pin.updateFramePlacement(model, data, task.frame)
    arm = placement.rotation @ task.point
    moved: Matrix = aligned[:3] - pin.skew(arm) @ aligned[3:]
    return moved
