# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of controllers: commands, joint states, references, ``~/controller_state``."""

from __future__ import annotations

from typing import Any

from control_msgs.msg import (
    AdmittanceControllerState,
    DynamicInterfaceGroupValues,
    DynamicJointState,
    InterfaceValue,
    JointTrajectoryControllerState,
    MultiDOFCommand,
    MultiDOFStateStamped,
    PidState,
    SingleDOFState,
)
from geometry_msgs.msg import WrenchStamped
import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.control.broadcaster import SensorSample
from armsim_ros.control.command_controllers.admittance_controller import (
    AdmittanceController,
    AdmittanceSnapshot,
)
from armsim_ros.control.command_controllers.forward_command_controller import ForwardController
from armsim_ros.control.command_controllers.gpio_command_controller import GpioCommandController
from armsim_ros.control.command_controllers.pid_controller import PidController, PidSnapshot
from armsim_ros.control.joint_state_broadcaster import JointStateLayout, JointStateSnapshot
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.model.transforms import matrix_from_axis_angle, quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_duration, fill_time
from armsim_ros.nodes.conversions.trajectory import (
    DynamicJointStateBuffer,
    serialized_joint_state,
    SerializedControllerState,
)
from armsim_ros.nodes.qos import CalmSubscribers, WantedPublisher


class Commands:
    """Passes commands to a forward controller; the events report why a command is dropped."""

    def __init__(self, node: Node, controller: ForwardController) -> None:
        self._controller = controller
        if controller.single:
            self._subscriptions = [
                node.create_subscription(Float64, '~/command', self._receive_one, qos.COMMAND)
            ]
        else:
            self._subscriptions = [
                node.create_subscription(Float64MultiArray, name, self._receive, qos.COMMAND)
                for name in ('~/commands', '~/command')]

    def _receive(self, message: Float64MultiArray) -> None:
        self._controller.receive(message.data)

    def _receive_one(self, message: Float64) -> None:
        self._controller.receive((message.data,))

    def publish(self, time_ns: int) -> None:
        """Publish nothing: such a controller has no state."""


class ControllerStatePublisher:
    """
    Publishes reference, feedback, error and output of a trajectory controller.

    The rate is the parameter ``state_publish_rate``; the reference implementation publishes at
    every update, which at the rate of our physics would be more than any client reads.
    """

    def __init__(self, node: Node, controller: JointTrajectoryController) -> None:
        self._controller = controller
        self._message: SerializedControllerState | None = None
        self._published = -1
        self._publisher = WantedPublisher(
            node, JointTrajectoryControllerState, '~/controller_state', qos.STATE)

    def publish_if_due(self, time_ns: int) -> None:
        """Publish the latest state if it is due and there was an update since the last state."""
        if not self._controller.active or not self._controller.publish_due(time_ns):
            return
        if not self._publisher.wanted(time_ns):
            return
        snapshot = self._controller.snapshot()
        if snapshot is not None and snapshot.sequence != self._published:
            self._published = snapshot.sequence
            if self._message is None or not self._message.fits(snapshot):
                self._message = SerializedControllerState(snapshot)
            self._publisher.publish(self._message.of(snapshot), time_ns)


