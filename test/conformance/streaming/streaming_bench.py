# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user who streams: publishers, services, and records of what the arm did."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
import threading
import time
from typing import Any

from control_msgs.msg import JointJog, JointTrajectoryControllerState
from controller_manager_msgs.srv import ListControllers, SwitchController
from geometry_msgs.msg import PoseStamped, TwistStamped
from moveit_msgs.msg import ServoStatus
from moveit_msgs.srv import ServoCommandType
import numpy as np
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import Program

NAMESPACE = '/sunday'
ARM = 'arm_joint_controller'
JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
PLACE = (0.0, 0.3, 1.5, 0.5, 1.0, 0.0)
#: How fast the joints move between tests [rad/s].
PACE = 2.0
MANAGER = f'{NAMESPACE}/controller_manager'

FORWARD_CONTROLLERS = """
sunday:
  position_stream:
    type: position_controllers/JointGroupPositionController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
  velocity_stream:
    type: velocity_controllers/JointGroupVelocityController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
  effort_stream:
    type: effort_controllers/JointGroupEffortController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
  named_stream:
    type: forward_command_controller/ForwardCommandController
    joints: [joint_1, joint_2]
    interface_name: position
  chained_arm:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    command_joints: [loop/joint_1, loop/joint_2, loop/joint_3,
                     loop/joint_4, loop/joint_5, loop/joint_6]
  loop:
    type: pid_controller/PidController
    dof_names: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    command_interface: velocity
    reference_and_state_interfaces: [position]
    gains:
      joint_1: {p: 10.0}
      joint_2: {p: 10.0}
      joint_3: {p: 10.0}
      joint_4: {p: 10.0}
      joint_5: {p: 10.0}
      joint_6: {p: 10.0}
  soft:
    type: admittance_controller/AdmittanceController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    kinematics: {base: base_link, tip: link_6}
    ft_sensor: {name: wrist, frame: {id: link_6}, filter_coefficient: 0.05}
    control: {frame: {id: base_link}}
    fixed_world_frame: {frame: {id: base_link}}
    gravity_compensation: {frame: {id: link_6}}
    admittance:
      selected_axes: [false, false, false, false, false, false]
      mass: [5.0, 5.0, 5.0, 0.5, 0.5, 0.5]
      damping_ratio: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
      stiffness: [200.0, 200.0, 200.0, 20.0, 20.0, 20.0]
  lamps:
    type: gpio_controllers/GpioCommandController
    gpios: [wrist]
  wrench:
    type: force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster
    sensor_name: wrist
    frame_id: link_6
  load:
    type: force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster
    sensor_name: wrist
    frame_id: link_6
  imu:
    type: imu_sensor_broadcaster/IMUSensorBroadcaster
    sensor_name: accelerometer
    frame_id: link_3
  tcp:
    type: pose_broadcaster/PoseBroadcaster
    pose_name: tool
    frame_id: base_link
  states:
    type: state_interfaces_broadcaster/StateInterfacesBroadcaster
    interfaces: [joint_3/position, accelerometer/orientation.w]
  speed:
    type: ur_controllers/SpeedScalingStateBroadcaster
"""
SIMULATION = """
spawn: [joint_state_controller, arm_joint_controller]
sensors:
  wrist: {type: force_torque, link: link_6}
  accelerometer: {type: imu, link: link_3}
  tool: {type: pose, link: link_6}
"""
BROADCASTERS = ('wrench', 'load', 'imu', 'tcp', 'states', 'speed')
STREAMS = ('position_stream', 'velocity_stream', 'effort_stream', 'named_stream')


@dataclass
class Record:
    """Stamps [s] and values, in the order in which they came."""

    stamps: list[float]
    values: list[Any]


def beside(first: float, last: float = 0.0) -> Any:
    """Return the place with its first and last joint turned (6,) [rad]."""
    return np.array(PLACE) + np.array([first, 0.0, 0.0, 0.0, 0.0, last])


