# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a stream's motion goes: to a controller that is watched, as commands; its status."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
import time
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from control_msgs.msg import JointTrajectoryControllerState
from controller_manager_msgs.msg import ControllerManagerActivity
from moveit_msgs.msg import ServoStatus as ServoStatusMessage
import numpy as np
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rclpy.subscription import Subscription
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ARRAY, ServoParameters
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.servo.commands import Finding
from armsim_ros.servo.stream import Cycle, ServoStream
from armsim_ros.servo.trajectory_window import TrajectoryWindow, WindowPoints

_BUSY = (GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING)
#: Actions of move_group that move the arm when they have planned.
PLANNING = ('move_action', 'execute_trajectory', 'sequence_move_group', 'execute_task_solution')
_FRESH_NS = 200_000_000
#: It takes no longer than this from a subscription to the first state, or from the first message
#: of a publisher until the graph knows it [s].
_FIRST = 0.5


class ActionWatch:
    """
    Whether an action of another client has goals.

    A server that dies publishes no end of its goals; they end with its publisher.
    """

    def __init__(self, node: PollingNode, action: str) -> None:
        self._node, self._topic = node, f'{action}/_action/status'
        self._runs = False
        self._since = 0.0
        self._servers: set[bytes] = set()
        profile = QoSProfile(
            depth=1, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability)
        self.subscription = node.poll(GoalStatusArray, self._topic, self._receive, profile)

    @property
    def busy(self) -> bool:
        """Whether a goal runs, and a server that may have published so is still there."""
        if not self._runs:
            return False
        present = self._present()
        if not self._servers:  # the graph may know a publisher later than its message comes
            self._servers = present
            return bool(present) or time.monotonic() - self._since < _FIRST
        return not self._servers.isdisjoint(present)

    def _receive(self, message: GoalStatusArray) -> None:
        self._runs = any(entry.status in _BUSY for entry in message.status_list)
        if self._runs:
            self._since, self._servers = time.monotonic(), self._present()

    def _present(self) -> set[bytes]:
        return {bytes(each.endpoint_gid)
                for each in self._node.get_publishers_info_by_topic(self._topic)}


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
            self._activity, qos.DESCRIPTION)
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
            and self._node.count_publishers(self._state_topic) > 0)

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
        # The topic of a node between servo and a controller names none that the manager knows.
        self.lifecycle = states.get(self._name, 'not loaded' if self.lifecycle else '')


class JointCommands:
    """
    Publishes what a stream brings, as trajectories or as plain numbers.

    :param topic: of the controller.
    :param names: (m,) of the joints.
    """

    def __init__(
        self, node: PollingNode, topic: str, names: tuple[str, ...], parameters: ServoParameters
    ) -> None:
        self.topic = topic
        self._plain = parameters.command_out_type == ARRAY
        kind = Float64MultiArray if self._plain else JointTrajectory
        self._publisher = node.create_publisher(kind, topic, qos.STATE)
        self._window = TrajectoryWindow(names, round(parameters.max_expected_latency * 1e9))
        self._period_ns = round(parameters.publish_period * 1e9)
        self._names = names
        #: Fields and number of the points -> the message that has them.
        self._messages: dict[tuple[tuple[str, ...], int], SerializedMessage] = {}

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self._publisher.get_subscription_count() > 0

    def start(self, now_ns: int, stream: ServoStream) -> None:
        """Begin anew with a stream that rests at the controller's reference."""
        self._window.start(now_ns, stream.state)

    def replan(
        self, now_ns: int, cycle_ns: int, stream: ServoStream, step: Callable[[], object]
    ) -> None:
        """Replace what lies ahead, see :meth:`TrajectoryWindow.replan`; plain numbers are now."""
        if not self._plain:
            self._window.replan(now_ns, cycle_ns, self._period_ns, stream, step)

    def go_back(self, now_ns: int, stream: ServoStream) -> bool:
        """Forget what lies too far ahead, see :meth:`TrajectoryWindow.go_back`."""
        return self._plain or self._window.go_back(now_ns, self._period_ns, stream)

    def publish(
        self, cycle_ns: int, cycle: Cycle, stream: ServoStream, parameters: ServoParameters
    ) -> None:
        """Publish what a cycle of a stream has brought."""
        if self._plain:
            values = (cycle.positions if parameters.publish_joint_positions else cycle.velocities)
            self._publisher.publish(Float64MultiArray(data=values.tolist()))
            return
        self._window.add(cycle_ns, stream.state)
        points = self._window.points(accelerations=parameters.publish_joint_accelerations)
        if points is None:
            return
        fields = tuple(name for name, requested in (
            ('positions', parameters.publish_joint_positions),
            ('velocities', parameters.publish_joint_velocities),
            ('accelerations', parameters.publish_joint_accelerations),
        ) if requested)
        self._publisher.publish(self._serialized(points, fields))

    def _serialized(self, points: WindowPoints, fields: tuple[str, ...]) -> bytes:
        """Return a trajectory as it is sent."""
        shape = fields, len(points.spans_ns)
        message = self._messages.get(shape)
        if message is None:
            message = self._messages[shape] = self._make(*shape)
        message.set_numbers(
            np.concatenate([getattr(points, name) for name in fields], axis=1).ravel())
        message.set_durations(points.spans_ns)
        return message.at(points.stamp_ns)

    def _make(self, fields: tuple[str, ...], count: int) -> SerializedMessage:
        numbers = array('d', [0.0] * len(self._names))
        filled: dict[str, Any] = dict.fromkeys(fields, numbers)
        points = [JointTrajectoryPoint(**filled) for _ in range(count)]
        message = JointTrajectory(joint_names=list(self._names), points=points)
        return SerializedMessage(
            message, [message.header.stamp],
            [(point, name) for point in points for name in fields],
            [point.time_from_start for point in points])


class StatusTopic:
    """Publishes the result of each cycle."""

    def __init__(self, node: PollingNode, topic: str) -> None:
        self._publisher = node.create_publisher(ServoStatusMessage, topic, qos.STATE)
        self._finding: Finding | None = None
        self._serialized = b''

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self._publisher.get_subscription_count() > 0

    def publish(self, finding: Finding) -> None:
        """Publish a finding; late subscribers get the last."""
        if finding != self._finding:
            self._finding = finding
            self._serialized = serialize_message(
                ServoStatusMessage(code=int(finding.code), message=finding.message))
        self._publisher.publish(self._serialized)
