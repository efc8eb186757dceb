# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A client of the stack that never rests: ``python -m benchmarks.endurance.soak_client KIND ROBOT``.

KIND is ``moves`` (plan and execute between named states), ``plans`` (plan only, every third one
cancelled), ``edits`` (objects come, move, are attached and go) or ``asks`` (kinematics, validity,
the scene, parameters). At the end of its input it prints what it did and what went wrong.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
import itertools
import os
import re
import select
import sys
from typing import Any

from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    JointConstraint,
    MoveItErrorCodes,
    PlanningScene,
    RobotState,
)
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetPlanningScene,
    GetPositionFK,
    GetPositionIK,
    GetStateValidity,
)
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from shape_msgs.msg import SolidPrimitive

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.loading import load_robot_model

DONE = 'did'
#: What a goal may end with while others change the scene and cancel.
EXPECTED = (MoveItErrorCodes.SUCCESS, MoveItErrorCodes.PREEMPTED)


class SoakClient:
    """
    A node and the robot's names.

    :param client: the node.
    :param robot: a name under ``config/`` or a path to a folder.
    """

    def __init__(self, client: ClientNode, robot: str) -> None:
        semantic = load_robot_model(load_robot_settings(robot)).semantic
        self._client = client
        self.group, states = next(
            (name, states) for name, states in semantic.named_states.items() if len(states) > 1)
        self.tip = semantic.groups[self.group].links[-1]
        self._states = itertools.cycle(states.values())
        self._action = PatientActionClient(client.node, MoveGroup, '/move_action')
        self._numbers = itertools.count()
        self.done: Counter[str] = Counter()

    def moves(self) -> None:
        """Plan and execute."""
        self._goal(plan_only=False)

    def plans(self) -> None:
        """Plan, and cancel now and then."""
        self._goal(plan_only=True, cancel=next(self._numbers) % 3 == 0)

    def edits(self) -> None:
        """Let an object come, move, be attached, detached and go."""
        name = f'thing {next(self._numbers) % 50}'
        box = CollisionObject(id=name, operation=CollisionObject.ADD)
        box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.05] * 3)]
        box.pose.position.x, box.pose.orientation.w = 3.0, 1.0
        move = CollisionObject(id=name, operation=CollisionObject.MOVE, pose=box.pose)
        gone = CollisionObject(id=name, operation=CollisionObject.REMOVE)
        hold = AttachedCollisionObject(link_name=self.tip, touch_links=[self.tip])
        hold.object.id = name
        drop = AttachedCollisionObject()
        drop.object.id, drop.object.operation = name, CollisionObject.REMOVE
        for world, robot in (([box], []), ([move], []), ([], [hold]), ([], [drop]), ([gone], [])):
            scene = PlanningScene(is_diff=True)
            scene.robot_state.is_diff = True
            scene.world.collision_objects = world
            scene.robot_state.attached_collision_objects = robot
            request = ApplyPlanningScene.Request(scene=scene)
            answer = self._client.call('/apply_planning_scene', ApplyPlanningScene, request)
            self.done['edit' if answer.success else 'REFUSED edit'] += 1

    def asks(self) -> None:
        """Ask one of everything."""
        client, state = self._client, RobotState(is_diff=True)
        pose = client.call('/compute_fk', GetPositionFK, GetPositionFK.Request(
            fk_link_names=[self.tip], robot_state=state)).pose_stamped[0]
        request = GetPositionIK.Request()
        request.ik_request.group_name = self.group
        request.ik_request.robot_state, request.ik_request.pose_stamped = state, pose
        client.call('/compute_ik', GetPositionIK, request)
        client.call('/check_state_validity', GetStateValidity, GetStateValidity.Request(
            group_name=self.group, robot_state=state))
        client.call('/get_planning_scene', GetPlanningScene)
        value = ParameterValue(
            type=ParameterType.PARAMETER_DOUBLE, double_value=2.0 + next(self._numbers) % 3)
        name = 'trajectory_execution.allowed_execution_duration_scaling'
        client.call('/move_group/set_parameters', SetParameters, SetParameters.Request(
            parameters=[Parameter(name=name, value=value)]))
        self.done['round of questions'] += 1

    def _goal(self, *, plan_only: bool, cancel: bool = False) -> None:
        message = MoveGroup.Goal(request=_request(self.group, next(self._states)))
        message.planning_options.plan_only = plan_only
        message.planning_options.planning_scene_diff.is_diff = True
        message.planning_options.planning_scene_diff.robot_state.is_diff = True
        assert self._action.wait_for_server(10.0)
        handle = self._client.result(self._action.send_goal_async(message), 10.0, 'goal answer')
        ended = self._client.in_executor(handle.get_result_async)
        if cancel:
            self._client.in_executor(handle.cancel_goal_async)
        code = self._client.result(ended, 60.0, 'result').result.error_code
        if code.val in EXPECTED:
            self.done['motion' if not plan_only else 'plan'] += 1
        else:
            reason = re.sub(r"'thing [0-9]+'|[-0-9.]+ (?=mm|s)", '...', code.message)
            self.done[f'goal FAILED with {code.val}: {reason[:80]}'] += 1


def _request(group: str, goal: dict[str, float]) -> Any:
    request = MoveGroup.Goal().request
    request.group_name, request.allowed_planning_time = group, 5.0
    request.start_state = RobotState(is_diff=True)
    request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=value, tolerance_above=1e-4,
                        tolerance_below=1e-4, weight=1.0)
        for name, value in goal.items()])]
    return request


def until_input_ends(work: Callable[[], None], done: Counter[str]) -> None:
    """Do something again and again; a call that is not answered is counted, too."""
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        try:
            work()
        except AssertionError as error:
            done[f'MISSED: {error}'] += 1


def main(kind: str, robot: str) -> None:
    """Run one client until its input ends."""
    with ClientNode(int(os.environ['ROS_DOMAIN_ID']), f'soak_{kind}') as node:
        client = SoakClient(node, robot)
        print('begins', flush=True)
        until_input_ends(getattr(client, kind), client.done)
        for what, count in sorted(client.done.items()):
            print(f'{kind} {DONE} {count} x {what}', flush=True)


if __name__ == '__main__':
    main(*sys.argv[1:])
