# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Constraints, resolved for a scene: whether a state satisfies them, and by how much it misses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
import math
import sys

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import nearest, PlanningError
from armsim_ros.log import Log
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import matrix_from_quat_xyzw
from armsim_ros.planning.constraint_terms import (
    ConstraintResult,
    enabled,
    EPSILON,
    FixedTerm,
    Frame,
    JointTerm,
    link_shapes,
    OrientationTerm,
    Poses,
    PositionTerm,
    VisibilityTerm,
)
from armsim_ros.planning.request import (
    Constraints,
    is_place,
    JointConstraint,
    OrientationConstraint,
    Parameterization,
    PositionConstraint,
    VisibilityConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene

Term = JointTerm | PositionTerm | OrientationTerm | VisibilityTerm | FixedTerm

_FREE = 3.14  # [rad] from which on a tolerance leaves its axis free


class ConstraintSet:
    """
    Constraints of a request in a scene.

    As in MoveIt, a constraint that cannot be used (an unknown link, a negative tolerance of a
    joint, no region) counts as satisfied, with a warning. A constraint with a number that is
    not finite is never satisfied.

    :param constraints: all of them have to be satisfied.
    :param scene: knows frames, links and joints.
    :param log: gets the warnings.
    """

    def __init__(self, constraints: Constraints, scene: PlanningScene, log: Log) -> None:
        self._model = scene.kinematic_model
        self._scene, self._log = scene, log
        #: Why constraints cannot be used.
        self.unusable: list[str] = []
        terms: list[Term] = [
            *map(self._joint, constraints.joint_constraints),
            *map(self._position, constraints.position_constraints),
            *map(self._orientation, constraints.orientation_constraints),
            *map(self._visibility, constraints.visibility_constraints)]
        self._terms = terms
        self.joints = [term for term in terms if isinstance(term, JointTerm)]
        self.positions = [term for term in terms if isinstance(term, PositionTerm)]
        self.orientations = [term for term in terms if isinstance(term, OrientationTerm)]
        self._pose_terms: list[PositionTerm | OrientationTerm] = [
            *self.positions, *self.orientations
        ]
        #: States cannot be led towards these: they are only accepted or refused.
        self._visibilities = [term for term in terms if isinstance(term, VisibilityTerm)]
        #: A term for each joint: the values that all its constraints allow.
        self.intervals = self._intervals()
        fixed = [term for term in terms if isinstance(term, FixedTerm)]
        fixed += map(self._contradiction, filter(JointTerm.is_empty, self.intervals))
        self._fixed = np.concatenate([np.empty(0), *(term.residual() for term in fixed)])
        self._links = tuple(dict.fromkeys(
            link for term in self._pose_terms for link in (term.target.link, term.frame.link)))
        self._links_in_view = tuple(dict.fromkeys(
            link for term in self._visibilities for link in term.links))

    @property
    def empty(self) -> bool:
        """Whether every state satisfies them, as none can be evaluated."""
        return not (
            self.joints or self._pose_terms or self._visibilities or len(self._fixed))

    @property
    def satisfiable(self) -> bool:
        """Whether no constraint is violated in every state."""
        return not len(self._fixed)

    def evaluate(self, q: Vector) -> list[ConstraintResult]:
        """
        Return a result for each constraint: joints, positions, orientations, visibilities.

        :param q: (n,) full robot state.
        """
        poses = {**self.poses(q), **self._poses(q, self._links_in_view)}
        return [
            term.evaluate(q) if isinstance(term, JointTerm)
            else term.result if isinstance(term, FixedTerm) else term.evaluate(poses)
            for term in self._terms
        ]

    def satisfied(self, q: Vector) -> bool:
        """Return whether a full robot state (n,) satisfies all of them."""
        if float(np.max(np.abs(self.residual(q)), initial=0.0)) > EPSILON:
            return False
        poses = self._poses(q, self._links_in_view)
        return all(term.evaluate(poses).satisfied for term in self._visibilities)

    def residual(self, q: Vector, margin: float = 0.0) -> Vector:
        """
        Return by how much a full robot state (n,) violates each part of the constraints.

        Visibility is not part of it.

        :param margin: share 0..1 by which all tolerances are made smaller.
        :returns: zeros where the state satisfies them [rad or m].
        """
        poses = self.poses(q)
        joints = np.array([term.residual(q, margin) for term in self.joints])
        return np.concatenate([
            joints, *(term.residual(poses, margin) for term in self._pose_terms), self._fixed])

    def violation(self, q: Vector) -> str:
        """Return the first constraint that a state (n,) violates, as a phrase, or ''."""
        return next((each.text for each in self.evaluate(q) if not each.satisfied), '')

    def poses(self, q: Vector) -> Poses:
        """Return the pose of every link that positions and orientations need."""
        return self._poses(q, self._links)

    def _poses(self, q: Vector, links: Sequence[str]) -> Poses:
        return dict(zip(links, self._model.link_poses(q, links), strict=True)) if links else {}

    def _ignored(self, reason: str) -> FixedTerm:
        self.unusable.append(reason)
        self._log.warning(f'constraint ignored: {reason}')
        return FixedTerm(ConstraintResult(True, 0.0, reason))

    def _never(self, reason: str) -> FixedTerm:
        self.unusable.append(reason)
        self._log.error(f'constraint cannot be satisfied: {reason}')
        return FixedTerm(ConstraintResult(False, 0.0, reason))

    def _joint(self, given: JointConstraint) -> Term:
        joint = self._model.robot.joints.get(given.joint_name)
        below, above = given.tolerance_below, given.tolerance_above
        if joint is None or not joint.movable:
            known = self._model.robot.active_joints
            return self._ignored(
                f"joint '{given.joint_name}' is not a joint of '{self._model.robot.name}' "
                f'that moves; {nearest(given.joint_name, known) or ", ".join(known)}')
        if below < 0.0 or above < 0.0:
            return self._ignored(
                f"joint '{given.joint_name}': tolerances +{above:g} -{below:g} must not be "
                'negative')
        if not math.isfinite(given.position) or math.isnan(below) or math.isnan(above):
            return self._never(
                f"joint '{given.joint_name}': position {given.position:g} and tolerances "
                f'+{above:g} -{below:g} have to be numbers')
        index, target = self._model.index(given.joint_name), given.position
        low, high = float(self._model.lower[index]), float(self._model.upper[index])
        continuous = joint.type is JointType.CONTINUOUS
        if continuous:
            target = math.remainder(target, 2.0 * math.pi)
            low, high = target - math.pi, target + math.pi
        elif target + above < low or target - below > high:
            limit = low if target < low else high
            self._log.warning(
                f"position {target:.4f} of joint '{given.joint_name}' is outside its limits "
                f'{low:.4f} .. {high:.4f}: using {limit:.4f}')
            below, above = (below, 0.0) if target < low else (0.0, above)
            target = limit
        return JointTerm(
            given.joint_name, index, target, below, above, max(low, target - below),
            min(high, target + above), continuous, _weight(given.weight))

    def _intervals(self) -> tuple[JointTerm, ...]:
        joints: dict[int, JointTerm] = {}
        for term in self.joints:
            before = joints.get(term.index)
            joints[term.index] = term if before is None else before.common(term)
        return tuple(joints.values())

    def _contradiction(self, term: JointTerm) -> FixedTerm:
        return self._never(
            f"joint '{term.name}': its constraints have no common value within their tolerances")

    def _link(self, name: str) -> Frame | None:
        """Return the frame of a link, an attached object or a subframe; None if unknown."""
        try:
            return Frame(*self._scene.link_of_frame(name)) if name else None
        except PlanningError:
            return None

    def _frame(self, name: str, link: str) -> Frame:
        """Return a constraint's frame; the model frame if it is unknown."""
        frame = self._link(name)
        if frame is not None:
            return frame
        model_frame = self._scene.model_frame
        self._log.warning(
            f"constraint of '{link}': frame '{name}' is not known: using the model frame "
            f"'{model_frame}'" if name else
            f"constraint of '{link}': header.frame_id is empty: using the model frame "
            f"'{model_frame}'")
        return Frame(*self._scene.link_of_frame(model_frame))

    def _position(self, given: PositionConstraint) -> Term:
        name = f"position constraint of '{given.link_name}'"
        target = self._link(given.link_name)
        if target is None:
            return self._ignored(f'{name}: the link is not known')
        if not given.frame_id:
            return self._ignored(
                f"{name}: header.frame_id is empty; give e.g. '{self._scene.model_frame}'")
        faults = [each.fault for each in given.regions if each.fault]
        for fault in (*given.left_out, *faults):
            self._log.warning(f'{name}: a region is left out: {fault}')
        regions = tuple(each for each in given.regions if not each.fault)
        if not given.regions:
            return self._ignored(f'{name}: it has no region with a pose')
        if not regions:
            return self._never(f'{name}: {faults[0]}')
        point = np.eye(4)
        point[:3, 3] = given.target_point_offset
        if not is_place(point):
            return self._never(f'{name}: target_point_offset is not finite or too large')
        return PositionTerm(
            given.link_name, Frame(target.link, target.offset @ point),
            self._frame(given.frame_id, given.link_name), regions, _weight(given.weight))

    def _orientation(self, given: OrientationConstraint) -> Term:
        name = f"orientation constraint of '{given.link_name}'"
        target = self._link(given.link_name)
        if target is None:
            return self._ignored(f'{name}: the link is not known')
        tolerances = np.abs(np.asarray(given.tolerances, dtype=np.float64))
        quat = np.asarray(given.quat_xyzw, dtype=np.float64)
        if np.isnan(tolerances).any() or not np.isfinite(quat).all():
            return self._never(
                f'{name}: orientation {given.quat_xyzw} and tolerances {given.tolerances} have '
                'to be numbers')
        if abs(math.hypot(*quat) - 1.0) > 1e-3:
            self._log.warning(
                f'{name}: quaternion {given.quat_xyzw} is not of length 1: using the identity')
            quat = np.array([0.0, 0.0, 0.0, 1.0])
        if given.parameterization not in tuple(Parameterization):
            self._log.warning(
                f'{name}: parameterization {given.parameterization} is not known: using '
                'XYZ_EULER_ANGLES')
        return OrientationTerm(
            given.link_name, target, self._frame(given.frame_id, given.link_name),
            matrix_from_quat_xyzw(quat), np.where(tolerances >= _FREE, math.inf, tolerances),
            given.parameterization == Parameterization.ROTATION_VECTOR, _weight(given.weight))

    def _visibility(self, given: VisibilityConstraint) -> Term:
        name = (f"visibility constraint of '{given.sensor_frame_id}' and "
                f"'{given.target_frame_id}'")
        angles = given.max_view_angle, given.max_range_angle
        if given.sensor_view_direction not in (0, 1, 2):
            return self._never(f'{name}: sensor_view_direction {given.sensor_view_direction} is '
                               'not 0 (z), 1 (y) or 2 (x)')
        if not (is_place(given.target_pose) and is_place(given.sensor_pose)
                and np.isfinite((given.target_radius, *angles)).all()):
            return self._never(f'{name}: a number is not finite or too large')
        if not any(map(enabled, (abs(given.target_radius), *angles))):
            return self._ignored(
                f'{name}: target_radius, max_view_angle and max_range_angle are 0')
        if given.cone_sides < 3:
            self._log.warning(f'{name}: cone_sides is {given.cone_sides}: using 3')
        sensor = self._frame(given.sensor_frame_id, name)
        target = self._frame(given.target_frame_id, name)
        root = self._model.robot.root_link
        exempt = {frame.link if frame.link == root else frame_id.removeprefix('/')
                  for frame, frame_id in ((sensor, given.sensor_frame_id),
                                          (target, given.target_frame_id))}
        return VisibilityTerm(
            replace(given, target_radius=abs(given.target_radius)),
            Frame(sensor.link, sensor.offset @ given.sensor_pose),
            Frame(target.link, target.offset @ given.target_pose),
            link_shapes(self._model, exempt))


def _weight(weight: float) -> float:
    return weight if weight > sys.float_info.epsilon else 1.0


def merged(first: Constraints, second: Constraints, log: Log) -> Constraints:
    """
    Return constraints that hold where both do.

    Intervals that both have for a joint are intersected; a pair without a common value is dropped
    with an error. All others are put together, several of one side for a joint among them.
    """
    joints: list[JointConstraint] = []
    for each in first.joint_constraints:
        common: JointConstraint | None = each
        for other in second.joint_constraints:
            if common is not None and other.joint_name == each.joint_name:
                common = _intersection(common, other, log)
        if common is not None:
            joints.append(common)
    shared = {each.joint_name for each in first.joint_constraints}
    joints += (each for each in second.joint_constraints if each.joint_name not in shared)
    return Constraints(
        tuple(joints), first.position_constraints + second.position_constraints,
        first.orientation_constraints + second.orientation_constraints,
        first.visibility_constraints + second.visibility_constraints, first.name or second.name)


def _intersection(
    first: JointConstraint, second: JointConstraint, log: Log
) -> JointConstraint | None:
    """Return the constraint of the values that two allow; None where there are none."""
    low = max(first.position - first.tolerance_below, second.position - second.tolerance_below)
    high = min(first.position + first.tolerance_above, second.position + second.tolerance_above)
    if low > high:
        log.error(f"joint '{first.joint_name}': the constraints {first.position:g} and "
                  f'{second.position:g} have no common value within their tolerances: both '
                  'ignored')
        return None
    weights = _weight(first.weight), _weight(second.weight)
    mean = float(np.average((first.position, second.position), weights=weights))
    position = min(max(mean, low), high)
    return JointConstraint(
        first.joint_name, position, high - position, position - low,
        0.5 * (first.weight + second.weight))
