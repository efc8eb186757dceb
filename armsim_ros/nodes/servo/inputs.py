# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a stream reads: its commands, joint states and the planning scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
import math
import threading
import time
from typing import Any

from control_msgs.msg import JointJog as JointJogMessage
from geometry_msgs.msg import PoseStamped, TwistStamped
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningSceneWorld
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from moveit_msgs.srv import GetPlanningScene, ServoCommandType
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import ServoParameters
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.collision_object import (
    attached_from_message,
    object_from_message,
)
from armsim_ros.nodes.conversions.geometry import pose_from_message
from armsim_ros.nodes.conversions.planning_scene import (
    Component,
    scene_to_message,
    update_from_message,
    world_from_message,
)
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.planning.scene.planning_scene import PlanningScene
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
        self._node, self._inbox, self._now_ns, self._frame_named = node, inbox, now_ns, frame_named
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
        self._inbox, self._chosen, self._pause, self._node = inbox, chosen, pause, node
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


class JointPositions:
    """
    The newest position of every joint.

    :param topics: joint states; several robots may have a topic each.
    :param needed: joints without which no command is followed; others keep their default until
        a message has them.
    """

    def __init__(
        self, node: PollingNode, kinematics: KinematicModel, topics: Sequence[str],
        needed: Sequence[str],
    ) -> None:
        self._node, self._kinematics = node, kinematics
        self._places = {name: place for place, name in enumerate(kinematics.names)}
        self._missing = set(needed)
        self._reading = threading.Lock()
        #: (n,) as of the messages that were read [rad or m].
        self.q: Vector = kinematics.default()
        #: Of the newest message [ns].
        self.stamp_ns = 0
        profile = QoSProfile(depth=4, reliability=qos.COMMAND.reliability)
        self.subscriptions = [
            node.poll(JointState, topic, self._receive, profile) for topic in topics]

    def read(self) -> None:
        """Read the messages that have come in; from any thread."""
        with self._reading:
            self._node.catch_up(*self.subscriptions)

    @property
    def missing(self) -> tuple[str, ...]:
        """Needed joints that no message has had yet."""
        return tuple(sorted(self._missing))

    def _receive(self, message: JointState) -> None:
        names, values = message.name, message.position
        if len(names) != len(values):
            self._node.get_logger().warning(
                f'joint state dropped: {len(names)} names and {len(values)} positions',
                throttle_duration_sec=1.0)
            return
        q = self.q.copy()
        for name, value in zip(names, values, strict=True):
            place = self._places.get(name)
            if place is not None and math.isfinite(value):
                q[place] = value
                self._missing.discard(name)
        self.q = self._kinematics.apply_mimic(q)
        self.stamp_ns = ns_from_time(message.header.stamp)


_SAME_NS = 60_000_000
"""Clocks that differ by less are the same clock [ns]; their messages are a step behind."""


class StreamClock:
    """
    The node's time.

    A simulation that runs in real time keeps the wall clock's time; then the wall clock is
    read, which is finer than /clock. Otherwise, as in a pause, /clock is, which is subscribed
    to only then: stamps of joint states show as well that time is what it seems.
    """

    def __init__(self, node: PollingNode) -> None:
        self._node = node
        self._stamp_ns = 0
        self._simulated = bool(node.get_parameter('use_sim_time').value)
        #: Whether simulated time and the wall clock have parted.
        self.parted = False

    def look(self, stamp_ns: int) -> None:
        """
        Compare the clocks; the node has just caught up with its topics.

        :param stamp_ns: the newest stamp of joint states, 0 where none has come.
        """
        self._stamp_ns = stamp_ns
        if self._simulated and stamp_ns:
            self.parted = abs(self._simulated_ns() - time.time_ns()) > _SAME_NS
            if self.parted:
                self._node.follow_clock()

    def now_ns(self) -> int:
        """Return the time [ns]."""
        return self._simulated_ns() if self.parted else time.time_ns()

    def _simulated_ns(self) -> int:
        """Return the time of /clock, or of joint states where that is later."""
        return max(int(self._node.get_clock().now().nanoseconds), self._stamp_ns)


_SERVICE = 'get_planning_scene'
_LOOK = 1.0
"""Period of searching for a server of the scene [s]."""
_PATIENCE = 3
"""After so many searches without success, this node serves the scene if enabled."""


class SceneFollower:
    """
    Keeps a scene equal to that of the node that serves ``get_planning_scene``.

    The scene has the present robot state at each change, as where an attached object is on its
    link depends on it, and in each answer.

    :param states: the present robot state.
    :param topic: of the changes.
    :param serves: serve the scene from here where no other node does.
    """

    def __init__(
        self, node: PollingNode, scene: PlanningScene, states: JointPositions, topic: str, *,
        serves: bool,
    ) -> None:
        self._node, self._scene, self._states, self._serves = node, scene, states, serves
        self._own: Any = None
        self._looks = 0
        self._following = False
        self._client = node.create_client(GetPlanningScene, _SERVICE)
        node.create_subscription(PlanningSceneMessage, topic, self._receive, QoSProfile(depth=100))
        # MoveIt's own topics of changes, the only sources where no node serves a scene.
        for kind, name, take in (
            (CollisionObject, 'collision_object',
             lambda message: scene.apply_object(object_from_message(message))),
            (AttachedCollisionObject, 'attached_collision_object',
             lambda message: scene.apply_attached(attached_from_message(message))),
            (PlanningSceneWorld, 'planning_scene_world',
             lambda message: scene.apply(world_from_message(message))),
        ):
            node.create_subscription(
                kind, name, partial(self._change, name, take), QoSProfile(depth=100))
        self._timer = node.create_timer(
            _LOOK, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._look()

    def _look(self) -> None:
        others = self._node.count_services(_SERVICE) - (self._own is not None)
        if others <= 0:
            self._following = False
            self._looks += 1
            if self._serves and self._own is None and self._looks > _PATIENCE:
                self._own = self._node.create_service(GetPlanningScene, _SERVICE, self._answer)
                self._node.get_logger().info(
                    'no other node serves the planning scene; it is empty')
            return
        if self._own is not None:
            self._node.destroy_service(self._own)
            self._own = None
        if not self._following and self._client.service_is_ready():
            self._following = True
            request = GetPlanningScene.Request()
            request.components.components = int(Component.ALL)
            self._client.call_async(request).add_done_callback(self._take_all)

    def _take_all(self, future: Any) -> None:
        response = future.result()
        if response is not None:
            self._receive(response.scene)

    def _receive(self, message: PlanningSceneMessage) -> None:
        scene, state = self._scene, message.robot_state.joint_state
        self._update_state()
        if state.name:  # joint states report positions sooner
            positions = scene.kinematic_model.positions(scene.q)
            message.robot_state.joint_state = JointState(
                name=list(positions), position=list(positions.values()))
        try:
            scene.apply(update_from_message(message, scene.model_frame))
        except PlanningError as error:
            self._node.get_logger().error(f'planning scene: {error}; requesting the whole scene')
            self._following = False

    def _update_state(self) -> None:
        self._states.read()
        self._scene.set_state(self._states.q)

    def _change(self, topic: str, take: Callable[[Any], object], message: Any) -> None:
        self._update_state()
        try:
            take(message)
        except PlanningError as error:
            self._node.get_logger().error(f'{topic}: {error}')

    def _answer(
        self, request: GetPlanningScene.Request, response: GetPlanningScene.Response
    ) -> GetPlanningScene.Response:
        self._update_state()
        requested = Component(request.components.components) or Component.ALL
        response.scene = scene_to_message(self._scene, requested)
        return response
