# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rules of trajectory execution: what may start, how long it may take, when it is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import MultiDofTrajectory
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'

DEFAULT_START_TOLERANCE = 0.01
"""Of trajectory_execution_manager.cpp [rad or m]."""

STATES_AT_REST = 3
"""How many joint states in a row have to be without motion since the state before."""


def check_points(trajectory: JointTrajectory) -> None:
    """
    Refuse a trajectory whose points do not fit its joint names.

    :raises PlanningError: CONTROL_FAILED with the point and what is wrong with it.
    """
    fault = trajectory.fault
    if len(set(trajectory.joint_names)) != len(trajectory.joint_names):
        fault = f'a joint is named twice: {", ".join(trajectory.joint_names)}'
    if fault:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED, f'the trajectory cannot be executed: {fault}', _SOURCE)


@dataclass(frozen=True, slots=True)
class Tolerances:
    """
    How far a joint may be from the first point of a trajectory.

    :param common: of joints without a tolerance of their own [rad or m].
    :param joints: joint -> its own tolerance [rad or m].
    """

    common: float
    joints: Mapping[str, float] = field(default_factory=dict)

    @property
    def unchecked(self) -> bool:
        """Whether no start is checked: 0, and no joint has a tolerance of its own."""
        return self.common == 0.0 and not self.joints

    def of(self, joint: str) -> float:
        """Return the tolerance of a joint [rad or m]; with 0 its start is not checked."""
        return self.joints.get(joint, self.common)

    def checked(self) -> Tolerances:
        """Return tolerances that check every start: MoveIt's default in place of 0."""
        return Tolerances(
            self.common or DEFAULT_START_TOLERANCE,
            {name: own or DEFAULT_START_TOLERANCE for name, own in self.joints.items()})


def check_start(
    trajectory: JointTrajectory, measured: Mapping[str, float], robot: RobotModel,
    tolerances: Tolerances
) -> None:
    """
    Refuse a trajectory that begins away from where the robot is.

    Positions outside the bounds of a joint are compared as if they were at the bound.

    :param measured: joint -> position [rad or m]; a joint that is not there is at its default.
    :raises PlanningError: CONTROL_FAILED with joint, expected and actual position.
    """
    if tolerances.unchecked or not len(trajectory):
        return
    if np.isnan(trajectory.positions[0]).any():
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the first point has no positions for {len(trajectory.joint_names)} joints', _SOURCE)
    for name, expected in zip(trajectory.joint_names, trajectory.positions[0], strict=True):
        joint, allowed = robot.joints.get(name), tolerances.of(name)
        if joint is None or allowed == 0.0:
            continue
        actual = measured.get(name, robot.default_position(name))
        off = abs(_distance(joint, float(expected), actual))
        if off > allowed:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"Invalid Trajectory: start point deviates from current robot state: joint "
                f"'{name}' expected {float(expected):.5f}, is {actual:.5f}, off by "
                f'{off:.5f}, allowed {allowed:g}; plan again from the current state, or '
                'raise trajectory_execution.allowed_start_tolerance', _SOURCE)


def _distance(joint: Joint, first: float, second: float) -> float:
    """Return how far apart two positions of a joint are, both within its bounds [rad or m]."""
    if joint.type is JointType.CONTINUOUS:
        return math.remainder(first - second, 2.0 * math.pi)
    lower, upper = joint.limits.lower, joint.limits.upper
    return min(max(first, lower), upper) - min(max(second, lower), upper)


def continues(first: JointTrajectory, second: JointTrajectory, tolerance: float) -> bool:
    """
    Return whether a trajectory begins where another ends, for the joints of both.

    :param tolerance: largest distance [rad or m].
    """
    ends = dict(zip(first.joint_names, first.positions[-1], strict=True))
    begins = zip(second.joint_names, second.positions[0], strict=True)
    return all(abs(ends[name] - begin) <= tolerance for name, begin in begins if name in ends)


def unwound(
    trajectory: JointTrajectory, measured: Mapping[str, float], robot: RobotModel
) -> JointTrajectory:
    """
    Return the trajectory with continuous joints free of jumps, from where they are.

    :param measured: joint -> position [rad or m]; the first point lies within half a turn of it.
    """
    turning = [
        k for k, name in enumerate(trajectory.joint_names)
        if name in robot.joints and robot.joints[name].type is JointType.CONTINUOUS]
    if not turning or not len(trajectory):
        return trajectory
    positions = trajectory.positions.copy()
    for k in turning:
        last = measured.get(trajectory.joint_names[k], float(positions[0, k]))
        for row in positions:
            if not math.isnan(row[k]):
                last = row[k] = last + math.remainder(float(row[k] - last), 2.0 * math.pi)
    return replace(trajectory, positions=positions)


