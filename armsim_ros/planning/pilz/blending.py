# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two motions joined within a sphere around the point where they meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.joint_sampling import JointSampler
from armsim_ros.quintic_motion import QuinticMotion

SOURCE = 'blend'
_SAME = 1e-4
"""Largest difference of states [rad or m, and per s], and of sampling times [s]."""


class Blender:
    """
    Blends motions of a group.

    :param context: the robot and its solvers.
    :param validity: of the group.
    :param tip: the tip of the group's solver.
    """

    def __init__(self, context: PlanningContext, validity: StateValidity, tip: str) -> None:
        self._model = context.model
        self._validity = validity
        self._tip = tip
        self._sampler = JointSampler(
            context, validity, Frame(tip, np.eye(4)), SOURCE, validity.poll)

    def poses(self, motion: QuinticMotion) -> Matrix:
        """Return where the tip is at every point of a motion (k, 4, 4)."""
        return np.array([
            self._model.link_pose(self._validity.full(values), self._tip)
            for values in motion.positions])

    def blended(
        self, first: QuinticMotion, second: QuinticMotion, radius: float
    ) -> tuple[QuinticMotion, QuinticMotion, QuinticMotion]:
        """
        Return what is left of the first motion, the blend, and what is left of the second.

        The tip leaves the first motion where it enters the sphere and joins the second where it
        leaves the sphere; between, its poses change between both motions by a polynomial of degree
        five. Times of blend and rest count from the end of the part before.

        :param radius: of the sphere [m].
        :raises PlanningError: FAILURE where the motions cannot be blended; NO_IK_SOLUTION or
            PLANNING_FAILED where the joints cannot follow.
        """
        step = _sampling_time(first, second)
        _check_meeting(first, second)
        ways = self.poses(first), self.poses(second)
        meeting = ways[0][-1, :3, 3]
        near = [np.linalg.norm(way[:, :3, 3] - meeting, axis=1) for way in ways]
        enters = _crossing(near[0][::-1], radius, 'first')
        enter = len(near[0]) - 1 - enters
        leave = _crossing(near[1], radius, 'second')
        align = len(near[0]) - leave - 1 if enters > leave else enter
        count = leave + align - enter + 1
        poses = []
        for k in range(count):
            a = ways[0][min(enter + k, len(ways[0]) - 1)]
            b = ways[1][max(enter + k - align, 0)]
            poses.append((step * (k + 1), _between(a, b, (k + 1) / count)))
        blend = self._sampler.followed(
            poses, first.positions[enter - 1], first.velocities[enter - 1], step)
        rest = second.part(leave + 1)
        return first.part(0, enter), blend, QuinticMotion(
            rest.times - rest.times[0] + step, rest.positions, rest.velocities,
            rest.accelerations)


def _sampling_time(first: QuinticMotion, second: QuinticMotion) -> float:
    """Return the time [s] between the points of both motions but their last ones."""
    intervals: list[Vector] = [np.diff(motion.times)[:-1] for motion in (first, second)]
    every: NDArray[np.float64] = np.concatenate(intervals)
    if not len(every):
        raise _error('both motions have too few points')
    if np.abs(every - every[0]).max() > _SAME:
        raise _error('the motions are not sampled at the same even times; blend motions of PTP, '
                     'LIN and CIRC')
    return float(every[0])


def meet(first: QuinticMotion, second: QuinticMotion) -> bool:
    """Return whether a motion ends in the state in which another starts."""
    return all(
        float(np.linalg.norm(a[-1] - b[0])) <= _SAME for a, b in (
            (first.positions, second.positions), (first.velocities, second.velocities),
            (first.accelerations, second.accelerations)))


def _check_meeting(first: QuinticMotion, second: QuinticMotion) -> None:
    if not meet(first, second):
        raise _error('the second motion does not start where the first one ends')
    if any(float(np.linalg.norm(each)) > _SAME
           for each in (first.velocities[-1], first.accelerations[-1])):
        raise _error('the motions do not rest where they meet')


def _crossing(near: Vector, radius: float, which: str) -> int:
    """Return the last point before the distances (k,) from the meeting point pass the radius."""
    crossing = np.flatnonzero((near[:-1] <= radius) & (near[1:] >= radius))
    if not len(crossing):
        raise _error(f'the {which} motion lies within the blend radius {radius:g} m of the point '
                     'where both meet; give a smaller blend_radius')
    return int(crossing[0])


def _between(first: Matrix, second: Matrix, share: float) -> Matrix:
    """Return the pose (4, 4) between two, by a polynomial of a share 0..1."""
    weight = 6.0 * share**5 - 15.0 * share**4 + 10.0 * share**3
    pose = np.eye(4)
    pose[:3, 3] = first[:3, 3] + weight * (second[:3, 3] - first[:3, 3])
    turn = pin.log3(first[:3, :3].T @ second[:3, :3])
    pose[:3, :3] = first[:3, :3] @ pin.exp3(weight * turn)
    return pose


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.FAILURE, f'blending failed: {text}', SOURCE)
