# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``franka_robot_state_broadcaster``: the state of the arm, its mode and its errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from franka_msgs.msg import CollisionIndicators, Elbow, Errors, FrankaRobotState
from geometry_msgs.msg import (
    InertiaStamped,
    PoseStamped,
    Twist,
    TwistStamped,
    Wrench,
    WrenchStamped,
)
import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.arm_state import ArmState, Cause, Mode, Safety
from armsim_ros.control.controller import Controller
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.conversions.time import time_from_ns
from armsim_ros.nodes.qos import WantedPublisher
from armsim_ros.nodes.simulation.world.answers import vector
from armsim_ros.nodes.vendors.endpoints import ArmNodes
from armsim_ros.nodes.vendors.franka_services import ArmParameters, end_effector, Mass
from armsim_ros.sim.external_loads import ExternalLoads

#: A joint that is faster is in motion [rad/s].
MOTION = 1e-3
#: The elbow has turned over where the fourth joint is below this [rad].
ELBOW = -0.467002423653011
#: An arm whose tool is slower than this at joints of 1 rad/s, in its slowest direction, is near a
#: singularity; the wrench is 0 there. libfranka leaves open how near.
SINGULAR = 0.01
#: Topic -> type and the field of ``robot_state`` that it has.
TOPICS: dict[str, tuple[Any, str]] = {
    'current_pose': (PoseStamped, 'o_t_ee'),
    'last_desired_pose': (PoseStamped, 'o_t_ee_d'),
    'desired_end_effector_twist': (TwistStamped, 'o_dp_ee_d'),
    'external_wrench_in_base_frame': (WrenchStamped, 'o_f_ext_hat_k'),
    'external_wrench_in_stiffness_frame': (WrenchStamped, 'k_f_ext_hat_k'),
    'external_joint_torques': (JointState, 'tau_ext_hat_filtered'),
    'measured_joint_states': (JointState, 'measured_joint_state'),
    'desired_joint_states': (JointState, 'desired_joint_state'),
}


def robot_mode(arm: ArmState, *, moving: bool) -> int:
    """Return the mode of an arm as its controller has it."""
    if arm.safety is Safety.EMERGENCY_STOP:
        return int(FrankaRobotState.ROBOT_MODE_USER_STOPPED)
    if arm.stopped:
        return int(FrankaRobotState.ROBOT_MODE_REFLEX)
    if arm.mode is not Mode.RUNNING:
        return int(FrankaRobotState.ROBOT_MODE_OTHER)
    if arm.freedrive:
        return int(FrankaRobotState.ROBOT_MODE_GUIDING)
    return int(FrankaRobotState.ROBOT_MODE_MOVE if moving else FrankaRobotState.ROBOT_MODE_IDLE)


def errors_of(cause: Cause | None) -> Errors:
    """Return the errors that a cause of a protective stop is."""
    errors = Errors()
    if cause is None:
        return errors
    if cause.kind == 'speed':
        errors.joint_velocity_violation = True
    elif cause.kind == 'position':
        errors.joint_position_limits_violation = True
    elif cause.kind == 'collision' and cause.text.startswith('contact'):
        errors.cartesian_reflex = True
    elif cause.kind in ('collision', 'injected'):
        errors.joint_reflex = True
    return errors


