# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of an admittance controller: references, wrenches and ``~/status``."""

from __future__ import annotations

from typing import Any

from control_msgs.msg import AdmittanceControllerState
from geometry_msgs.msg import WrenchStamped
import numpy as np
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.control.command_controllers.admittance_controller import (
    AdmittanceController,
    AdmittanceSnapshot,
)
from armsim_ros.model.transforms import matrix_from_axis_angle, quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher

#: Names the compliant frame.
OFFSET = 'admittance_offset'


class AdmittanceTopics:
    """
    Passes references to the controller and publishes its state.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: AdmittanceController) -> None:
        self._controller = controller
        self._publisher = WantedPublisher(node, AdmittanceControllerState, '~/status', qos.STATE)
        self._published_ns = -1
        self._subscriptions = [
            node.create_subscription(kind, topic, receive, qos.COMMAND)
            for kind, topic, receive in (
                (JointTrajectoryPoint, '~/joint_references', self._refer),
                (WrenchStamped, '~/wrench_reference', self._add_wrench),
            )
        ]

    def publish(self, time_ns: int) -> None:
        """Publish the latest state, if it is new [ns]."""
        snapshot = self._controller.snapshot()
        if snapshot is None or not self._publisher.wanted(time_ns):
            return
        if snapshot.time_ns != self._published_ns:
            self._published_ns = snapshot.time_ns
            self._publisher.publish(_message(snapshot), time_ns)

    def _refer(self, message: JointTrajectoryPoint) -> None:
        self._controller.receive(message.positions, message.velocities)

    def _add_wrench(self, message: WrenchStamped) -> None:
        force, torque = message.wrench.force, message.wrench.torque
        self._controller.receive_wrench(
            message.header.frame_id, [force.x, force.y, force.z, torque.x, torque.y, torque.z])


def _message(snapshot: AdmittanceSnapshot) -> AdmittanceControllerState:
    parameters, admittance = snapshot.parameters, snapshot.admittance
    base, sensor = parameters.kinematics.base, parameters.ft_sensor.frame.id
    message = AdmittanceControllerState()
    message.mass.data = list(admittance.mass)
    message.damping.data = snapshot.damping.tolist()
    message.stiffness.data = list(admittance.stiffness)
    message.selected_axes.data = [int(selected) for selected in admittance.selected_axes]
    message.ft_sensor_frame.data = sensor
    _fill(message.rot_base_control, 'xyzw', quat_xyzw_from_matrix(snapshot.control_rotation))
    place, there = message.ref_trans_base_ft, snapshot.sensor_at_reference
    place.child_frame_id = sensor
    _fill(place.transform.translation, 'xyz', there[:3, 3])
    _fill(place.transform.rotation, 'xyzw', quat_xyzw_from_matrix(there))
    yielded = message.admittance_position
    yielded.child_frame_id = OFFSET
    _fill(yielded.transform.translation, 'xyz', snapshot.yielded[:3])
    angle = float(np.linalg.norm(snapshot.yielded[3:]))
    axis = snapshot.yielded[3:] / angle if angle else np.array([1.0, 0.0, 0.0])
    _fill(yielded.transform.rotation, 'xyzw',
          quat_xyzw_from_matrix(matrix_from_axis_angle(axis, angle)))
    for twist, values in ((message.admittance_velocity.twist, snapshot.twist),
                          (message.admittance_acceleration.twist, snapshot.twist_rate)):
        _fill(twist.linear, 'xyz', values[:3])
        _fill(twist.angular, 'xyz', values[3:])
    _fill(message.wrench_base.wrench.force, 'xyz', snapshot.wrench[:3])
    _fill(message.wrench_base.wrench.torque, 'xyz', snapshot.wrench[3:])
    message.joint_state.name = list(parameters.joints)
    message.joint_state.position = snapshot.offset.tolist()
    message.joint_state.velocity = snapshot.velocity.tolist()
    message.joint_state.effort = snapshot.acceleration.tolist()
    for stamped in (place, yielded, message.admittance_velocity, message.admittance_acceleration,
                    message.wrench_base, message.joint_state):
        stamped.header.frame_id = base
        fill_time(stamped.header.stamp, snapshot.time_ns)
    return message


def _fill(target: Any, names: str, values: Any) -> None:
    for name, value in zip(names, values, strict=True):
        setattr(target, name, float(value))