class Streamed:
    """The running stack and its user."""

    def __init__(self, domain: int, program: Program, client: ClientNode) -> None:
        self.domain, self.program, self.client = domain, program, client
        node = client.node
        self._lock = threading.Lock()
        self._stamp = 0.0
        self._positions = np.zeros(6)
        self.reference: Record = Record([], [])
        self.measured: Record = Record([], [])
        self.status: Record = Record([], [])
        node.create_subscription(JointState, f'{NAMESPACE}/joint_states', self._joints, 10)
        self.trajectory = node.create_publisher(
            JointTrajectory, f'{NAMESPACE}/{ARM}/joint_trajectory', 10
        )
        self.twist = node.create_publisher(TwistStamped, '/servo_node/delta_twist_cmds', 10)
        self.jog = node.create_publisher(JointJog, '/servo_node/delta_joint_cmds', 10)
        self.pose = node.create_publisher(PoseStamped, '/servo_node/pose_target_cmds', 10)
        self.streams = {
            name: node.create_publisher(Float64MultiArray, f'{NAMESPACE}/{name}/commands', 10)
            for name in STREAMS
        }
        self.active = ARM

    # ---------------------------------------------------------------- what comes in

    def references(self) -> AbstractContextManager[None]:
        """Record the references of the trajectory controller, which is active."""
        return self._recorded(
            JointTrajectoryControllerState, f'{NAMESPACE}/{ARM}/controller_state', self._state,
            self.reference)

    def statuses(self) -> AbstractContextManager[None]:
        """Record what servo reports."""
        return self._recorded(ServoStatus, '/servo_node/status', self._status, self.status)

    @contextmanager
    def _recorded(self, kind: Any, topic: str, receive: Callable[..., None],
                  record: Record) -> Iterator[None]:
        """Record a topic from its first message on: a hundred a second cost who takes them."""
        self.forget()
        node = self.client.node
        subscription = node.create_subscription(kind, topic, receive, QoSProfile(depth=50))
        self.until(lambda: record.stamps, f'messages of {topic} come')
        yield
        self.client.in_executor(lambda: node.destroy_subscription(subscription))

    def _joints(self, message: JointState) -> None:
        known = dict(zip(message.name, message.position, strict=True))
        with self._lock:
            self._positions = np.array([known[name] for name in JOINTS])
            self._stamp = self._keep(self.measured, message, self._positions)

    def _state(self, message: JointTrajectoryControllerState) -> None:
        with self._lock:
            self._keep(self.reference, message, np.array(message.reference.positions))

    def _status(self, message: ServoStatus, info: dict[str, int]) -> None:
        with self._lock:
            # When it was sent: a late reader gets several at once.
            self.status.stamps.append(1e-9 * info['source_timestamp'])
            self.status.values.append((message.code, message.message))

    def _keep(self, record: Record, message: Any, values: Any) -> float:
        stamp = message.header.stamp
        record.stamps.append(stamp.sec + 1e-9 * stamp.nanosec)
        record.values.append(values)
        return record.stamps[-1]

    def forget(self) -> None:
        """Record anew."""
        with self._lock:
            for record in (self.reference, self.measured, self.status):
                record.stamps.clear()
                record.values.clear()

    @property
    def positions(self) -> Any:
        """Where the joints are (6,) [rad]."""
        with self._lock:
            return self._positions.copy()

    def moved(self, record: Record) -> Any:
        """Return the values of a record (k, 6)."""
        with self._lock:
            return np.array(record.values)

    def largest_speed(self) -> float:
        """Return how fast the reference has moved at most since ``forget`` [rad/s]."""
        references, stamps = self.moved(self.reference), np.array(self.reference.stamps)
        count = min(len(references), len(stamps))
        steps, times = np.diff(references[:count], axis=0), np.diff(stamps[:count])
        return float((np.abs(steps[times > 0.0]) / times[times > 0.0, None]).max())

    def said(self) -> list[tuple[int, str]]:
        """Return code and message of each status since ``forget``."""
        with self._lock:
            return list(self.status.values)

    # ---------------------------------------------------------------- what goes out

    def begin(self) -> None:
        """Go to the place with the trajectory controller; servo runs and has no commands."""
        # A command that is still on its way to servo would replace the trajectory.
        self.client.call('/servo_node/pause_servo', SetBool, SetBool.Request(data=True))
        self.use(ARM)
        for publisher in (self.trajectory, self.twist, self.jog, self.pose):
            self.until(lambda one=publisher: one.get_subscription_count() > 0, 'the arm listens')
        self.go(PLACE)
        self.rest(0.05)
        self.client.call('/servo_node/pause_servo', SetBool, SetBool.Request(data=False))
        self.forget()

    def use(self, name: str) -> Any:
        """Have one controller active; returns the answer."""
        if name == self.active:
            return None
        request = SwitchController.Request(
            activate_controllers=[name], deactivate_controllers=[self.active], strictness=2
        )
        answer = self.client.call(f'{MANAGER}/switch_controller', SwitchController, request)
        assert answer.ok, answer.message
        self.active = name
        return answer

    def go(self, positions: Any) -> None:
        """Move with the trajectory controller and wait."""
        point = JointTrajectoryPoint(positions=[float(value) for value in positions])
        before = self.positions
        distance = np.abs(before - positions).max()
        seconds = 0.1 + distance / PACE
        point.time_from_start.sec = int(seconds)
        point.time_from_start.nanosec = int(1e9 * (seconds % 1.0))
        message = JointTrajectory(joint_names=list(JOINTS), points=[point])
        self.trajectory.publish(message)
        if distance > 2e-3:
            self.stream_until(self.trajectory, message, self.has_moved(before, 1e-3), 'it moves')
        self.until(lambda: np.abs(self.positions - positions).max() < 2e-3, 'the arm is there')

    @contextmanager
    def publisher(self, kind: Any, topic: str) -> Iterator[Any]:
        """Give a publisher that somebody hears; it is gone afterwards."""
        publisher = self.client.node.create_publisher(kind, topic, 10)
        self.until(lambda: publisher.get_subscription_count() > 0, 'the topic is heard')
        yield publisher
        self.client.in_executor(lambda: self.client.node.destroy_publisher(publisher))

    def until(self, condition: Any, what: str, timeout: float = 30.0) -> None:
        """Wait for something."""
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f'not in time: {what}'
            time.sleep(0.005)

    def choose(self, kind: int) -> bool:
        """Choose the type of servo's commands."""
        request = ServoCommandType.Request(command_type=kind)
        return bool(self.client.call(
            '/servo_node/switch_command_type', ServoCommandType, request).success)

    def make_twist(self, linear: Any = (0, 0, 0), angular: Any = (0, 0, 0),
                   frame: str = 'base_link') -> TwistStamped:
        """Return a twist, not stamped."""
        message = TwistStamped()
        message.header.frame_id = frame
        for name, value in zip('xyz', linear, strict=True):
            setattr(message.twist.linear, name, float(value))
        for name, value in zip('xyz', angular, strict=True):
            setattr(message.twist.angular, name, float(value))
        return message

    def stream(self, publisher: Any, message: Any, seconds: float, period: float = 0.01) -> None:
        """Publish a message again and again, stamped anew each time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if hasattr(message, 'header'):
                message.header.stamp = self.client.node.get_clock().now().to_msg()
            publisher.publish(message)
            time.sleep(period)

    def stream_until(self, publisher: Any, message: Any, condition: Any, what: str,
                     timeout: float = 30.0) -> None:
        """Publish a message again and again until something has come of it."""
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f'not in time: {what}; said: {self.said()[-3:]}'
            self.stream(publisher, message, 0.05)

    def has_moved(self, before: Any, angle: float) -> Callable[[], bool]:
        """Return whether a joint has turned by more than an angle [rad], as a condition."""
        return lambda: bool(np.abs(self.positions - before).max() > angle)

    def has_said(self, words: str, *codes: int) -> Callable[[], bool]:
        """Return whether a status with one of the codes has the words, as a condition."""
        return lambda: any(words in text and code in codes for code, text in self.said())

    def rest(self, seconds: float = 0.2) -> None:
        """
        Wait until the arm has not moved for so long by its own stamps [s].

        The simulation answers a request first: where it makes up for lost time, it may step
        through a whole rest before it takes the commands that have come.
        """
        self.client.call(f'{MANAGER}/list_controllers', ListControllers)
        begin, place = 0.0, np.full(6, np.inf)

        def rested() -> bool:
            nonlocal begin, place
            with self._lock:
                stamp, now = self._stamp, self._positions
            if np.abs(now - place).max() > 1e-5:
                begin, place = stamp, now
            return stamp - begin > seconds

        self.until(rested, 'the arm rests')