class StateTopics:
    """
    The topics of a ``franka_robot_state_broadcaster/FrankaRobotStateBroadcaster``.

    :param joints: (n,) of the arm.
    """

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node,
                 joints: Sequence[str], parameters: ArmParameters) -> None:
        self._nodes, self._controller, self._parameters = nodes, controller, parameters
        self._joints = tuple(joints)
        self._places = [nodes.manager.hardware.index[name] for name in joints]
        model = nodes.robot.model
        self._base = model.joints[joints[0]].parent
        ends = ('hand_tcp', nodes.arm.vendor.tool)
        self._flange, *_ = [name for name in model.links if name.endswith(ends[1])] or [
            model.joints[joints[-1]].child]
        self._hand = next((name for name in model.links if name.endswith(ends[0])), self._flange)
        self._arm = ArmDynamics(model, self._joints, self._hand, self._base)
        self._end_effector = end_effector(model, self._arm, self._flange)
        self._loads: ExternalLoads | None = None
        self._last: Cause | None = None
        #: Collisions of wrench and joints that are shown until the arm has recovered (13,).
        self._collided = np.zeros(13)
        self._asked = False
        profile = QoSProfile(depth=1)
        self._state = WantedPublisher(node, FrankaRobotState, '~/robot_state', profile)
        self._topics = [(WantedPublisher(node, kind, f'~/{name}', profile), field)
                        for name, (kind, field) in TOPICS.items()]

    def publish(self, time_ns: int) -> None:
        """Have the state published, if it has subscribers."""
        cause = self._nodes.arm.cause
        self._last = cause or self._last
        if self._asked or not self._controller.active:
            return
        publishers = [self._state, *(publisher for publisher, _ in self._topics)]
        if not any(publisher.wanted(time_ns) for publisher in publishers):
            return
        self._asked = True
        future = self._nodes.loop.call(self._sample)
        future.add_done_callback(
            lambda done: self._nodes.dispatcher.post(partial(self._send, done)))

    def _sample(self) -> tuple[int, Matrix, Vector]:
        """
        Return time [ns], measured and desired joints (7, n), external torques (n,).

        As libfranka's ``tau_ext_hat_filtered`` they are what the arm does to what it touches:
        measured torques less those of the arm's model (robot_state.h).
        """
        nodes, places = self._nodes, self._places
        hardware = nodes.manager.hardware
        if self._loads is None:
            self._loads = ExternalLoads(nodes.loop.simulation, hardware.joint_names, nodes.robot)
        state, command, given = hardware.state, hardware.command, hardware.feedforward
        effort = np.where(np.isfinite(command.effort), command.effort, 0.0)
        desired = np.where(np.isfinite(command.position), command.position, state.position)
        speed = np.where(np.isfinite(given.velocity), given.velocity, 0.0)
        change = np.where(np.isfinite(given.acceleration), given.acceleration, 0.0)
        rows = np.stack((
            state.position, state.velocity, state.effort, desired, speed, effort, change))
        return nodes.time_ns, rows[:, places], -self._loads.torques()[places]

    def _send(self, done: Any) -> None:
        self._asked = False
        if done.cancelled():
            return
        time_ns, rows, torques = done.result()
        message = self._message(time_ns, rows, torques)
        if self._state.wanted(time_ns):
            self._state.publish(message, time_ns)
        for publisher, field in self._topics:
            if publisher.wanted(time_ns):
                publisher.publish(getattr(message, field), time_ns)

    def _message(self, time_ns: int, rows: Matrix, torques: Vector) -> FrankaRobotState:
        arm_state, parameters = self._nodes.arm, self._parameters
        arm, stamp = self._arm, time_from_ns(time_ns)
        arm.move(rows[3], rows[4])
        desired = arm.pose @ parameters.tool
        twist = _at(arm.pose, desired, arm.jacobian()) @ rows[4]
        arm.move(rows[0], rows[1])
        tool = arm.pose @ parameters.tool
        frame = tool @ parameters.stiffness
        lever = _at(arm.pose, frame, arm.jacobian())
        wrench = np.zeros(6)
        if np.linalg.svd(lever, compute_uv=False)[-1] > SINGULAR:
            wrench = np.asarray(np.linalg.lstsq(lever.T, torques, rcond=None)[0])
        turn = frame[:3, :3].T
        own = np.concatenate((turn @ wrench[:3], turn @ wrench[3:]))

        def head(name: str) -> Header:
            return Header(stamp=stamp, frame_id=name)

        def joints(values: Matrix) -> JointState:
            return JointState(header=head(self._base), name=list(self._joints),
                              position=values[0].tolist(), velocity=values[1].tolist(),
                              effort=values[2].tolist())

        def inertia(name: str, mass: Mass) -> InertiaStamped:
            return InertiaStamped(header=head(name), inertia=mass.message())

        def pose(name: str, matrix: Matrix) -> PoseStamped:
            return PoseStamped(header=head(name), pose=pose_to_message(matrix))

        moving = bool((np.abs(rows[1]) > MOTION).any())
        zeros = np.zeros_like(torques)
        message = FrankaRobotState(
            header=head(''),
            collision_indicators=self._indicators(own, torques),
            measured_joint_state=joints(rows[:3]), desired_joint_state=joints(rows[3:6]),
            measured_joint_motor_state=joints(np.stack((rows[0], rows[1], zeros))),
            tau_ext_hat_filtered=joints(np.stack((zeros, zeros, torques))),
            o_t_ee=pose(self._base, tool), o_t_ee_d=pose(self._base, desired),
            o_t_ee_c=pose(self._base, desired),
            f_t_ee=pose(self._flange, inverse_pose(arm.frame(self._flange)) @ tool),
            ee_t_k=pose(self._hand, parameters.stiffness),
            o_f_ext_hat_k=WrenchStamped(header=head(self._base), wrench=_wrench(wrench)),
            k_f_ext_hat_k=WrenchStamped(header=head(self._hand), wrench=_wrench(own)),
            o_dp_ee_d=TwistStamped(header=head(self._base), twist=Twist(
                linear=vector(twist[:3]), angular=vector(twist[3:]))),
            # Centres and axes are of the flange in all of them; so are upstream's frame ids.
            inertia_ee=inertia(self._hand, self._end_effector),
            inertia_load=inertia(self._flange, parameters.load),
            inertia_total=inertia(self._hand, self._end_effector + parameters.load),
            time=time_ns * 1e-9, control_command_success_rate=float(moving),
            robot_mode=robot_mode(arm_state, moving=moving),
            current_errors=errors_of(arm_state.cause if arm_state.stopped else None),
            last_motion_errors=errors_of(self._last))
        message.o_dp_ee_c = message.o_dp_ee_d
        message.ddq_d[:len(torques)] = rows[6]
        if len(rows[0]) > 3:
            sign = 1.0 if rows[0, 3] > ELBOW else -1.0
            wanted = 1.0 if rows[3, 3] > ELBOW else -1.0
            message.elbow = Elbow(position=[rows[0, 2], sign],
                                  desired_position=[rows[3, 2], wanted],
                                  commanded_position=[rows[3, 2], wanted])
        return message

    def _indicators(self, wrench: Vector, torques: Vector) -> CollisionIndicators:
        """Return what is touched now, and the collisions until the arm has recovered."""
        parameters, count = self._parameters, min(7, len(torques))
        contact, collision = np.zeros(7), np.zeros(7)
        contact[:count], collision[:count] = np.abs(torques[:count]) > (
            parameters.torques[:, :count])
        touched, collides = (np.abs(wrench) > limit for limit in parameters.forces)
        found, arm = np.concatenate((collides, collision)), self._nodes.arm
        if arm.stopped:
            found = np.maximum(found, self._collided)
            if arm.cause is not None and arm.cause.joint in self._joints:
                found[6 + self._joints.index(arm.cause.joint)] = arm.cause.kind == 'collision'
        self._collided, collides, collision = found, found[:6], found[6:]
        return CollisionIndicators(
            is_cartesian_linear_collision=vector(collides[:3]),
            is_cartesian_angular_collision=vector(collides[3:]),
            is_cartesian_linear_contact=vector(touched[:3]),
            is_cartesian_angular_contact=vector(touched[3:]),
            is_joint_collision=collision, is_joint_contact=contact)


def _at(tip: Matrix, point: Matrix, jacobian: Matrix) -> Matrix:
    """Return the Jacobian (6, n) of a point that the tip carries, from that of the tip."""
    way = point[:3, 3] - tip[:3, 3]
    linear = jacobian[:3] + np.cross(jacobian[3:].T, way).T
    return np.concatenate((linear, jacobian[3:]))


def _wrench(values: Vector) -> Wrench:
    return Wrench(force=vector(values[:3]), torque=vector(values[3:]))
