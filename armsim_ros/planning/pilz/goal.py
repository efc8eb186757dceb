# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of the commands PTP, LIN and CIRC, and the auxiliary point of an arc."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.model.transforms import matrix_from_quat_xyzw, pose_from_parts
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import (
    Constraints,
    is_place,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene

_SOURCE = 'Pilz goal'


class CommandGoal:
    """
    Where a command ends.

    :param context: the robot and its solvers.
    :param request: a request for a group that has a solver.
    :param present: the monitored scene; frames are where they are in it.
    :param scene: its state is the start.
    :raises PlanningError: INVALID_GOAL_CONSTRAINTS where there is not one valid goal;
        NO_IK_SOLUTION for a link that the solver does not position.
    """

    def __init__(
        self, context: PlanningContext, request: MotionPlanRequest, present: PlanningScene,
        scene: PlanningScene,
    ) -> None:
        self._context = context
        self._group = request.group_name
        self._present = present
        self._scene = scene
        if len(request.goal_constraints) != 1:
            raise _error(f'the request has {len(request.goal_constraints)} goal constraints; PTP, '
                         'LIN and CIRC take exactly one')
        self._goal = goal = request.goal_constraints[0]
        posed = len(goal.position_constraints) == len(goal.orientation_constraints) == 1
        if posed == bool(goal.joint_constraints):
            raise _error('the goal has to be either joint constraints, or one position and one '
                         'orientation constraint')
        if posed:
            self._check_pose()
        else:
            self._check_joints()

    def _check_joints(self) -> None:
        model = self._context.model
        names = model.robot.semantic.groups[self._group].joints
        for each in self._goal.joint_constraints:
            if each.joint_name not in names:
                raise _error(f"joint '{each.joint_name}' of the goal is not in group "
                             f"'{self._group}'; it has {', '.join(names)}")
            index = model.index(each.joint_name)
            low, high = float(model.lower[index]), float(model.upper[index])
            if not low <= each.position <= high:
                raise _error(f"goal {each.position:.4f} of joint '{each.joint_name}' is outside "
                             f'its limits {low:.4f} .. {high:.4f}')

    def _check_pose(self) -> None:
        position, orientation = self._constraints
        if not position.link_name or position.link_name != orientation.link_name:
            raise _error(f"the goal's position is for link '{position.link_name}', its "
                         f"orientation for '{orientation.link_name}'; both have to name the same "
                         'link')
        self._context.solver_target(self._scene, self._group, position.link_name)
        if not position.poses:
            raise _error(f"the position of '{position.link_name}' has no region with a pose")

    @property
    def _constraints(self) -> tuple[PositionConstraint, OrientationConstraint]:
        return self._goal.position_constraints[0], self._goal.orientation_constraints[0]

    @property
    def posed(self) -> bool:
        """Whether the goal is a pose."""
        return not self._goal.joint_constraints

    def check_all_joints(self) -> None:
        """Refuse joint goals that do not name every joint of the group."""
        expected = len(self._context.model.group_indices(self._group))
        if not self.posed and len(self._goal.joint_constraints) != expected:
            raise _error(f'the goal has {len(self._goal.joint_constraints)} joint constraints, '
                         f"group '{self._group}' has {expected} joints; LIN and CIRC take one "
                         'for every joint')

    def joint_state(self) -> Vector:
        """
        Return the full robot state (n,) of the goal; of a pose, a state without self-collision.

        :raises PlanningError: NO_IK_SOLUTION.
        """
        if self.posed:
            return self._solved()
        return self._context.model.vector(
            {each.joint_name: each.position for each in self._goal.joint_constraints},
            self._scene.q)

    def frame(self, auxiliary_link: str = '') -> Frame:
        """
        Return the frame that moves: the goal's link.

        :param auxiliary_link: for joint goals; '' for the tip of the group's solver.
        """
        name = self._constraints[0].link_name if self.posed else auxiliary_link
        return self._context.solver_target(self._scene, self._group, name)

    def pose(self) -> Matrix:
        """Return the pose (4, 4) of a pose goal's link in the model frame."""
        position, orientation = self._constraints
        named = bool(position.frame_id and orientation.frame_id)
        base = self._present.frame_pose(position.frame_id if named else '')
        turned = self._turned()
        point = position.poses[0][:3, 3] - turned @ np.asarray(position.target_point_offset)
        pose: Matrix = base @ pose_from_parts(point, turned)
        if not is_place(pose):
            raise _error(f"the pose of '{position.link_name}' has a number that is not finite or "
                         'too large')
        return pose

    def _turned(self) -> Matrix:
        """Return the goal's rotation (3, 3) in its own frame; quaternions are normalized."""
        quat = np.asarray(self._constraints[1].quat_xyzw, dtype=np.float64)
        length = float(np.linalg.norm(quat))
        if not length > 0.0:
            raise _error(f'the goal orientation {tuple(quat)} is not a quaternion')
        return matrix_from_quat_xyzw(quat / length)

    def _solved(self) -> Vector:
        context, group = self._context, self._group
        frame, pose = self.frame(), self.pose()
        result = context.inverse(group).solve(
            [IKTarget(frame.link, pose, frame.offset)], self._scene.q,
            IKOptions(self._keeps_off_itself))
        if result.q is None:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"no joint positions put '{self._constraints[0].link_name}' at "
                f'{np.round(pose[:3, 3], 4).tolist()} m in the model frame: {result.message}',
                _SOURCE)
        return result.q

    def _keeps_off_itself(self, q: Vector) -> bool:
        """Return whether a state (n,) has no contact between links and what they carry."""
        return not self._context.checker.in_collision(q, self._group) or not any(
            BodyType.WORLD_OBJECT not in (contact.type1, contact.type2)
            for contact in self._context.checker.contacts(q, self._group))

    def auxiliary_point(self, constraints: Constraints) -> Vector:
        """
        Return the centre or interim point (3,) [m] of an arc in the model frame.

        The offset of a pose goal shifts it too.
        """
        helper = constraints.position_constraints[0]
        base = self._present.frame_pose(helper.frame_id)
        point: Vector = (base @ helper.poses[0])[:3, 3]
        if self.posed:
            point = point - self._turned() @ np.asarray(
                self._constraints[0].target_point_offset)
        if not is_place(point):
            raise _error('the auxiliary point has a number that is not finite or too large')
        return point


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, text, _SOURCE)
