# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of the controller that is streamed to: its state, its reference, its goals."""

from __future__ import annotations

from collections.abc import Sequence
import time

from action_msgs.msg import GoalStatus, GoalStatusArray
from control_msgs.msg import JointTrajectoryControllerState
from controller_manager_msgs.msg import ControllerManagerActivity
import numpy as np
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from armsim_ros.arrays import Vector
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode

_BUSY = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)
#: Actions of move_group that move the arm when they have planned.
PLANNING = ('/move_action', '/execute_trajectory', '/sequence_move_group',
            '/execute_task_solution')
_FRESH_NS = 200_000_000
#: It takes no longer than this from a subscription to the first state [s].
_FIRST = 0.5


class ActionWatch:
    """Whether an action of another client has goals."""

    def __init__(self, node: PollingNode, action: str) -> None:
        self.busy = False
        profile = QoSProfile(
            depth=1, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
        )
        self.subscription = node.poll(
            GoalStatusArray, f'{action}/_action/status', self._receive, profile
        )

    def _receive(self, message: GoalStatusArray) -> None:
        self.busy = any(entry.status in _BUSY for entry in message.status_list)


class ControllerWatch:
    """
    Follows a controller by its topics.

    :param topic: where the controller gets its commands, such as
        ``/arm/joint_controller/joint_trajectory``; the rest of its names follow from it.
    :param joints: (m,) whose reference is asked for.
    """

    def __init__(self, node: PollingNode, topic: str, joints: Sequence[str]) -> None:
        self.controller = topic.rpartition('/')[0]
        namespace, _, self._name = self.controller.rpartition('/')
        self._state_topic = f'{self.controller}/controller_state'
        self._joints = tuple(joints)
        self._newest: JointTrajectoryControllerState | None = None
        self._node = node
        #: As reported by controller_manager; '' until then.
        self.lifecycle = ''
        #: Read where the reference is asked for; None before ``follow_state``.
        self.state: Subscription | None = None
        self._followed_since = 0.0
        self._own = ActionWatch(node, f'{self.controller}/follow_joint_trajectory')
        self._plans = [ActionWatch(node, name) for name in PLANNING]
        node.create_subscription(
            ControllerManagerActivity, f'{namespace}/controller_manager/activity',
            self._activity, qos.DESCRIPTION,
        )
        #: To be read in each cycle, and those to be read while the arm is streamed to.
        self.own = self._own.subscription
        self.subscriptions = [each.subscription for each in self._plans]

    @property
    def goal_runs(self) -> bool:
        """Whether the controller follows a client's goal."""
        return self._own.busy

    @property
    def plan_runs(self) -> bool:
        """Whether move_group is about to move the arm."""
        return any(each.busy for each in self._plans)

    @property
    def inactive(self) -> str:
        """What is wrong with the controller's state, '' where it is active or unknown."""
        if self.lifecycle in ('', 'active'):
            return ''
        return f"controller '{self.controller}' is {self.lifecycle}"

    def follow_state(self) -> None:
        """Follow the controller's state; commands may come from now on."""
        if self.state is None:
            self._followed_since = time.monotonic()
            self.state = self._node.poll(
                JointTrajectoryControllerState, self._state_topic, self._keep,
                QoSProfile(depth=1, reliability=qos.COMMAND.reliability))

    @property
    def awaited(self) -> bool:
        """Whether the controller's first state is still on its way."""
        return (
            self._newest is None
            and time.monotonic() - self._followed_since < _FIRST
            and self._node.count_publishers(self._state_topic) > 0
        )

    def reference(self, now_ns: int) -> Vector | None:
        """Return where the controller wants the joints now (m,) [rad or m], None if unknown."""
        if self.state is None:
            return None
        self._node.catch_up(self.state)
        state = self._newest
        if state is None or abs(now_ns - ns_from_time(state.header.stamp)) > _FRESH_NS:
            return None
        known = dict(zip(state.joint_names, state.reference.positions, strict=False))
        if not all(name in known for name in self._joints):
            return None
        return np.array([known[name] for name in self._joints])

    def _keep(self, message: JointTrajectoryControllerState) -> None:
        self._newest = message

    def _activity(self, message: ControllerManagerActivity) -> None:
        states = {entry.name: entry.state.label for entry in message.controllers}
        self.lifecycle = states.get(self._name, 'not loaded')