class PidStates:
    """
    Publishes the parts of commands while ``activate_state_publisher`` of their gains is true.

    As upstream, the fields ``p_term``, ``i_term`` and ``d_term`` are the gains.
    """

    def __init__(self, node: Node, controller: PidController) -> None:
        self._node, self._controller = node, controller
        self._publishers: dict[str, WantedPublisher] = {}
        self._published_ns = -1

    def publish(self, snapshot: PidSnapshot) -> None:
        """Publish a snapshot, if it is new."""
        if snapshot.time_ns == self._published_ns:
            return
        self._published_ns = snapshot.time_ns
        parameters = self._controller.parameters
        for i, name in enumerate(parameters.dof_names):
            if parameters.gains[name].activate_state_publisher:
                self._publish(name, snapshot, i)

    def _publish(self, name: str, snapshot: PidSnapshot, i: int) -> None:
        if name not in self._publishers:
            self._publishers[name] = WantedPublisher(
                self._node, PidState, f'~/{name}/pid_state', qos.STATE)
        if not self._publishers[name].wanted(snapshot.time_ns):
            return
        error, change = snapshot.error[:, i].tolist()
        gains = self._controller.parameters.gains[name]
        lower, upper = gains.integral_bounds
        message = PidState(
            error=error, error_dot=change, p_error=error, i_error=float(snapshot.integral[i]),
            d_error=change, p_term=gains.p, i_term=gains.i, d_term=gains.d, i_max=upper,
            i_min=lower, output=float(snapshot.output[i]))
        fill_time(message.header.stamp, snapshot.time_ns)
        fill_duration(message.timestep, snapshot.period)
        self._publishers[name].publish(message, snapshot.time_ns)


class PidTopics:
    """Passes references to the controller and publishes its state."""

    def __init__(self, node: Node, controller: PidController) -> None:
        self._node, self._controller = node, controller
        self._publisher = WantedPublisher(
            node, MultiDOFStateStamped, '~/controller_state', qos.STATE)
        self._states = PidStates(node, controller)
        self._published_ns = -1
        self._inputs: list[Any] = [
            node.create_subscription(MultiDOFCommand, '~/reference', self._refer, qos.COMMAND),
            node.create_service(SetBool, '~/set_feedforward_control', self._set_feedforward,
                                qos_profile=qos.SERVICES),
        ]
        self._measured: Any = None
        self.follow_parameters()

    def follow_parameters(self) -> None:
        """Subscribe to measured states exactly while they come from the topic."""
        external = self._controller.parameters.use_external_measured_states
        if external and self._measured is None:
            self._measured = self._node.create_subscription(
                MultiDOFCommand, '~/measured_state', self._measure, qos.COMMAND)
        elif not external and self._measured is not None:
            self._node.destroy_subscription(self._measured)
            self._measured = None

    def publish(self, time_ns: int) -> None:
        """Publish the latest state, if it is new [ns]."""
        snapshot = self._controller.snapshot()
        if snapshot is None:
            return
        self._states.publish(snapshot)
        if not self._publisher.wanted(time_ns) or snapshot.time_ns == self._published_ns:
            return
        self._published_ns = snapshot.time_ns
        message = MultiDOFStateStamped(dof_states=[
            SingleDOFState(
                name=name, reference=float(snapshot.reference[0, i]),
                feedback=float(snapshot.feedback[0, i]),
                feedback_dot=float(snapshot.feedback[1, i]) if len(snapshot.feedback) > 1 else 0.0,
                error=float(snapshot.error[0, i]), error_dot=float(snapshot.error[1, i]),
                time_step=snapshot.period, output=float(snapshot.output[i]))
            for i, name in enumerate(snapshot.names)])
        fill_time(message.header.stamp, snapshot.time_ns)
        self._publisher.publish(message, time_ns)

    def _refer(self, message: MultiDOFCommand) -> None:
        self._controller.receive(message.dof_names, message.values, message.values_dot)

    def _measure(self, message: MultiDOFCommand) -> None:
        self._controller.measure(message.dof_names, message.values, message.values_dot)

    def _set_feedforward(self, request: Any, response: Any) -> Any:
        self._controller.set_feedforward(request.data)
        response.success = True
        response.message = f'feed-forward is {"on" if request.data else "off"}'
        return response


