# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The one goal of a command: joint positions, or the pose of a link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKTarget
from armsim_ros.model.transforms import matrix_from_quat_xyzw, pose_from_parts
from armsim_ros.planning.constraints.regions import is_place, region_fault
from armsim_ros.planning.constraints.terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import Constraints, MotionPlanRequest, PositionConstraint
from armsim_ros.planning.scene.planning_scene import PlanningScene

_SOURCE = 'Pilz goal'
_LEAST_SCALING = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class CommandGoal:
    """
    Where a command ends.

    :param q: (n,) full robot state there.
    :param frame: the link that the goal is about, or the group's last one.
    :param pose: (4, 4) of that frame in the model frame.
    """

    q: Vector
    frame: Frame
    pose: Vector


def check_scaling(request: MotionPlanRequest) -> None:
    """Refuse scaling factors outside (0.0001, 1]: a command's speed is part of its meaning."""
    for name in ('max_velocity_scaling_factor', 'max_acceleration_scaling_factor'):
        value = getattr(request, name)
        if not _LEAST_SCALING < value <= 1.0:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'{name} is {value:g}; PTP, LIN and CIRC take a number above 0.0001, up to 1',
                _SOURCE,
            )


def read_goal(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene
) -> CommandGoal:
    """
    Return the goal of a request.

    :param scene: its state is the start.
    :raises PlanningError: INVALID_GOAL_CONSTRAINTS for what is no single goal; NO_IK_SOLUTION
        where its pose cannot be reached.
    """
    if len(request.goal_constraints) != 1:
        raise _error(f'the request has {len(request.goal_constraints)} goal constraints; PTP, LIN '
                     'and CIRC take exactly one')
    goal = request.goal_constraints[0]
    if goal.empty:
        raise _error('the goal constraint is empty')
    posed = goal.position_constraints or goal.orientation_constraints
    if goal.joint_constraints and posed:
        raise _error('the goal mixes joint constraints with a pose; give one of the two')
    if posed:
        return _pose_goal(context, request.group_name, goal, scene)
    return _joint_goal(context, request.group_name, goal, scene)


def _joint_goal(
    context: PlanningContext, group: str, goal: Constraints, scene: PlanningScene
) -> CommandGoal:
    model = context.model
    names = [model.names[index] for index in model.group_indices(group)]
    values: dict[str, float] = {}
    for each in goal.joint_constraints:
        if each.joint_name not in names:
            raise _error(f"joint '{each.joint_name}' of the goal is not in group '{group}'; it "
                         f'has {", ".join(names)}')
        index = model.index(each.joint_name)
        low, high = float(model.lower[index]), float(model.upper[index])
        if not low - 1e-6 <= each.position <= high + 1e-6:
            raise _error(f"goal {each.position:.4f} of joint '{each.joint_name}' is outside its "
                         f'limits {low:.4f} .. {high:.4f}')
        values[each.joint_name] = min(max(each.position, low), high)
    if not values:
        raise _error('the goal has no joint, position or orientation constraint')
    q = model.vector(values, scene.q)
    frame = Frame(context.tip(group), np.eye(4))
    return CommandGoal(q, frame, model.link_pose(q, frame.link))


def _pose_goal(
    context: PlanningContext, group: str, goal: Constraints, scene: PlanningScene
) -> CommandGoal:
    if len(goal.position_constraints) != 1 or len(goal.orientation_constraints) != 1:
        raise _error(f'the goal has {len(goal.position_constraints)} position and '
                     f'{len(goal.orientation_constraints)} orientation constraints; a pose is '
                     'one of each')
    position, orientation = goal.position_constraints[0], goal.orientation_constraints[0]
    if not position.link_name or position.link_name != orientation.link_name:
        raise _error(f"the goal's position is for link '{position.link_name}', its orientation "
                     f"for '{orientation.link_name}'; both have to name the same link")
    try:
        frame = Frame(*scene.link_of_frame(position.link_name))
    except PlanningError as error:
        raise _error(str(error)) from None
    quat = np.asarray(orientation.quat_xyzw)
    if not abs(float(np.linalg.norm(quat)) - 1.0) <= 1e-3:
        raise _error(f'the goal orientation {orientation.quat_xyzw} is not of length 1')
    turned = scene.frame_pose(orientation.frame_id, scene.q)[:3, :3] @ matrix_from_quat_xyzw(quat)
    offset = np.asarray(position.target_point_offset)
    pose = pose_from_parts(point_of(position, scene) - turned @ offset, turned)
    result = context.inverse(group).solve(
        [IKTarget(frame.link, pose, frame.offset)], scene.q,
        is_valid=lambda q: not context.checker.in_collision(q, group),
    )
    if result.q is None:
        result = context.inverse(group).solve(
            [IKTarget(frame.link, pose, frame.offset)], scene.q
        )
    if result.q is None:
        raise PlanningError(
            MoveItErrorCode.NO_IK_SOLUTION,
            f"no joint positions put '{position.link_name}' at "
            f'{np.round(pose[:3, 3], 4).tolist()} m in the model frame: {result.message}',
            _SOURCE,
        )
    return CommandGoal(result.q, frame, pose)


def point_of(position: PositionConstraint, scene: PlanningScene) -> Vector:
    """
    Return the point (3,) of a position constraint's region in the model frame.

    :raises PlanningError: INVALID_GOAL_CONSTRAINTS where it has no region, or one that is none.
    """
    if not position.regions:
        raise _error(f"the position of '{position.link_name}' has no region with a pose")
    region = position.regions[0]
    fault = region_fault(region)
    if fault or not is_place(np.asarray(position.target_point_offset)):
        raise _error(f"the position of '{position.link_name}' cannot be used: "
                     + (fault or 'target_point_offset is not finite'))
    base = scene.frame_pose(position.frame_id, scene.q)
    point: Vector = (base @ region.pose)[:3, 3]
    return point


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, text, _SOURCE)
