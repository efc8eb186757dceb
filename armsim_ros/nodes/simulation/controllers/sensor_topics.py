# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of sensors and of compliant controllers (crisp_controllers, cartesian_controllers)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
import math
from typing import Any, Generic, TypeVar

from control_msgs.msg import Float64Values, Keys
from geometry_msgs.msg import PoseStamped, TransformStamped, TwistStamped, Wrench, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64, Float64MultiArray
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.broadcasters import (
    BroadcasterParameters,
    ForceTorqueSensorBroadcasterParameters,
    IMUSensorBroadcasterParameters,
    PoseBroadcasterParameters,
    SpeedScalingStateBroadcasterParameters,
    StateInterfacesBroadcasterParameters,
)
from armsim_ros.config.controllers.compliance import (
    CrispPoseBroadcasterParameters,
    TipBroadcasterParameters,
)
from armsim_ros.control.broadcaster import SensorSample
from armsim_ros.control.compliance.cartesian_controller import (
    CartesianAdmittanceController,
    ComplianceController,
)
from armsim_ros.control.compliance.net_force_controllers import NetForceController
from armsim_ros.control.controller import Rate
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.qos import WantedPublisher


class ComplianceTopics:
    """
    ``target_pose``, ``target_joint``, ``target_wrench`` and what the parameters name.

    A target topic with several publishers is ignored, so that no two programs pull at the arm.
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
                WrenchStamped, controller.parameters.ft_sensor.topic, self._measured, qos.COMMAND))
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

    def publish(self, time_ns: int) -> None:
        """Publish nothing: the broadcasters show where the arm is."""

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
    """Targets and feedback of FZI's cartesian_controllers, below the controller's name."""

    def __init__(self, node: Node, controller: NetForceController[Any]) -> None:
        self._controller = controller
        self._subscriptions: list[Any] = []
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

    def publish(self, _: int) -> None:
        """Publish where the internal model is, if it is requested."""
        feedback = self._controller.feedback()
        if feedback is None or not self._controller.parameters.solver.publish_state_feedback:
            return
        time_ns, pose, twist = feedback
        values = [*pose[:3, 3].tolist(), *quat_xyzw_from_matrix(pose[:3, :3]).tolist()]
        message: Any = PoseStamped()
        parts: Any = message.pose.position, message.pose.orientation
        for publisher, numbers in ((self._pose, values), (self._twist, twist.tolist())):
            if publisher is self._twist:
                message = TwistStamped()
                parts = message.twist.linear, message.twist.angular
            if not publisher.wanted(time_ns):
                continue
            message.header.frame_id = self._controller.parameters.robot_base_link
            fill_time(message.header.stamp, time_ns)
            _fill_parts(parts, numbers)
            publisher.publish(message, time_ns)


ParametersT = TypeVar('ParametersT', bound=Settings)


class SampleTopics(ABC, Generic[ParametersT]):
    """
    Topics on which a broadcaster's samples are published.

    :param parameters: returns the broadcaster's parameters that are in effect.
    """

    def __init__(self, node: Node, parameters: Callable[[], ParametersT]) -> None:
        self._node, self._parameters = node, parameters
        self._taken: ParametersT | None = None
        self._open(node)
        self._follow()

    @abstractmethod
    def _open(self, node: Node) -> None:
        """Create the publishers that are there whatever the parameters are."""

    @abstractmethod
    def _take(self, parameters: ParametersT) -> None:
        """Publish with these parameters from now on."""

    @abstractmethod
    def _publish(self, sample: SensorSample) -> None:
        """Publish a sample."""

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample with the parameters that are in effect."""
        self._follow()
        self._publish(sample)

    def _follow(self) -> None:
        parameters = self._parameters()
        if parameters is not self._taken:
            self._taken = parameters
            self._take(parameters)


