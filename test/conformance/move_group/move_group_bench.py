# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client of move_group that knows the robot only from what the server publishes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any
from xml.etree import ElementTree

from action_msgs.msg import GoalStatus
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    MoveItErrorCodes,
    PlanningScene,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetCartesianPath,
    GetMotionPlan,
    GetPlanningScene,
    GetPositionFK,
    GetPositionIK,
    GetStateValidity,
)
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from wire import detached, joint_goal, quiet_diff, robot_state

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ParameterClient

SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED,
    GoalStatus.STATUS_CANCELED,
    GoalStatus.STATUS_ABORTED,
)
CODES = {
    value: name
    for name, value in vars(MoveItErrorCodes).items()
    if name.isupper() and isinstance(value, int)
}
TIMEOUT = 20.0


@dataclass
class Ended:
    """An action goal that has ended, with the feedback that it gave."""

    status: int
    result: Any
    feedback: list[str]

    @property
    def code(self) -> str:
        """Name of the error code."""
        return name_of(self.result.error_code)


class Feedback:
    """
    The states that all goals of an action have fed back.

    rclpy's action client drops what comes after the result, which overtakes the last feedback at
    times: they go different ways.

    :param client: a node beside the server.
    :param action: name of the action.
    :param kind: its type.
    """

    def __init__(self, client: ClientNode, action: str, kind: Any) -> None:
        self._states = client.collect(
            f'{action}/_action/feedback', kind.Impl.FeedbackMessage, QoSProfile(depth=1000)
        )

    def of(self, handle: Any) -> list[str]:
        """Return the states of a goal that has ended, the last one is IDLE."""
        mine = bytes(handle.goal_id.uuid)
        self._states.wait_for(
            lambda one: bytes(one.goal_id.uuid) == mine and one.feedback.state == 'IDLE'
        )
        return [one.feedback.state for one in self._states.messages
                if bytes(one.goal_id.uuid) == mine]


def name_of(code: Any) -> str:
    """Return the name of an error code message."""
    return CODES.get(code.val, str(code.val))


