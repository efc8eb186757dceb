# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a robot state keeps constraints, and by how much it misses them."""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import nearest, PlanningError
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import matrix_from_quat_xyzw
from armsim_ros.planning.constraints.terms import (
    ConstraintResult,
    EPSILON,
    Frame,
    is_place,
    JointTerm,
    OrientationTerm,
    PositionTerm,
    region_fault,
)
from armsim_ros.planning.log import Log
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    OrientationConstraint,
    Parameterization,
    PositionConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene


class ConstraintSet:
    """
    Constraints made ready for one scene; what cannot be used is dropped and said.

    :param constraints: all of them have to hold.
    :param scene: knows frames, links and joints.
    :param log: hears warnings about values that are not usable as given.
    """

    def __init__(self, constraints: Constraints, scene: PlanningScene, log: Log) -> None:
        """Resolve names and frames; reasons for dropped ones are in :attr:`dropped`."""
        self._model = scene.kinematic_model
        self._scene = scene
        self._log = log
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
            *(term.evaluate(poses[term.target.link], poses[term.frame.link])
              for term in self.positions),
            *(term.evaluate(poses[term.target.link], poses[term.frame.link])
              for term in self.orientations),
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
        parts = [np.array([term.residual(q, margin) for term in self.joints])]
        for term in self._pose_terms:
            parts.append(
                term.residual(poses[term.target.link], poses[term.frame.link], margin)
            )
        return np.concatenate(parts)

    def violation(self, q: Vector) -> str:
        """Return the first constraint that a state (n,) breaks, as a phrase, or ''."""
        return next((each.text for each in self.evaluate(q) if not each.satisfied), '')

    def poses(self, q: Vector) -> dict[str, Vector]:
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
        fault = next(filter(None, map(region_fault, given.regions)), '')
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
