# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A typed client of what move_group does and answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint, MoveItErrorCodes, RobotState
from moveit_msgs.srv import GetPositionFK, GetStateValidity
from rclpy.action import ActionClient

from armsim_ros.arrays import Matrix
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.motion import robot_state
from armsim_ros.nodes.conversions.geometry import pose_from_message

SUCCESS = MoveItErrorCodes.SUCCESS


class MoveGroupClient:
    """
    Plans and executes through move_group.

    :param client: the node to use.
    :param namespace: of move_group, '' or such as ``/left``.
    """

    def __init__(self, client: ClientNode, namespace: str = '') -> None:
        self.client = client
        self._namespace = namespace
        self._move = ActionClient(client.node, MoveGroup, f'{namespace}/move_action')
        self._execute = ActionClient(
            client.node, ExecuteTrajectory, f'{namespace}/execute_trajectory'
        )

    def named_states(self) -> dict[tuple[str, str], dict[str, float]]:
        """Return (group, state) -> joint -> position [rad or m], from move_group's SRDF."""
        text = ParameterClient(self.client, f'{self._namespace}/move_group').get(
            'robot_description_semantic')
        return {
            (state.get('group', ''), state.get('name', '')): {
                joint.get('name', ''): float(joint.get('value', ''))
                for joint in state.findall('joint')
            }
            for state in ElementTree.fromstring(text).findall('group_state')
        }

    def plan(self, group: str, target: Mapping[str, float], **request: Any) -> Any:
        """Plan to joint positions [rad or m] and return the result."""
        return self._send_move(group, target, True, request)

    def move(self, group: str, target: Mapping[str, float], **request: Any) -> Any:
        """Plan to joint positions [rad or m], execute, and return the result."""
        return self._send_move(group, target, False, request)

    def execute(self, trajectory: Any, controllers: tuple[str, ...] = ()) -> Any:
        """Execute a ``RobotTrajectory`` and return the result."""
        goal = ExecuteTrajectory.Goal(
            trajectory=trajectory, controller_names=list(controllers)
        )
        return self._run(self._execute, goal)

    def pose(self, link: str, positions: Mapping[str, float], frame: str) -> Matrix:
        """Return the pose of a link in a frame at joint positions [rad or m], (4, 4)."""
        request = GetPositionFK.Request(
            fk_link_names=[link], robot_state=robot_state(positions))
        request.header.frame_id = frame
        answer = self.client.call(f'{self._namespace}/compute_fk', GetPositionFK, request)
        return pose_from_message(answer.pose_stamped[0].pose)

    def valid(self, group: str, positions: Mapping[str, float]) -> bool:
        """Return whether joint positions [rad or m] are inside the limits and touch nothing."""
        request = GetStateValidity.Request(group_name=group, robot_state=robot_state(positions))
        return bool(self.client.call(
            f'{self._namespace}/check_state_validity', GetStateValidity, request).valid)

    def _send_move(
        self, group: str, target: Mapping[str, float], plan_only: bool, fields: Mapping[str, Any]
    ) -> Any:
        goal = MoveGroup.Goal()
        goal.planning_options.plan_only = plan_only
        goal.planning_options.planning_scene_diff.is_diff = True
        request = goal.request
        request.group_name = group
        request.allowed_planning_time = 5.0
        request.start_state = RobotState(is_diff=True)
        request.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(
                joint_name=joint, position=value, tolerance_above=1e-4, tolerance_below=1e-4,
                weight=1.0,
            )
            for joint, value in target.items()
        ])]
        for name, value in fields.items():
            setattr(request, name, value)
        return self._run(self._move, goal)

    def _run(self, action: ActionClient, goal: Any, timeout: float = 30.0) -> Any:
        node = self.client
        assert action.wait_for_server(timeout), f'no action server in {timeout} s'
        sent = node.in_executor(lambda: action.send_goal_async(goal))
        handle = node.result(sent, timeout, 'answer to the goal')
        assert handle.accepted, 'the goal was rejected'
        future = node.in_executor(handle.get_result_async)
        return node.result(future, timeout, 'result').result
