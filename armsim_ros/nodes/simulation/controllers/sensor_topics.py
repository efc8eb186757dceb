# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of sensors: wrench, imu, pose, speed_scaling."""

from __future__ import annotations

from collections.abc import Callable
import math
from typing import Any

from geometry_msgs.msg import PoseStamped, TransformStamped, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from armsim_ros.config.controllers.broadcasters import (
    BroadcasterParameters,
    ForceTorqueSensorBroadcasterParameters,
    IMUSensorBroadcasterParameters,
    PoseBroadcasterParameters,
    SpeedScalingStateBroadcasterParameters,
)
from armsim_ros.control.broadcasters.sensor_broadcaster import SensorSample
from armsim_ros.control.rate import Rate
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.qos import WantedPublisher


class WrenchTopics:
    """``~/wrench`` and, where there is a filter chain, messages on ``~/wrench_filtered``."""

    def __init__(self, node: Node, parameters: ForceTorqueSensorBroadcasterParameters) -> None:
        self._publishers = [WantedPublisher(node, WrenchStamped, topic, qos.STATE)
                            for topic in ('~/wrench', '~/wrench_filtered')]
        self._topics = 2 if parameters.sensor_filter_chain else 1
        self._message = WrenchStamped()
        self._message.header.frame_id = parameters.frame_id

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample: force, torque."""
        requested = [publisher for publisher in self._publishers[: self._topics]
                  if publisher.wanted(sample.time_ns)]
        if not requested:
            return
        fill_time(self._message.header.stamp, sample.time_ns)
        wrench, values = self._message.wrench, sample.values.tolist()
        _fill(wrench.force, values[:3])
        _fill(wrench.torque, values[3:])
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


class ImuTopic:
    """``~/imu``."""

    def __init__(self, node: Node, parameters: IMUSensorBroadcasterParameters) -> None:
        self._publisher = WantedPublisher(node, Imu, '~/imu', qos.STATE)
        self._message = Imu(
            orientation_covariance=parameters.static_covariance_orientation,
            angular_velocity_covariance=parameters.static_covariance_angular_velocity,
            linear_acceleration_covariance=parameters.static_covariance_linear_acceleration,
        )
        self._message.header.frame_id = parameters.frame_id

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample: orientation, angular velocity, linear acceleration."""
        if not self._publisher.wanted(sample.time_ns):
            return
        message, values = self._message, sample.values.tolist()
        fill_time(message.header.stamp, sample.time_ns)
        _fill(message.orientation, values[:4])
        _fill(message.angular_velocity, values[4:7])
        _fill(message.linear_acceleration, values[7:])
        self._publisher.publish(message, sample.time_ns)


class PoseTopics:
    """``~/pose``, and the same as a transform."""

    def __init__(self, node: Node, parameters: PoseBroadcasterParameters) -> None:
        self._publisher = WantedPublisher(node, PoseStamped, '~/pose', qos.STATE)
        self._message = PoseStamped()
        self._transform = TransformStamped()
        self._transform.child_frame_id = parameters.tf.child_frame_id or parameters.pose_name
        self._message.header.frame_id = self._transform.header.frame_id = parameters.frame_id
        self._transforms: Any = None
        if parameters.tf.enable:
            self._transforms = node.create_publisher(TFMessage, '/tf', qos.TF)
        self._rate = Rate(parameters.tf.publish_rate or float('inf'))

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample: position, orientation."""
        values = sample.values.tolist()
        if self._publisher.wanted(sample.time_ns):
            fill_time(self._message.header.stamp, sample.time_ns)
            _fill(self._message.pose.position, values[:3])
            _fill(self._message.pose.orientation, values[3:])
            self._publisher.publish(self._message, sample.time_ns)
        if self._transforms is None or not is_pose(values):
            return
        if self._rate.due(sample.time_ns):
            fill_time(self._transform.header.stamp, sample.time_ns)
            _fill(self._transform.transform.translation, values[:3])
            _fill(self._transform.transform.rotation, values[3:])
            self._transforms.publish(TFMessage(transforms=[self._transform]))


class SpeedScalingTopic:
    """``~/speed_scaling``: the pace of trajectories [%]."""

    def __init__(self, node: Node, _: SpeedScalingStateBroadcasterParameters) -> None:
        self._publisher = WantedPublisher(node, Float64, '~/speed_scaling', qos.STATE)

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample."""
        if self._publisher.wanted(sample.time_ns):
            self._publisher.publish(Float64(data=float(sample.values[0])), sample.time_ns)


TOPICS: dict[type[BroadcasterParameters], Callable[[Node, Any], Any]] = {
    ForceTorqueSensorBroadcasterParameters: WrenchTopics,
    IMUSensorBroadcasterParameters: ImuTopic,
    PoseBroadcasterParameters: PoseTopics,
    SpeedScalingStateBroadcasterParameters: SpeedScalingTopic,
}


def is_pose(values: list[float]) -> bool:
    """Return whether position and quaternion are finite and the quaternion's norm is about 1."""
    return all(map(math.isfinite, values)) and abs(sum(q * q for q in values[3:]) - 1.0) <= 1e-2


def _fill(target: Any, values: list[float]) -> None:
    """Write values into the fields x, y, z and, of four, w."""
    for name, value in zip('xyzw', values, strict=False):
        setattr(target, name, value)