def begin(trajectory: JointTrajectory | MultiDofTrajectory, now_ns: int) -> float:
    """Return how far ahead the start of a trajectory is by its header [s], 0 where it is not."""
    return max(trajectory.stamp_ns - now_ns, 0) * 1e-9 if trajectory.stamp_ns else 0.0


def allowed_duration(
    trajectory: JointTrajectory | MultiDofTrajectory, scaling: float, margin: float,
    now_ns: int = 0
) -> float:
    """
    Return how long the execution may take from now on [s].

    :param scaling: factor of the trajectory's own duration and of the wait for its start.
    :param margin: added to it [s].
    :param now_ns: what a stamp in the header is ahead of [ns].
    """
    return (begin(trajectory, now_ns) + trajectory.duration) * scaling + margin


def settled(
    states: Sequence[Mapping[str, float]], joint_names: Sequence[str], robot: RobotModel,
    tolerances: Tolerances
) -> bool:
    """
    Return whether joints rest: from state to state each moves by its tolerance at most.

    :param states: joint -> position [rad or m], the newest last.
    :param joint_names: those of the trajectory.
    """
    recent = states[-STATES_AT_REST - 1:]
    return len(recent) > STATES_AT_REST and all(
        abs(_distance(robot.joints[name], after[name], before[name])) <= tolerances.of(name)
        for before, after in pairwise(recent) for name in joint_names
        if name in before and name in after)


STEP = 0.05
"""No joint moves farther between two looked-at states [rad or m]."""
MOST_STATES, MOST_OBSTRUCTION_STATES = 80, 1000
"""More than so many states of a motion are not checked against another, against the scene."""


def meeting(
    checker: CollisionChecker, q: Vector, first: JointTrajectory, second: JointTrajectory,
) -> Contact | None:
    """
    Return a contact between what two motions sweep, None where there is none.

    Each state of the first is checked with each of the second, independent of timing.

    :param checker: in the scene of both motions.
    :param q: (n,) the robot; joints that neither motion has stay as they are.
    :param first: positions of each point.
    :param second: of other joints than the first.
    """
    model = checker.scene.kinematic_model
    moved = [_moved_links(model, motion.joint_names) for motion in (first, second)]
    for state in _states(model, q, first):
        for both in _states(model, state, second):
            if not checker.in_collision(both):
                continue
            for contact in checker.contacts(both):
                links = [_link(checker, name) for name in (contact.body1, contact.body2)]
                if any(links[i] in moved[0] and links[1 - i] in moved[1] for i in (0, 1)):
                    return contact
    return None


def obstruction(checker: CollisionChecker, q: Vector, motion: JointTrajectory) -> Contact | None:
    """
    Return a contact of what a motion moves, None where there is none.

    :param checker: in the scene of the motion.
    :param q: (n,) the robot; joints that the motion lacks stay as they are.
    """
    moved = _moved_links(checker.scene.kinematic_model, motion.joint_names)
    for state in _states(checker.scene.kinematic_model, q, motion, MOST_OBSTRUCTION_STATES):
        if not checker.in_collision(state):
            continue
        for contact in checker.contacts(state):
            if moved.intersection(_link(checker, name) for name in (contact.body1, contact.body2)):
                return contact
    return None


def _states(
    model: KinematicModel, q: Vector, motion: JointTrajectory, most: int = MOST_STATES
) -> list[Vector]:
    """Return robot states (n,) along a motion, no more than so many."""
    known = [k for k, name in enumerate(motion.joint_names) if name in model.names]
    places = [model.index(motion.joint_names[k]) for k in known]
    states = []
    given = motion.positions[~np.isnan(motion.positions).any(axis=1)]
    for values in _refined(given[:, known], most):
        state = q.copy()
        state[places] = values
        states.append(model.apply_mimic(state))
    return states


def _refined(positions: Matrix, most: int) -> Matrix:
    """Return positions (k, m) on straight lines through those given, a step apart if not more."""
    parts = [positions[:1]]
    for before, after in pairwise(positions):
        count = max(1, math.ceil(float(np.abs(after - before).max(initial=0.0)) / STEP))
        shares = np.arange(1, count + 1)[:, None] / count
        parts.append(before + shares * (after - before))
    all_of_them = np.concatenate(parts)
    chosen = np.linspace(0, len(all_of_them) - 1, min(len(all_of_them), most))
    refined: Matrix = all_of_them[np.unique(np.round(chosen).astype(int))]
    return refined


def _moved_links(model: KinematicModel, joints: Sequence[str]) -> frozenset[str]:
    """Return the links that joints move: those below them."""
    moved: set[str] = set()
    for name, joint in model.robot.joints.items():
        if name in joints or joint.parent in moved:
            moved.add(joint.child)
    return frozenset(moved)


def _link(checker: CollisionChecker, body: str) -> str:
    """Return the link that a body is or that carries it."""
    carried = checker.scene.attached.get(body)
    return body if carried is None else carried.link_name
