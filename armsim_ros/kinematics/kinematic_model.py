# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint variables of a robot, poses of its links and their Jacobians."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from itertools import pairwise
import math
import threading
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.model.robot_model import Joint, JointType, RobotModel


class KinematicTree:
    """
    The joints and links of a robot in Pinocchio's numbers.

    Joints are numbered from 1 in the order of ``RobotModel.movable_joints``; 0 is the model
    frame. Every joint has a variable, continuous joints too.

    :param robot: the robot.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.model: Any = pin.Model()
        #: Link -> (number of the joint that carries it, its pose (4, 4) on that joint).
        self.places: dict[str, tuple[int, Matrix]] = {}
        #: Link -> number of its frame.
        self.frames: dict[str, int] = {}
        self._place(robot.root_link, 0, np.eye(4))
        for joint in robot.joints.values():
            carrier, offset = self.places[joint.parent]
            pose = offset @ joint.origin
            if joint.movable:
                added = self.model.addJoint(
                    carrier, _joint_model(joint), pin.SE3(pose), joint.name)
                self._place(joint.child, added, np.eye(4))
            else:
                self._place(joint.child, carrier, pose)

    def _place(self, link: str, carrier: int, offset: Matrix) -> None:
        self.places[link] = (carrier, offset)
        self.frames[link] = self.model.addFrame(
            pin.Frame(f'link {link}', carrier, pin.SE3(offset), pin.FrameType.BODY))


def mimic_rules(robot: RobotModel) -> tuple[tuple[int, int, float, float], ...]:
    """Return (index, master's index, multiplier, offset), masters that mimic resolved."""
    indices = {name: index for index, name in enumerate(robot.movable_joints)}
    rules = []
    for name in robot.movable_joints:
        driver, multiplier, offset = robot.driver_of(name)
        if driver.name != name:
            rules.append((indices[name], indices[driver.name], multiplier, offset))
    return tuple(rules)


def position_bounds(joint: Joint) -> tuple[float, float]:
    """Return lower and upper bound [rad or m]; a continuous joint has none."""
    if joint.type is JointType.CONTINUOUS:
        return -math.inf, math.inf
    return joint.limits.lower, joint.limits.upper


def _joint_model(joint: Joint) -> Any:
    axis = np.asarray(joint.axis, dtype=np.float64)
    x, y, z = axis / np.linalg.norm(axis)
    if joint.type is JointType.PRISMATIC:
        return pin.JointModelPrismaticUnaligned(x, y, z)
    return pin.JointModelRevoluteUnaligned(x, y, z)


Indices = NDArray[np.int64]


class KinematicModel:
    """
    A robot as functions of its joint vector ``q``.

    ``q`` is (n,) and holds a position [rad or m] for every movable joint, in the order of
    ``RobotModel.movable_joints``; a continuous joint is an unbounded angle, a mimic joint has
    a value of its own that follows its master. Floating and planar joints are at their
    origin. Poses are (4, 4) in the model frame. Several threads may use a model.

    :param robot: the robot.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self.names: tuple[str, ...] = robot.movable_joints
        self.n = len(self.names)
        self._indices = {name: index for index, name in enumerate(self.names)}
        joints = [robot.joints[name] for name in self.names]
        bounds = [position_bounds(joint) for joint in joints]
        self.lower: Vector = np.array([lower for lower, _ in bounds], float)
        self.upper: Vector = np.array([upper for _, upper in bounds], float)
        self.velocity_limits: Vector = np.array([j.limits.velocity for j in joints], float)
        self.acceleration_limits: Vector = np.array([j.limits.acceleration for j in joints], float)
        tree = KinematicTree(robot)
        self.model = tree.model
        self._places, self._frame = tree.places, tree.frames
        self._mimics = mimic_rules(robot)
        self._threads = threading.local()
        self._groups: dict[str, Indices] = {}
        self._slices: dict[str, slice | Indices] = {}
        self._gradients: dict[str, Matrix] = {}
        self._cache: dict[Hashable, Any] = {}
        self._cache_lock = threading.RLock()

    # ---------------------------------------------------------------- joint vectors

    def default(self) -> Vector:
        """Return q with every joint at its default: 0 where allowed, else mid range."""
        return self.apply_mimic(
            np.array([self.robot.default_position(name) for name in self.names], float))

    def index(self, joint: str) -> int:
        """Return the place of a movable joint in q; PlanningError names the known joints."""
        try:
            return self._indices[joint]
        except KeyError:
            raise PlanningError(
                MoveItErrorCode.INVALID_ROBOT_STATE,
                f"joint '{joint}' is not a movable joint of robot '{self.robot.name}'; "
                f'known joints: {", ".join(self.names)} {nearest(joint, self.names)}'.rstrip(),
            ) from None

    def vector(self, positions: Mapping[str, float], base: Vector | None = None) -> Vector:
        """
        Return q with the given positions laid over a base.

        :param positions: joint -> [rad or m]; a mimic joint's value is overridden by its master's.
        :param base: (n,) for the joints that are not named; None for the defaults.
        :raises PlanningError: INVALID_ROBOT_STATE for an unknown joint or a value that is not
            finite.
        """
        q = self.default() if base is None else base.copy()
        for name, value in positions.items():
            if not np.isfinite(value):
                raise PlanningError(
                    MoveItErrorCode.INVALID_ROBOT_STATE,
                    f"position {value} of joint '{name}' is not a finite number")
            q[self.index(name)] = value
        return self.apply_mimic(q)

    def positions(self, q: Vector) -> dict[str, float]:
        """Return joint -> position [rad or m] of all movable joints."""
        return dict(zip(self.names, (float(value) for value in q), strict=True))

    def apply_mimic(self, q: Vector) -> Vector:
        """Return a copy of q in which mimic joints follow their masters."""
        result = q.copy()
        for index, master, multiplier, offset in self._mimics:
            result[index] = multiplier * result[master] + offset
        return result

    def within_limits(self, q: Vector, margin: float = 1e-9) -> bool:
        """Return whether every joint lies within its limits, give or take ``margin``."""
        return bool(np.all(q >= self.lower - margin) and np.all(q <= self.upper + margin))

    # ---------------------------------------------------------------- planning groups

    def group_indices(self, group: str) -> Indices:
        """
        Return the places in q of a group's active variables, in tree order.

        :raises PlanningError: INVALID_GROUP_NAME with the known groups.
        """
        found = self._groups.get(group)
        if found is None:
            known = tuple(self.robot.semantic.groups)
            if group not in known:
                hint = nearest(group, known)
                raise PlanningError(
                    MoveItErrorCode.INVALID_GROUP_NAME,
                    f"planning group '{group}' is not in the SRDF of robot "
                    f"'{self.robot.name}'; known groups: {', '.join(known) or 'none'}"
                    f'{hint and "; "}{hint}')
            names = self.robot.semantic.groups[group].active_joints
            found = np.array([self._indices[name] for name in names], dtype=np.int64)
            self._groups[group] = found
            first = int(found[0]) if len(found) else 0
            beside = np.array_equal(found, np.arange(first, first + len(found)))
            self._slices[group] = slice(first, first + len(found)) if beside else found
        return found

    def _slots(self, group: str) -> slice | Indices:
        """Return what :meth:`group_indices` does, as a slice where possible, which is faster."""
        found = self._slices.get(group)
        return self.group_indices(group) if found is None else found

    def places(self, group: str) -> slice | Indices | None:
        """Return the places in q of a group's variables, None where mimic joints follow them."""
        indices = self.group_indices(group)
        followed = any(master in indices for _, master, _, _ in self._mimics)
        return None if followed else self._slots(group)

    def extract(self, q: Vector, group: str) -> Vector:
        """Return the group's active variables (m,) of q."""
        return q[self.group_indices(group)]

    def insert(self, q: Vector, group: str, values: ArrayLike) -> Vector:
        """Return a copy of q with the group's active variables (m,) set and mimic applied."""
        result = q.copy()
        result[self._slots(group)] = values
        for index, master, multiplier, offset in self._mimics:
            result[index] = multiplier * result[master] + offset
        return result

    def gradient(self, group: str) -> Matrix:
        """Return (n, m): how all of q moves with the group's active variables."""
        found = self._gradients.get(group)
        if found is None:
            indices = self.group_indices(group)
            found = np.zeros((self.n, len(indices)))
            found[indices, np.arange(len(indices))] = 1.0
            for index, master, multiplier, _offset in self._mimics:
                found[index] = multiplier * found[master]
            self._gradients[group] = found
        return found

    def moving_variables(self, group: str, links: Iterable[str]) -> Indices:
        """
        Return which of a group's active variables (counted in the group) move any of the links.

        :raises PlanningError: INVALID_LINK_NAME for an unknown link.
        """
        above = np.zeros(self.n, dtype=bool)
        for link in links:
            joint, _ = self.link_joint(link)
            while joint:
                above[self.model.joints[joint].idx_q] = True
                joint = self.model.parents[joint]
        moving: Indices = np.flatnonzero(self.gradient(group)[above].any(axis=0))
        return moving

    def is_chain(self, group: str) -> bool:
        """Return whether each joint of a group follows its predecessor, without branches."""
        found: bool = self.cached(('chain', group), lambda: self._chain(group))
        return found

    def _chain(self, group: str) -> bool:
        carriers = {joint.child: joint for joint in self.robot.joints.values()}
        joints = self.robot.semantic.groups[group].joints
        for before, name in pairwise(joints):
            above = carriers.get(self.robot.joints[name].parent)
            while above is not None and above.name != before and above.type is JointType.FIXED:
                above = carriers.get(above.parent)
            if above is None or above.name != before:
                return False
        return bool(len(self.group_indices(group)))

    def moved_links(self, group: str) -> frozenset[str]:
        """Return the links that move with a group: its own and all below them."""
        found: frozenset[str] = self.cached(('moved links', group), lambda: self._moved(group))
        return found

    def _moved(self, group: str) -> frozenset[str]:
        moving = {name for name, row in zip(self.names, self.gradient(group), strict=True)
                  if row.any()}
        moved: set[str] = set()
        for name, joint in self.robot.joints.items():
            if name in moving or joint.parent in moved:
                moved.add(joint.child)
        return frozenset(moved)

    # ---------------------------------------------------------------- poses

    @property
    def data(self) -> Any:
        """Pinocchio's work space of the calling thread."""
        data = getattr(self._threads, 'data', None)
        if data is None:
            data = self._threads.data = self.model.createData()
        return data

    def has_link(self, link: str) -> bool:
        """Return whether the robot has a link of that name."""
        return link in self._frame

    def frame_index(self, link: str) -> int:
        """Return Pinocchio's frame number of a link."""
        try:
            return self._frame[link]
        except KeyError:
            known = tuple(self._frame)
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f"link '{link}' is not a link of robot '{self.robot.name}' "
                f'{nearest(link, known)}'.rstrip(),
            ) from None

    def link_joint(self, link: str) -> tuple[int, Matrix]:
        """Return Pinocchio's joint number that carries a link and the link's pose on it."""
        self.frame_index(link)
        return self._places[link]

    def link_pose(self, q: Vector, link: str) -> Matrix:
        """
        Return the pose (4, 4) of a link in the model frame.

        :raises PlanningError: INVALID_LINK_NAME for an unknown link.
        """
        joint, fixed = self.link_joint(link)
        if joint == 0:  # Pinocchio's universe: no joint moves it
            return fixed.copy()
        data = self.data
        pin.forwardKinematics(self.model, data, q)
        pose: Matrix = pin.updateFramePlacement(self.model, data, self._frame[link]).homogeneous
        return pose

    def link_poses(self, q: Vector, links: Iterable[str]) -> list[Matrix]:
        """Return the poses (4, 4) of several links in the model frame."""
        frames = [self.frame_index(link) for link in links]
        data = self.data
        pin.forwardKinematics(self.model, data, q)
        return [
            pin.updateFramePlacement(self.model, data, frame).homogeneous for frame in frames
        ]

    def jacobian(self, q: Vector, link: str, group: str) -> Matrix:
        """
        Return the Jacobian (6, m) of a link's origin for a group's active variables.

        Rows are linear over angular velocity in the axes of the model frame; joints that
        mimic a variable add to its column.
        """
        frame = self.frame_index(link)
        full = pin.computeFrameJacobian(
            self.model, self.data, q, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        result: Matrix = full @ self.gradient(group)
        return result

    def cached(self, key: Hashable, build: Callable[[], Any]) -> Any:
        """Return what ``build`` made the first time for this key; it lives with the model."""
        with self._cache_lock:
            if key not in self._cache:
                self._cache[key] = build()
            return self._cache[key]
