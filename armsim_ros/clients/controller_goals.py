# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sends the parts of a trajectory to controllers of a running stack, to all or to none."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing, suppress

from std_msgs.msg import String

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.clients.node import GoalRun
from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import ControllerError
from armsim_ros.nodes.move_group.execution.controller_actions import action_of, ControllerAction
from armsim_ros.trajectory import JointTrajectory

#: Time for the server of an action to appear, for the reason of a refusal to come, which is
#: published for 10 s, and for a cancelled goal to end [s].
SERVER, REASON, END = 20.0, 5.0, 10.0


class ControllerGoal:
    """
    An accepted goal of a controller.

    :param client: the node that has sent it.
    """

    def __init__(self, client: ClientNode, action: ControllerAction, run: GoalRun) -> None:
        self._client, self._action, self._run = client, action, run

    def failure(self, timeout: float) -> str:
        """
        Wait for the end, and return why the goal did not succeed; '' where it did.

        :param timeout: [s].
        :raises AssertionError: it does not end in time.
        """
        name = self._action.settings.name
        answer = self._client.result(self._run.result, timeout, f"result of controller '{name}'")
        reason = self._action.failure(answer.status, answer.result)
        return f"controller '{name}': {reason}" if reason else ''


def send_parts(
    client: ClientNode, parts: Sequence[tuple[MoveItControllerSettings, JointTrajectory]]
) -> list[ControllerGoal]:
    """
    Send each controller its part of a trajectory; a gripper gets its end.

    If one refuses, the goals of the others are cancelled, and have ended when this raises.

    :raises ControllerError: a controller refuses, or has no action.
    :raises PlanningError: a controller cannot run such a part.
    """
    warn = client.node.get_logger().warning
    actions = [action_of(settings, warn) for settings, _ in parts]
    goals = [action.goal(part) for action, (_, part) in zip(actions, parts, strict=True)]
    names = [f'/{action.settings.action_name.lstrip("/")}' for action in actions]
    for action, name in zip(actions, names, strict=True):
        if not client.has_server(action.type, name, SERVER):
            raise ControllerError(f'the action {name} has no server')
    runs = [client.goal(action.type, name, goal)
            for action, name, goal in zip(actions, names, goals, strict=True)]
    refusing, answered = list[ControllerAction](), False
    try:
        refusing = [action for action, run in zip(actions, runs, strict=True)
                    if not client.result(run.accepted)]
        answered = True
    finally:
        if refusing or not answered:
            for run in runs:
                run.cancel()
    if refusing:
        reason = _reason(client, refusing[0])
        for run in runs:
            client.result(run.result, END, 'end of a cancelled goal')
        raise ControllerError(f"controller '{refusing[0].settings.name}' refuses: {reason}")
    return [ControllerGoal(client, action, run) for action, run in zip(actions, runs, strict=True)]


def _reason(client: ClientNode, action: ControllerAction) -> str:
    """Return why a controller has refused a goal."""
    topic = f'/{action.reason_topic.lstrip("/")}'
    with closing(client.collect(topic, String, LATCHED)) as reasons, suppress(AssertionError):
        if client.node.count_publishers(topic):
            return str(reasons.wait(timeout=REASON)[-1].data)
    return 'the reason is in its log'
