# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Topics of crisp_controllers and of FZI's cartesian_controllers.

Those of crisp_controllers are relative to the manager's namespace, not to the controller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, TwistStamped, Wrench, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from armsim_ros.config.controllers.compliance import (
    CrispPoseBroadcasterParameters,
    TipBroadcasterParameters,
)
from armsim_ros.control.broadcasters.sensor_broadcaster import SensorSample
from armsim_ros.control.compliance.cartesian_controller import (
    CartesianAdmittanceController,
    ComplianceController,
)
from armsim_ros.control.compliance.net_force_controllers import NetForceController
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.qos import WantedPublisher


class ComplianceTopics:
    """
    ``target_pose``, ``target_joint``, ``target_wrench`` and what the parameters name.

    A target topic with several publishers is ignored, so that no two programs pull at the arm.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: ComplianceController[Any]) -> None:
        self._node, self._controller = node, controller
        self._subscriptions: list[Any] = []
        self._subscribe(PoseStamped, 'target_pose', self._pose)
        self._subscribe(JointState, 'target_joint', lambda message: controller.receive_joints(
            message.name, message.position, message.velocity))
        self._subscribe(WrenchStamped, 'target_wrench', lambda message: controller.receive_wrench(
            _numbers(message.wrench)))
        self._subscribe(Float64MultiArray, controller.parameters.variable_stiffness.topic,
                        self._stiffness)
        if isinstance(controller, CartesianAdmittanceController):
            self._subscriptions.append(node.create_subscription(
                WrenchStamped, controller.parameters.ft_sensor.topic, self._measured,
                qos.COMMAND))
            self._subscribe(
                Float64MultiArray, controller.parameters.variable_admittance_stiffness.topic,
                self._yielding_stiffness)

    def _subscribe(self, kind: Any, topic: str, receive: Callable[[Any], object]) -> None:
        def checked(message: Any) -> None:
            if not self._controller.active:
                return
            publishers = self._node.count_publishers(topic)
            if publishers > 1:
                self._controller.ignore(topic, publishers)
            else:
                receive(message)

        self._subscriptions.append(
            self._node.create_subscription(kind, topic, checked, qos.COMMAND))

    def _pose(self, message: PoseStamped) -> None:
        self._controller.receive_pose(message.header.frame_id, *_pose_parts(message))

    def _stiffness(self, message: Float64MultiArray) -> None:
        if self._controller.parameters.variable_stiffness.enabled:
            self._controller.receive_stiffness(message.data)

    def _yielding_stiffness(self, message: Float64MultiArray) -> None:
        controller = self._controller
        if (isinstance(controller, CartesianAdmittanceController)
                and controller.parameters.variable_admittance_stiffness.enabled):
            controller.receive_yielding_stiffness(message.data)

    def _measured(self, message: WrenchStamped) -> None:
        controller = self._controller
        if controller.active and isinstance(controller, CartesianAdmittanceController):
            controller.receive_measured(_numbers(message.wrench))


class NetForceTopics:
    """
    Targets and feedback of FZI's cartesian_controllers, below the controller's name.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: NetForceController[Any]) -> None:
        self._controller = controller
        self._subscriptions: list[Any] = []
        self._frame = controller.parameters.robot_base_link
        if controller.takes_poses:
            self._subscriptions.append(node.create_subscription(
                PoseStamped, '~/target_frame', self._take_pose, qos.COMMAND))
        if controller.takes_wrenches:
            for topic, receive in (('~/target_wrench', controller.receive_wrench),
                                   ('~/ft_sensor_wrench', controller.receive_measured)):
                self._subscriptions.append(node.create_subscription(
                    WrenchStamped, topic, partial(_pass_wrench, receive), qos.COMMAND))
        self._pose = WantedPublisher(node, PoseStamped, '~/current_pose', qos.STATE)
        self._twist = WantedPublisher(node, TwistStamped, '~/current_twist', qos.STATE)

    def _take_pose(self, message: PoseStamped) -> None:
        self._controller.receive_pose(message.header.frame_id, *_pose_parts(message))

    def publish(self) -> None:
        """Publish where the internal model is, if it is requested."""
        feedback = self._controller.feedback()
        if feedback is None or not self._controller.parameters.solver.publish_state_feedback:
            return
        time_ns, pose, twist = feedback
        values = (*pose[:3, 3], *quat_xyzw_from_matrix(pose[:3, :3]))
        message: Any = PoseStamped()
        parts: Any = message.pose.position, message.pose.orientation
        for publisher, numbers in ((self._pose, values), (self._twist, twist)):
            if publisher is self._twist:
                message = TwistStamped()
                parts = message.twist.linear, message.twist.angular
            if not publisher.wanted(time_ns):
                continue
            message.header.frame_id = self._frame
            fill_time(message.header.stamp, time_ns)
            _fill(parts, numbers)
            publisher.publish(message, time_ns)


class TipTopic:
    """``current_pose`` or ``current_twist``."""

    def __init__(self, node: Node, parameters: TipBroadcasterParameters) -> None:
        self._message: Any
        if isinstance(parameters, CrispPoseBroadcasterParameters):
            self._message, topic, frame = PoseStamped(), 'current_pose', parameters.base_frame
            self._parts = self._message.pose.position, self._message.pose.orientation
        else:
            self._message, topic = TwistStamped(), 'current_twist'
            frame = parameters.end_effector_frame
            self._parts = self._message.twist.linear, self._message.twist.angular
        self._message.header.frame_id = frame
        self._publisher = WantedPublisher(node, type(self._message), topic, qos.STATE)

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample."""
        if not self._publisher.wanted(sample.time_ns):
            return
        fill_time(self._message.header.stamp, sample.time_ns)
        _fill(self._parts, sample.values)
        self._publisher.publish(self._message, sample.time_ns)


def _fill(parts: Iterable[Any], values: Iterable[float]) -> None:
    """Write values into the fields of messages, in their order."""
    numbers = iter(values)
    for part in parts:
        for axis in part.get_fields_and_field_types():
            setattr(part, axis, float(next(numbers)))


def _pose_parts(message: PoseStamped) -> tuple[tuple[float, ...], tuple[float, ...]]:
    position, turn = message.pose.position, message.pose.orientation
    return (position.x, position.y, position.z), (turn.x, turn.y, turn.z, turn.w)


def _pass_wrench(receive: Callable[[tuple[float, ...]], object], message: WrenchStamped) -> None:
    receive(_numbers(message.wrench))


def _numbers(wrench: Wrench) -> tuple[float, ...]:
    force, torque = wrench.force, wrench.torque
    return force.x, force.y, force.z, torque.x, torque.y, torque.z