class GpioTopics:
    """Passes commands to the controller and publishes its samples."""

    def __init__(self, node: Node, controller: GpioCommandController) -> None:
        self._controller = controller
        kind = DynamicInterfaceGroupValues
        self._publisher = WantedPublisher(node, kind, '~/gpio_states', qos.STATE)
        self._gpios = controller.gpios
        self._subscription = node.create_subscription(
            kind, '~/commands', self._receive, qos.COMMAND
        ) if controller.required_command_interfaces else None

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample, a group per GPIO."""
        if not self._publisher.wanted(sample.time_ns):
            return
        groups = {gpio: InterfaceValue() for gpio in self._gpios}
        for name, value in zip(self._controller.interfaces, sample.values.tolist(), strict=False):
            gpio, _, kind = name.rpartition('/')
            group = groups[gpio]
            group.interface_names.append(kind)
            group.values.append(value)
        message = DynamicInterfaceGroupValues(
            interface_groups=list(groups), interface_values=list(groups.values()))
        fill_time(message.header.stamp, sample.time_ns)
        self._publisher.publish(message, sample.time_ns)

    def _receive(self, message: DynamicInterfaceGroupValues) -> None:
        gpios, groups = message.interface_groups, message.interface_values
        if len(gpios) != len(groups):
            self._controller.drop(f'{len(gpios)} interface_groups and {len(groups)} '
                                  'interface_values')
            return
        self._controller.receive([
            (gpio, group.interface_names, group.values)
            for gpio, group in zip(gpios, groups, strict=True)])


#: Names the compliant frame.
OFFSET = 'admittance_offset'


class AdmittanceTopics:
    """Passes references to the controller and publishes its state."""

    def __init__(self, node: Node, controller: AdmittanceController) -> None:
        self._controller = controller
        self._publisher = WantedPublisher(node, AdmittanceControllerState, '~/status', qos.STATE)
        self._published_ns = -1
        self._subscriptions = [
            node.create_subscription(kind, topic, receive, qos.COMMAND)
            for kind, topic, receive in (
                (JointTrajectoryPoint, '~/joint_references', self._refer),
                (WrenchStamped, '~/wrench_reference', self._add_wrench))]

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


class JointStates:
    """
    Publishes what the joint state broadcaster has sampled.

    :param node: the broadcaster's node; the topic lies in its namespace.
    :param local: publish under the node's name instead.
    """

    def __init__(self, node: Node, *, local: bool = False) -> None:
        topic = '~/joint_states' if local else 'joint_states'
        self._publisher = node.create_publisher(JointState, topic, qos.STATE)
        self._layout: JointStateLayout | None = None
        #: Whether its subscribers need no more than the present state.
        self.calm = CalmSubscribers(node, self._publisher)

    def publish(self, sample: JointStateSnapshot) -> None:
        """Publish a sample."""
        if sample.layout is not self._layout:
            self._layout = sample.layout
            self._message = serialized_joint_state(sample.names, sample.frame_id)
        self._message.set_numbers(sample.values[sample.layout.slots].ravel())
        self._publisher.publish(self._message.at(sample.time_ns))


class DynamicJointStates:
    """
    Publishes every state interface that the joint state broadcaster has sampled.

    :param node: the broadcaster's node; the topic lies in its namespace.
    :param local: publish under the node's name instead.
    """

    def __init__(self, node: Node, *, local: bool = False) -> None:
        topic = '~/dynamic_joint_states' if local else 'dynamic_joint_states'
        self._publisher = WantedPublisher(node, DynamicJointState, topic, qos.STATE)
        self._interfaces: dict[str, tuple[str, ...]] = {}
        self._buffer = DynamicJointStateBuffer({})

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return bool(self._publisher.count)

    def publish(self, sample: JointStateSnapshot) -> None:
        """Publish a sample."""
        if not self._publisher.wanted(sample.time_ns):
            return
        dynamic = sample.dynamic
        interfaces = {joint: names for joint, names, _ in dynamic}
        if interfaces != self._interfaces:
            self._interfaces = interfaces
            self._buffer = DynamicJointStateBuffer(interfaces, sample.frame_id)
        values = [numbers for _, _, numbers in dynamic]
        self._publisher.publish(self._buffer.fill(sample.time_ns, values), sample.time_ns)
