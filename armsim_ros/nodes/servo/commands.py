# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The three command topics and the services that select among them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from control_msgs.msg import JointJog as JointJogMessage
from geometry_msgs.msg import PoseStamped, TwistStamped
from moveit_msgs.srv import ServoCommandType
from std_srvs.srv import SetBool, Trigger

from armsim_ros.config.servo import ServoParameters
from armsim_ros.errors import PlanningError
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.geometry import pose_from_message
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.servo.commands import (
    Command,
    CommandInbox,
    CommandType,
    finite_vector,
    InvalidCommandError,
    JointJog,
    PoseTarget,
    Twist,
)


class CommandTopics:
    """
    Reads commands into the inbox.

    :param now_ns: returns the time [ns].
    :param frame_named: called with the frame of each twist and pose.
    """

    def __init__(
        self, node: PollingNode, inbox: CommandInbox, parameters: ServoParameters,
        now_ns: Callable[[], int], frame_named: Callable[[str], None]
    ) -> None:
        self._node = node
        self._inbox = inbox
        self._now_ns = now_ns
        self._frame_named = frame_named
        self._warned = False
        self.subscriptions = {
            CommandType.TWIST: node.poll(
                TwistStamped, parameters.cartesian_command_in_topic, self._twist, qos.COMMAND),
            CommandType.JOINT_JOG: node.poll(
                JointJogMessage, parameters.joint_command_in_topic, self._jog, qos.COMMAND),
            CommandType.POSE: node.poll(
                PoseStamped, parameters.pose_command_in_topic, self._pose, qos.COMMAND),
        }

    def _twist(self, message: TwistStamped) -> None:
        self._frame_named(message.header.frame_id)
        self._take(CommandType.TWIST, message, _read_twist)

    def _jog(self, message: JointJogMessage) -> None:
        if len(message.displacements) and not self._warned:
            self._warned = True
            self._node.get_logger().warning(
                'displacements of joint jogs are not used; velocities are')
        self._take(CommandType.JOINT_JOG, message, _read_jog)

    def _pose(self, message: PoseStamped) -> None:
        self._frame_named(message.header.frame_id)
        self._take(CommandType.POSE, message, _read_pose)

    def _take(self, kind: CommandType, message: Any, read: Callable[[Any], Command]) -> None:
        stamp = ns_from_time(message.header.stamp)
        self._inbox.receive(kind, lambda: read(message), stamp, self._now_ns())


class CommandServices:
    """
    ``switch_command_type``, ``pause_servo``, and Humble's ``start_servo``, ``stop_servo``.

    :param pause: called with whether to pause.
    :param chosen: called when commands may be followed from now on.
    """

    def __init__(
        self, node: PollingNode, inbox: CommandInbox, pause: Callable[[bool], None],
        chosen: Callable[[], None],
    ) -> None:
        self._inbox = inbox
        self._chosen = chosen
        self._pause = pause
        self._node = node
        self.paused = False
        node.create_service(ServoCommandType, '~/switch_command_type', self._switch)
        node.create_service(SetBool, '~/pause_servo', self._pause_or_go_on)
        node.create_service(Trigger, '~/start_servo', self._start)
        node.create_service(Trigger, '~/stop_servo', self._stop)

    def _switch(
        self, request: ServoCommandType.Request, response: ServoCommandType.Response
    ) -> ServoCommandType.Response:
        try:
            self._inbox.choose(CommandType(request.command_type))
            self._chosen()
            response.success = True
        except ValueError:
            allowed = ', '.join(f'{kind.value} {kind.name}' for kind in CommandType)
            self._node.get_logger().error(
                f'switch_command_type: {request.command_type} is not a command type; '
                f'allowed: {allowed}')
            response.success = False
        return response

    def _pause_or_go_on(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        response.success = True
        if request.data == self.paused:
            response.message = 'Requested pause state is already active.'
        else:
            self._set(request.data)
            response.message = 'Servoing disabled' if request.data else 'Servoing enabled'
        return response

    def _start(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._inbox.topic_chooses = True
        self._chosen()
        self._set(False)
        response.success, response.message = True, 'Servoing enabled'
        return response

    def _stop(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._set(True)
        response.success, response.message = True, 'Servoing disabled'
        return response

    def _set(self, paused: bool) -> None:
        self.paused = paused
        self._pause(paused)


def _read_twist(message: TwistStamped) -> Twist:
    twist, frame = message.twist, message.header.frame_id
    if not frame:
        raise InvalidCommandError('header.frame_id is empty')
    linear = (twist.linear.x, twist.linear.y, twist.linear.z)
    angular = (twist.angular.x, twist.angular.y, twist.angular.z)
    return Twist(
        frame, finite_vector('twist.linear', linear), finite_vector('twist.angular', angular))


def _read_jog(message: JointJogMessage) -> JointJog:
    names, velocities = tuple(message.joint_names), message.velocities
    if len(names) != len(velocities):
        raise InvalidCommandError(
            f'joint_names has {len(names)} entries, velocities has {len(velocities)}; both '
            'need one per joint')
    return JointJog(names, finite_vector('velocities', velocities))


def _read_pose(message: PoseStamped) -> PoseTarget:
    position, turn = message.pose.position, message.pose.orientation
    finite_vector('pose.position', (position.x, position.y, position.z))
    if not finite_vector('pose.orientation', (turn.x, turn.y, turn.z, turn.w)).any():
        raise InvalidCommandError('pose.orientation is a quaternion of length 0')
    if not message.header.frame_id:
        raise InvalidCommandError('header.frame_id is empty')
    try:
        return PoseTarget(message.header.frame_id, pose_from_message(message.pose))
    except PlanningError as error:
        raise InvalidCommandError(f'pose: {error}') from None
