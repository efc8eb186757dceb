# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What has to be kept, resolved for a scene: whether a state keeps it, and what it misses by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import nearest, PlanningError
from armsim_ros.log import Log
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import (
    euler_xyz,
    inverse_pose,
    matrix_from_quat_xyzw,
    rotation_vector,
)
from armsim_ros.planning.request import (
    Constraints,
    is_place,
    JointConstraint,
    OrientationConstraint,
    Parameterization,
    PositionConstraint,
    Region,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene

EPSILON = 1e-9
"""What rounding may add [rad or m]."""

Poses = Mapping[str, Matrix]
"""Link -> pose (4, 4) in the model frame, of all links that constraints name."""

@dataclass(frozen=True, slots=True)
class ConstraintResult:
    """
    How a state stands to one constraint.

    :param satisfied: whether it is kept.
    :param distance: how far from the constraint's centre [rad or m], times its weight.
    :param text: the constraint and the values, for messages.
    """

    satisfied: bool
    distance: float
    text: str


@dataclass(frozen=True, slots=True)
class JointTerm:
    """An interval of one joint; ``index`` counts in the robot's state."""

    name: str
    index: int
    target: float
    lower: float
    upper: float
    continuous: bool
    weight: float

    def evaluate(self, q: Vector) -> ConstraintResult:
        """Return how a state stands to this constraint."""
        text = (f"joint '{self.name}' is at {q[self.index]:.4f}, wanted {self.target:.4f} in "
                f'{self.lower:.4f} .. {self.upper:.4f}')
        inside = abs(self.residual(q, 0.0)) <= EPSILON
        return ConstraintResult(inside, self.weight * abs(self.error(q)), text)

    def residual(self, q: Vector, margin: float) -> float:
        """Return by how much a state lies beyond the interval, made smaller by a share."""
        error = self.error(q)
        low, high = (1.0 - margin) * (self.lower - self.target), (1.0 - margin) * (
            self.upper - self.target)
        return error - min(max(error, low), high)

    def error(self, q: Vector) -> float:
        """Return position - target [rad or m], the short way round for a continuous joint."""
        error = float(q[self.index]) - self.target
        return math.remainder(error, 2.0 * math.pi) if self.continuous else error


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A frame fixed to a link: pose of the frame = pose of the link * offset."""

    link: str
    offset: Matrix

    def pose(self, poses: Poses) -> Matrix:
        """Return the pose (4, 4) of the frame where the links have these."""
        pose: Matrix = poses[self.link] @ self.offset
        return pose


@dataclass(frozen=True, slots=True, eq=False)
class PositionTerm:
    """
    A point that has to lie in one of several regions.

    :param target: the point, as the origin of a frame.
    :param frame: the frame of the regions.
    """

    name: str
    target: Frame
    frame: Frame
    regions: tuple[Region, ...]
    weight: float

    def point(self, poses: Poses) -> Vector:
        """Return the point (3,) [m] in the constraint frame."""
        base = inverse_pose(self.frame.pose(poses))
        place: Vector = (base @ poses[self.target.link] @ self.target.offset)[:3, 3]
        return place

    def residual(self, poses: Poses, margin: float) -> Vector:
        """Return the way (3,) [m] to the point from the nearest region, made smaller."""
        point = self.point(poses)
        ways = [region.outside_by(point, margin) for region in self.regions]
        return min(ways, key=lambda way: float(np.linalg.norm(way)))

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """Return how poses of the two links stand to this constraint."""
        point = self.point(poses)
        inside = float(np.abs(self.residual(poses, 0.0)).max()) <= EPSILON
        distance = min(float(np.linalg.norm(point - region.center)) for region in self.regions)
        text = (f"position of '{self.name}' is {distance:.5f} m from the centre of its region"
                + ('' if inside else ' and outside'))
        return ConstraintResult(inside, self.weight * distance, text)


@dataclass(frozen=True, slots=True, eq=False)
class OrientationTerm:
    """
    A link's orientation in a frame.

    :param wanted: (3, 3) in the constraint frame.
    :param tolerances: (3,) [rad] about the constraint frame's axes.
    """

    name: str
    target: Frame
    frame: Frame
    wanted: Matrix
    tolerances: Vector
    rotation_vector: bool
    weight: float

    def error(self, poses: Poses) -> Vector:
        """Return the three angles of the error (3,) [rad]."""
        frame, link = self.frame.pose(poses)[:3, :3], self.target.pose(poses)[:3, :3]
        difference = frame.T @ link @ self.wanted.T
        return rotation_vector(difference) if self.rotation_vector else euler_xyz(difference)

    def residual(self, poses: Poses, margin: float) -> Vector:
        """Return by how much each angle (3,) [rad] is beyond its tolerance, made smaller."""
        error, allowed = self.error(poses), (1.0 - margin) * self.tolerances
        beyond: Vector = error - np.clip(error, -allowed, allowed)
        return beyond

    def evaluate(self, poses: Poses) -> ConstraintResult:
        """Return how poses of the two links stand to this constraint."""
        error = self.error(poses)
        inside = bool(np.all(np.abs(error) <= self.tolerances + EPSILON))
        text = (f"orientation of '{self.name}' is off by {np.round(error, 4).tolist()} rad, "
                f'allowed {np.round(self.tolerances, 4).tolist()}')
        return ConstraintResult(inside, self.weight * float(np.linalg.norm(error)), text)


class ConstraintSet:
    """
    Constraints made ready for one scene; what cannot be used is dropped and said.

    :param constraints: all of them have to hold.
    :param scene: knows frames, links and joints.
    :param log: hears warnings about values that are not usable as given.
    """

    def __init__(self, constraints: Constraints, scene: PlanningScene, log: Log) -> None:
        self._model = scene.kinematic_model
        self._scene = scene
        self._log = log
        #: Why constraints were left out.
        self.dropped: list[str] = []
        self.joints: list[JointTerm] = []
        self.positions: list[PositionTerm] = []
        self.orientations: list[OrientationTerm] = []
        for joint in constraints.joint_constraints:
            self._add_joint(joint)
        for position in constraints.position_constraints:
            self._add_position(position)
        for orientation in constraints.orientation_constraints:
            self._add_orientation(orientation)
        for _ in constraints.visibility_constraints:
            self._drop('visibility constraints are not supported; use a position and an '
                       'orientation constraint of the sensor link')
        self._pose_terms: list[PositionTerm | OrientationTerm] = [
            *self.positions, *self.orientations
        ]
        self._links = tuple(dict.fromkeys(
            link for term in self._pose_terms for link in (term.target.link, term.frame.link)
        ))

    @property
    def empty(self) -> bool:
        """Whether nothing is left to keep."""
        return not (self.joints or self.positions or self.orientations)

    def evaluate(self, q: Vector) -> list[ConstraintResult]:
        """
        Return one result a constraint: joints, positions, orientations.

        :param q: (n,) full robot state.
        """
        poses = self.poses(q)
        return [
            *(term.evaluate(q) for term in self.joints),
            *(term.evaluate(poses) for term in self._pose_terms),
        ]

    def satisfied(self, q: Vector) -> bool:
        """Return whether a full robot state (n,) keeps all of them."""
        return float(np.max(np.abs(self.residual(q)), initial=0.0)) <= EPSILON

    def residual(self, q: Vector, margin: float = 0.0) -> Vector:
        """
        Return by how much a full robot state (n,) breaks each part of the constraints.

        :param margin: share 0..1 by which all tolerances are taken smaller.
        :returns: zeros where the state keeps them [rad or m].
        """
        poses = self.poses(q)
        joints = np.array([term.residual(q, margin) for term in self.joints])
        return np.concatenate([
            joints, *(term.residual(poses, margin) for term in self._pose_terms)])

    def violation(self, q: Vector) -> str:
        """Return the first constraint that a state (n,) breaks, as a phrase, or ''."""
        return next((each.text for each in self.evaluate(q) if not each.satisfied), '')

    def poses(self, q: Vector) -> Poses:
        """Return the pose of every link that is needed."""
        if not self._links:
            return {}
        return dict(zip(self._links, self._model.link_poses(q, self._links), strict=True))

    def _drop(self, reason: str) -> None:
        self.dropped.append(reason)
        self._log.error(f'constraint ignored: {reason}')

    def _add_joint(self, given: JointConstraint) -> None:
        joint = self._model.robot.joints.get(given.joint_name)
        if joint is None or not joint.movable:
            known = self._model.robot.active_joints
            self._drop(f"joint '{given.joint_name}' is not a joint of '{self._model.robot.name}' "
                       f'that moves; {nearest(given.joint_name, known) or ", ".join(known)}')
            return
        if not math.isfinite(given.position) or not (
            given.tolerance_above >= 0.0 and given.tolerance_below >= 0.0
        ):
            self._drop(f"joint '{given.joint_name}': position {given.position:g} and tolerances "
                       f'+{given.tolerance_above:g} -{given.tolerance_below:g} have to be finite '
                       'and tolerances not negative')
            return
        index = self._model.index(given.joint_name)
        low, high = float(self._model.lower[index]), float(self._model.upper[index])
        continuous = joint.type is JointType.CONTINUOUS
        target = given.position
        if continuous:
            target = math.remainder(target, 2.0 * math.pi)
            low, high = -math.inf, math.inf
        elif not low <= target <= high:
            target = min(max(target, low), high)
            if abs(target - given.position) > 1e-6:
                self._log.warning(
                    f"goal {given.position:.4f} of joint '{given.joint_name}' is outside its "
                    f'limits {low:.4f} .. {high:.4f}: using {target:.4f}'
                )
        self.joints.append(JointTerm(
            given.joint_name, index, target, max(low, target - given.tolerance_below),
            min(high, target + given.tolerance_above), continuous, _weight(given.weight),
        ))

    def _frame(self, name: str, what: str) -> Frame | None:
        try:
            return Frame(*self._scene.link_of_frame(name))
        except PlanningError as error:
            self._drop(f'{what}: {error}')
            return None

    def _add_position(self, given: PositionConstraint) -> None:
        if not given.frame_id:
            self._drop(f"position of '{given.link_name}': header.frame_id is empty; "
                       f"give e.g. '{self._scene.model_frame}'")
            return
        if not given.link_name or not given.regions:
            self._drop(f"position of '{given.link_name}': a link and at least one region with "
                       'its pose are needed')
            return
        target = self._frame(given.link_name, 'position constraint, link_name')
        frame = self._frame(given.frame_id, 'position constraint, header.frame_id')
        if target is None or frame is None:
            return
        point = np.eye(4)
        point[:3, 3] = given.target_point_offset
        fault = next((each.fault for each in given.regions if each.fault), '')
        if fault or not is_place(point):
            self._drop(f"position of '{given.link_name}': "
                       + (f'a region cannot be used: {fault}' if fault else
                          'target_point_offset is not finite or too large'))
            return
        self.positions.append(PositionTerm(
            given.link_name, Frame(target.link, target.offset @ point), frame, given.regions,
            _weight(given.weight),
        ))

    def _add_orientation(self, given: OrientationConstraint) -> None:
        if not given.link_name:
            self._drop('orientation constraint without link_name')
            return
        target = self._frame(given.link_name, 'orientation constraint, link_name')
        frame = self._frame(given.frame_id, 'orientation constraint, header.frame_id')
        if target is None or frame is None:
            return
        tolerances = np.asarray(given.tolerances, dtype=np.float64)
        if not np.all(tolerances >= 0.0):
            self._drop(f"orientation of '{given.link_name}': tolerances {given.tolerances} have "
                       'to be numbers >= 0')
            return
        quat = np.asarray(given.quat_xyzw, dtype=np.float64)
        if not abs(math.hypot(*quat) - 1.0) <= 1e-3:
            self._log.warning(
                f"orientation of '{given.link_name}': quaternion {given.quat_xyzw} is not of "
                'length 1: using the identity'
            )
            quat = np.array([0.0, 0.0, 0.0, 1.0])
        if given.parameterization not in tuple(Parameterization):
            self._log.warning(
                f"orientation of '{given.link_name}': parameterization {given.parameterization} "
                'is not known: using XYZ_EULER_ANGLES'
            )
        self.orientations.append(OrientationTerm(
            given.link_name, target, frame, matrix_from_quat_xyzw(quat),
            np.where(tolerances >= 3.14, math.inf, tolerances),
            given.parameterization == Parameterization.ROTATION_VECTOR, _weight(given.weight),
        ))


def _weight(weight: float) -> float:
    return weight if weight > 1e-12 else 1.0


def merged(first: Constraints, second: Constraints, log: Log) -> Constraints:
    """
    Return constraints that hold where both do.

    Intervals of the same joint are intersected; a pair without a common value is dropped with
    an error. All others are put together.
    """
    joints: dict[str, JointConstraint] = {}
    dropped: set[str] = set()
    for each in (*first.joint_constraints, *second.joint_constraints):
        if each.joint_name in dropped:
            continue
        before = joints.get(each.joint_name)
        if before is None:
            joints[each.joint_name] = each
            continue
        low = max(before.position - before.tolerance_below, each.position - each.tolerance_below)
        high = min(before.position + before.tolerance_above, each.position + each.tolerance_above)
        if low > high:
            log.error(f"joint '{each.joint_name}': the constraints {before.position:g} and "
                      f'{each.position:g} have no common value within their tolerances: both '
                      'ignored')
            del joints[each.joint_name]
            dropped.add(each.joint_name)
            continue
        position = min(max(before.position, low), high)
        joints[each.joint_name] = JointConstraint(
            each.joint_name, position, high - position, position - low,
            0.5 * (before.weight + each.weight),
        )
    return Constraints(
        tuple(joints.values()),
        first.position_constraints + second.position_constraints,
        first.orientation_constraints + second.orientation_constraints,
        first.visibility_constraints + second.visibility_constraints,
        first.name or second.name,
    )