class TipTopic(SampleTopics[TipBroadcasterParameters]):
    """``current_pose`` or ``current_twist``."""

    def _open(self, node: Node) -> None:
        self._message: Any
        if isinstance(self._parameters(), CrispPoseBroadcasterParameters):
            self._message, topic = PoseStamped(), 'current_pose'
            self._parts = self._message.pose.position, self._message.pose.orientation
        else:
            self._message, topic = TwistStamped(), 'current_twist'
            self._parts = self._message.twist.linear, self._message.twist.angular
        self._publisher = WantedPublisher(node, type(self._message), topic, qos.STATE)

    def _take(self, parameters: TipBroadcasterParameters) -> None:
        of_pose = isinstance(parameters, CrispPoseBroadcasterParameters)
        self._message.header.frame_id = (
            parameters.base_frame if of_pose else parameters.end_effector_frame)

    def _publish(self, sample: SensorSample) -> None:
        if not self._publisher.wanted(sample.time_ns):
            return
        fill_time(self._message.header.stamp, sample.time_ns)
        _fill_parts(self._parts, sample.values.tolist())
        self._publisher.publish(self._message, sample.time_ns)


def _fill_parts(parts: tuple[Any, Any], values: list[float]) -> None:
    """Write three values into the first message, and the others into the second."""
    _fill(parts[0], values[:3])
    _fill(parts[1], values[3:])


def _pose_parts(message: PoseStamped) -> tuple[tuple[float, ...], tuple[float, ...]]:
    position, turn = message.pose.position, message.pose.orientation
    return (position.x, position.y, position.z), (turn.x, turn.y, turn.z, turn.w)


def _pass_wrench(receive: Callable[[tuple[float, ...]], object], message: WrenchStamped) -> None:
    receive(_numbers(message.wrench))


def _numbers(wrench: Wrench) -> tuple[float, ...]:
    force, torque = wrench.force, wrench.torque
    return force.x, force.y, force.z, torque.x, torque.y, torque.z


class WrenchTopics(SampleTopics[ForceTorqueSensorBroadcasterParameters]):
    """``~/wrench`` and, where there is a filter chain, messages on ``~/wrench_filtered``."""

    def _open(self, node: Node) -> None:
        self._publishers = [WantedPublisher(node, WrenchStamped, topic, qos.STATE)
                            for topic in ('~/wrench', '~/wrench_filtered')]
        self._message = WrenchStamped()

    def _take(self, parameters: ForceTorqueSensorBroadcasterParameters) -> None:
        self._topics = 2 if parameters.sensor_filter_chain else 1
        self._message.header.frame_id = parameters.frame_id

    def _publish(self, sample: SensorSample) -> None:
        """Publish a sample: force, torque."""
        requested = [publisher for publisher in self._publishers[: self._topics]
                  if publisher.wanted(sample.time_ns)]
        if not requested:
            return
        fill_time(self._message.header.stamp, sample.time_ns)
        wrench, values = self._message.wrench, sample.values.tolist()
        _fill_parts((wrench.force, wrench.torque), values)
        for publisher in requested:
            publisher.publish(self._message, sample.time_ns)


def tare_service(node: Node, tare: Callable[[], str]) -> Any:
    """
    Return the service ``~/tare``.

    :param tare: shows the present load as 0; returns why it does not.
    """
    def answer(_: Any, response: Trigger.Response) -> Trigger.Response:
        response.message = tare()
        response.success = not response.message
        return response

    return node.create_service(Trigger, '~/tare', answer, qos_profile=qos.SERVICES)


class ImuTopic(SampleTopics[IMUSensorBroadcasterParameters]):
    """``~/imu``."""

    def _open(self, node: Node) -> None:
        self._publisher = WantedPublisher(node, Imu, '~/imu', qos.STATE)

    def _take(self, parameters: IMUSensorBroadcasterParameters) -> None:
        self._message = Imu(
            orientation_covariance=parameters.static_covariance_orientation,
            angular_velocity_covariance=parameters.static_covariance_angular_velocity,
            linear_acceleration_covariance=parameters.static_covariance_linear_acceleration)
        self._message.header.frame_id = parameters.frame_id

    def _publish(self, sample: SensorSample) -> None:
        """Publish a sample: orientation, angular velocity, linear acceleration."""
        if not self._publisher.wanted(sample.time_ns):
            return
        message, values = self._message, sample.values.tolist()
        fill_time(message.header.stamp, sample.time_ns)
        _fill(message.orientation, values[:4])
        _fill(message.angular_velocity, values[4:7])
        _fill(message.linear_acceleration, values[7:])
        self._publisher.publish(message, sample.time_ns)