class ArmBench:
    """
    The arm under test.

    :param client: a node beside the server.
    :param namespace: of move_group.
    :param joint_states: topic with joint states.
    """

    def __init__(self, client: ClientNode, namespace: str, joint_states: str) -> None:
        self.client = client
        self.namespace = namespace
        self.parameters = ParameterClient(client, self.name('move_group'))
        self.execution_parameters = ParameterClient(
            client, self.name('moveit_simple_controller_manager'))
        urdf = ElementTree.fromstring(self.parameters.get('robot_description'))
        srdf = ElementTree.fromstring(self.parameters.get('robot_description_semantic'))
        self.robot_name = urdf.get('name')
        self._read_joints(urdf)
        self._read_group(srdf)
        node = client.node
        self.move_action = PatientActionClient(node, MoveGroup, self.name('move_action'))
        self.execute_action = PatientActionClient(
            node, ExecuteTrajectory, self.name('execute_trajectory')
        )
        self._move_feedback = Feedback(client, self.name('move_action'), MoveGroup)
        self._execute_feedback = Feedback(
            client, self.name('execute_trajectory'), ExecuteTrajectory
        )
        self.joint_states = client.collect(joint_states, JointState, 1)  # no backlog

    def _read_joints(self, urdf: Any) -> None:
        """Note limits, and the root link."""
        self.limits: dict[str, tuple[float, float]] = {}
        children, links = set(), [link.get('name') for link in urdf.findall('link')]
        self.links = links
        for joint in urdf.findall('joint'):
            children.add(joint.find('child').get('link'))
            limit = joint.find('limit')
            if joint.get('type') in ('revolute', 'prismatic') and joint.find('mimic') is None:
                self.limits[joint.get('name')] = (
                    float(limit.get('lower', 0)), float(limit.get('upper', 0))
                )
        self.joints = list(self.limits)
        self.frame = next(link for link in links if link not in children)

    def _read_group(self, srdf: Any) -> None:
        """Take the first group that is a chain."""
        group = next(one for one in srdf.findall('group') if one.find('chain') is not None)
        self.group = group.get('name')
        self.tip = group.find('chain').get('tip_link')
        self.states = {
            state.get('name'): {
                joint.get('name'): float(joint.get('value')) for joint in state.findall('joint')
            }
            for state in srdf.findall('group_state')
            if state.get('group') == self.group
        }
        virtual = srdf.find('virtual_joint')
        moves = virtual is not None and virtual.get('type') != 'fixed'
        if moves and virtual.get('child_link') == self.frame:
            self.frame = virtual.get('parent_frame')
        self.group_joints = list(next(iter(self.states.values())))

    def name(self, relative: str) -> str:
        """Return the full name of one of move_group's endpoints."""
        return f'{self.namespace}/{relative}'

    # ------------------------------------------------------------------ states

    def positions(self) -> dict[str, float]:
        """Return the joint positions of a message that comes from now on [rad]."""
        self.joint_states.clear()
        message = self.joint_states.wait(1)[-1]
        return dict(zip(message.name, message.position, strict=True))

    def distance(self, state: str | Mapping[str, float]) -> float:
        """Return how far the joint that is farthest is from a state [rad]."""
        now = self.positions()
        return max(abs(now[name] - value) for name, value in self.state(state).items())

    def state(self, state: str | Mapping[str, float]) -> Mapping[str, float]:
        """Return joint -> position of a named state, or what was given."""
        return self.states[state] if isinstance(state, str) else state

    def near(self, step: float = 0.2) -> dict[str, float]:
        """Return where every joint is a step [rad] away, towards the middle of its range."""
        now = self.positions()
        goal = {}
        for name in self.group_joints:
            away = 0.5 * sum(self.limits[name]) - now[name]
            goal[name] = now[name] + (-step if away < -0.01 else step)
        return goal

    # ------------------------------------------------------------------ planning

    def request(self, goal: Any = None, **fields: Any) -> Any:
        """Return a request as MoveGroupInterface makes it; a goal is a state or constraints."""
        request = GetMotionPlan.Request().motion_plan_request
        request.group_name = self.group
        request.num_planning_attempts = 1
        request.allowed_planning_time = 5.0
        request.max_velocity_scaling_factor = request.max_acceleration_scaling_factor = 1.0
        request.start_state = RobotState(is_diff=True)
        if isinstance(goal, (str, Mapping)):
            goal = joint_goal(self.state(goal))
        if goal is not None:
            request.goal_constraints = list(goal) if isinstance(goal, (list, tuple)) else [goal]
        for field, value in fields.items():
            setattr(request, field, value)
        return request

    def plan(self, goal: Any = None, **fields: Any) -> Any:
        """Ask plan_kinematic_path and return its motion plan response."""
        wanted = GetMotionPlan.Request(motion_plan_request=self.request(goal, **fields))
        answer = self.client.call(
            self.name('plan_kinematic_path'), GetMotionPlan, wanted, TIMEOUT
        )
        return answer.motion_plan_response

    def planned(self, goal: Any = None, **fields: Any) -> Any:
        """Return the joint trajectory of a plan that succeeds."""
        answer = self.plan(goal, **fields)
        assert name_of(answer.error_code) == 'SUCCESS', answer.error_code
        return answer.trajectory.joint_trajectory

    def refused(self, goal: Any = None, **fields: Any) -> Any:
        """Return the error code of a plan that fails: with a message and no trajectory."""
        answer = self.plan(goal, **fields)
        code = answer.error_code
        assert name_of(code) != 'SUCCESS'
        assert not answer.trajectory.joint_trajectory.points
        assert code.message
        assert code.source
        return code

    def send_move(self, goal: Any, **options: Any) -> Any:
        """Send a goal to move_action and return its handle; options are of both messages."""
        message = MoveGroup.Goal(request=self.request(goal))
        message.planning_options.planning_scene_diff = quiet_diff()
        for field, value in options.items():
            part = message.request if hasattr(message.request, field) else (
                message.planning_options
            )
            setattr(part, field, value)
        return self._send(self.move_action, message)

    def move(self, goal: Any, **options: Any) -> Ended:
        """Send a goal to move_action and wait for its end."""
        return self.ended(self.send_move(goal, **options), self._move_feedback)

    def send_execute(self, trajectory: Any, names: Sequence[str] = ()) -> Any:
        """Send a trajectory to execute_trajectory and return the goal's handle."""
        goal = ExecuteTrajectory.Goal(controller_names=list(names))
        if isinstance(trajectory, RobotTrajectory):
            goal.trajectory = trajectory
        else:
            goal.trajectory.joint_trajectory = trajectory
        return self._send(self.execute_action, goal)

    def execute(self, trajectory: Any, names: Sequence[str] = ()) -> Ended:
        """Execute a trajectory and wait for the end."""
        return self.ended(self.send_execute(trajectory, names), self._execute_feedback)

    def _send(self, action: PatientActionClient, goal: Any) -> Any:
        assert action.wait_for_server(TIMEOUT)
        handle = self.client.result(action.send_goal_async(goal), TIMEOUT, 'answer to a goal')
        assert handle.accepted
        return handle

    def cancel(self, handle: Any) -> None:
        """Cancel a goal and wait for the answer."""
        self.client.result(handle.cancel_goal_async(), TIMEOUT, 'answer to a cancel request')

    def ended(
        self, handle: Any, feedback: Feedback | None = None, timeout: float = 30.0
    ) -> Ended:
        """Wait for the end of a goal, and for its last feedback where that is given."""
        answer = self.client.result(handle.get_result_async(), timeout, 'result')
        return Ended(answer.status, answer.result, feedback.of(handle) if feedback else [])

    # ------------------------------------------------------------------ questions

    def fk(self, links: Sequence[str], state: Any = None, frame: str = '') -> Any:
        """Ask compute_fk."""
        request = GetPositionFK.Request(fk_link_names=list(links))
        request.header.frame_id = frame
        request.robot_state = robot_state(None if state is None else self.state(state))
        return self.client.call(self.name('compute_fk'), GetPositionFK, request)

    def pose(self, state: Any = None, link: str = '') -> Any:
        """Return the pose of a link, the tip where none is named."""
        answer = self.fk([link or self.tip], state)
        assert name_of(answer.error_code) == 'SUCCESS', answer.error_code
        return answer.pose_stamped[0]

    def ik(self, **fields: Any) -> Any:
        """Ask compute_ik."""
        request = GetPositionIK.Request()
        request.ik_request.group_name = self.group
        request.ik_request.robot_state = RobotState(is_diff=True)
        for field, value in fields.items():
            setattr(request.ik_request, field, value)
        return self.client.call(self.name('compute_ik'), GetPositionIK, request)

    def validity(self, state: Any, group: str | None = None, **fields: Any) -> Any:
        """Ask check_state_validity."""
        request = GetStateValidity.Request(
            group_name=self.group if group is None else group, **fields
        )
        request.robot_state = robot_state(self.state(state))
        return self.client.call(self.name('check_state_validity'), GetStateValidity, request)

    def cartesian(self, waypoints: Sequence[Any], **fields: Any) -> Any:
        """Ask compute_cartesian_path."""
        request = GetCartesianPath.Request(group_name=self.group, waypoints=list(waypoints))
        request.start_state = RobotState(is_diff=True)
        request.max_step = 0.01
        request.avoid_collisions = True
        for field, value in fields.items():
            setattr(request, field, value)
        return self.client.call(
            self.name('compute_cartesian_path'), GetCartesianPath, request, TIMEOUT
        )

    # ------------------------------------------------------------------ scene

    def scene(self, components: int = 0) -> PlanningScene:
        """Return the planning scene with the components asked for."""
        request = GetPlanningScene.Request()
        request.components.components = components
        name = self.name('get_planning_scene')
        return self.client.call(name, GetPlanningScene, request).scene

    def apply(self, scene: PlanningScene) -> bool:
        """Apply a scene message and return whether all of it was taken."""
        request = ApplyPlanningScene.Request(scene=scene)
        name = self.name('apply_planning_scene')
        return bool(self.client.call(name, ApplyPlanningScene, request).success)

    def add(self, *objects: Any) -> bool:
        """Apply collision objects."""
        scene = quiet_diff()
        scene.world.collision_objects = list(objects)
        return self.apply(scene)

    def attach(self, *objects: Any) -> bool:
        """Apply attached collision objects."""
        scene = quiet_diff()
        scene.robot_state.attached_collision_objects = list(objects)
        return self.apply(scene)

    def allow(self, name: str, others: Iterable[str]) -> bool:
        """Let an object touch some links."""
        scene = quiet_diff()
        matrix = self.scene().allowed_collision_matrix
        touch = set(others)
        column = [one in touch for one in matrix.entry_names]
        for row, touches in zip(matrix.entry_values, column, strict=True):
            row.enabled = [*row.enabled, touches]
        matrix.entry_names = [*matrix.entry_names, name]
        matrix.entry_values = [
            *matrix.entry_values, AllowedCollisionEntry(enabled=[*column, False])
        ]
        scene.allowed_collision_matrix = matrix
        return self.apply(scene)

    def objects(self) -> dict[str, Any]:
        """Return the objects of the world by id."""
        return {item.id: item for item in self.scene().world.collision_objects}

    def attached(self) -> dict[str, Any]:
        """Return the attached objects by id."""
        items = self.scene().robot_state.attached_collision_objects
        return {item.object.id: item for item in items}

    def clear(self, rules: PlanningScene) -> None:
        """Empty the world and take the rules of an earlier scene."""
        scene = PlanningScene(is_diff=False)
        scene.robot_state.is_diff = True
        scene.robot_state.attached_collision_objects = [detached()]
        scene.allowed_collision_matrix = rules.allowed_collision_matrix
        scene.link_padding, scene.link_scale = rules.link_padding, rules.link_scale
        assert self.apply(scene)


def seconds(duration: Any) -> float:
    """Return a duration message as [s]."""
    return duration.sec + duration.nanosec * 1e-9


def xyz(point: Any) -> tuple[float, float, float]:
    """Return a point message as numbers [m]."""
    return point.x, point.y, point.z


def turn(a: Any, b: Any) -> float:
    """Return the angle between two quaternion messages [rad]."""
    dot = abs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w)
    return 2.0 * math.acos(min(1.0, dot))
