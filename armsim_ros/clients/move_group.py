# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A typed client of what move_group does and answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree

from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.srv import GetPositionFK, GetStateValidity

from armsim_ros.arrays import Matrix
from armsim_ros.clients.client_node import ClientNode, PATIENCE
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.motion import plan_goal, robot_state
from armsim_ros.nodes.conversions.geometry import pose_from_message


class MoveGroupClient:
    """
    Plans and executes through move_group.

    :param client: the node to use.
    :param namespace: of move_group, '' or such as ``/left``.
    """

    def __init__(self, client: ClientNode, namespace: str = '') -> None:
        self.client, self._namespace = client, namespace
        # The servers find them before they are needed.
        client.action(MoveGroup, f'{namespace}/move_action')
        client.action(ExecuteTrajectory, f'{namespace}/execute_trajectory')

    def named_states(self) -> dict[tuple[str, str], dict[str, float]]:
        """Return (group, state) -> joint -> position [rad or m], from move_group's SRDF."""
        text = ParameterClient(self.client, f'{self._namespace}/move_group').get(
            'robot_description_semantic')
        return {
            (state.get('group', ''), state.get('name', '')): {
                joint.get('name', ''): float(joint.get('value', ''))
                for joint in state.findall('joint')}
            for state in ElementTree.fromstring(text).findall('group_state')}

    def plan(self, group: str, target: Mapping[str, float], **request: Any) -> Any:
        """Plan to joint positions [rad or m] and return the result."""
        return self._send_move(group, target, True, request, PATIENCE)

    def move(self, group: str, target: Mapping[str, float], *, timeout: float = PATIENCE,
             **request: Any) -> Any:
        """
        Plan to joint positions [rad or m], execute, and return the result.

        :param timeout: of planning and motion together [s].
        :param request: fields of the request.
        :raises AssertionError: the result does not come in time.
        """
        return self._send_move(group, target, False, request, timeout)

    def execute(self, trajectory: Any, controllers: tuple[str, ...] = ()) -> Any:
        """Execute a ``RobotTrajectory`` and return the result."""
        goal = ExecuteTrajectory.Goal(trajectory=trajectory, controller_names=list(controllers))
        return self._run(ExecuteTrajectory, 'execute_trajectory', goal)

    def pose(self, link: str, positions: Mapping[str, float], frame: str) -> Matrix:
        """Return the pose of a link in a frame at joint positions [rad or m], (4, 4)."""
        request = GetPositionFK.Request(fk_link_names=[link], robot_state=robot_state(positions))
        request.header.frame_id = frame
        answer = self.client.call(f'{self._namespace}/compute_fk', GetPositionFK, request)
        return pose_from_message(answer.pose_stamped[0].pose)

    def valid(self, group: str, positions: Mapping[str, float]) -> bool:
        """Return whether joint positions [rad or m] are inside the limits and touch nothing."""
        request = GetStateValidity.Request(group_name=group, robot_state=robot_state(positions))
        return bool(self.client.call(
            f'{self._namespace}/check_state_validity', GetStateValidity, request).valid)

    def _send_move(
        self, group: str, target: Mapping[str, float], plan_only: bool, fields: Mapping[str, Any],
        timeout: float
    ) -> Any:
        goal = plan_goal(group, target, plan_only=plan_only, speed=0.0, acceleration=0.0)
        for name, value in fields.items():
            setattr(goal.request, name, value)
        return self._run(MoveGroup, 'move_action', goal, timeout)

    def _run(self, kind: type[Any], action: str, goal: Any, timeout: float = PATIENCE) -> Any:
        run = self.client.goal(kind, f'{self._namespace}/{action}', goal)
        assert self.client.result(run.accepted, what='answer to the goal'), (
            'the goal was rejected')
        return self.client.result(run.result, timeout, 'result').result