class PoseTopics(SampleTopics[PoseBroadcasterParameters]):
    """``~/pose``, and the same as a transform."""

    def _open(self, node: Node) -> None:
        self._publisher = WantedPublisher(node, PoseStamped, '~/pose', qos.STATE)
        self._message = PoseStamped()
        self._transform = TransformStamped()
        self._transforms: Any = None

    def _take(self, parameters: PoseBroadcasterParameters) -> None:
        self._transform.child_frame_id = parameters.tf.child_frame_id or parameters.pose_name
        self._message.header.frame_id = self._transform.header.frame_id = parameters.frame_id
        if not parameters.tf.enable:
            if self._transforms is not None:
                self._node.destroy_publisher(self._transforms)
            self._transforms = None
        elif self._transforms is None:
            self._transforms = self._node.create_publisher(TFMessage, '/tf', qos.TF)
        self._rate = Rate(parameters.tf.publish_rate or float('inf'))

    def _publish(self, sample: SensorSample) -> None:
        """Publish a sample: position, orientation."""
        values = sample.values.tolist()
        if self._publisher.wanted(sample.time_ns):
            fill_time(self._message.header.stamp, sample.time_ns)
            _fill_parts((self._message.pose.position, self._message.pose.orientation), values)
            self._publisher.publish(self._message, sample.time_ns)
        if self._transforms is None or not is_pose(values):
            return
        if self._rate.due(sample.time_ns):
            fill_time(self._transform.header.stamp, sample.time_ns)
            transform = self._transform.transform
            _fill_parts((transform.translation, transform.rotation), values)
            self._transforms.publish(TFMessage(transforms=[self._transform]))


class SpeedScalingTopic(SampleTopics[SpeedScalingStateBroadcasterParameters]):
    """``~/speed_scaling``: the pace of trajectories [%]."""

    def _open(self, node: Node) -> None:
        self._publisher = WantedPublisher(node, Float64, '~/speed_scaling', qos.STATE)

    def _take(self, parameters: SpeedScalingStateBroadcasterParameters) -> None:
        """Need none of them."""

    def _publish(self, sample: SensorSample) -> None:
        if self._publisher.wanted(sample.time_ns):
            self._publisher.publish(Float64(data=float(sample.values[0])), sample.time_ns)


class StateInterfacesTopics(SampleTopics[StateInterfacesBroadcasterParameters]):
    """``~/names``, once, and ``~/values`` in their order."""

    def _open(self, node: Node) -> None:
        self._names = node.create_publisher(Keys, '~/names', qos.LATCHED)
        self._publisher = WantedPublisher(node, Float64Values, '~/values', qos.STATE)
        self._message = Float64Values()

    def _take(self, parameters: StateInterfacesBroadcasterParameters) -> None:
        names = Keys(keys=parameters.interfaces)
        names.header.stamp = self._node.get_clock().now().to_msg()
        self._names.publish(names)

    def _publish(self, sample: SensorSample) -> None:
        if self._publisher.wanted(sample.time_ns):
            fill_time(self._message.header.stamp, sample.time_ns)
            self._message.values = sample.values.tolist()
            self._publisher.publish(self._message, sample.time_ns)


TOPICS: dict[type[BroadcasterParameters], type[SampleTopics[Any]]] = {
    ForceTorqueSensorBroadcasterParameters: WrenchTopics,
    IMUSensorBroadcasterParameters: ImuTopic,
    PoseBroadcasterParameters: PoseTopics,
    SpeedScalingStateBroadcasterParameters: SpeedScalingTopic,
    StateInterfacesBroadcasterParameters: StateInterfacesTopics,
}


def is_pose(values: list[float]) -> bool:
    """Return whether position and quaternion are finite and the quaternion's norm is about 1."""
    return all(map(math.isfinite, values)) and abs(sum(q * q for q in values[3:]) - 1.0) <= 1e-2


def _fill(target: Any, values: list[float]) -> None:
    """Write values into the fields x, y, z and, of four, w."""
    for name, value in zip('xyzw', values, strict=False):
        setattr(target, name, value)
