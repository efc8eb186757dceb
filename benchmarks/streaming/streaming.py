# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streaming to a running arm: rates, delays, straightness, silence, processor time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
import shutil
import tempfile
import time
from typing import Any

from control_msgs.msg import JointTrajectoryControllerState
from controller_manager_msgs.srv import SwitchController
from geometry_msgs.msg import TwistStamped
from moveit_msgs.msg import CollisionObject, ServoStatus
from moveit_msgs.srv import ApplyPlanningScene, ServoCommandType
import numpy as np
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.config.servo import ServoParameters
from armsim_ros.resources import share_folder
from benchmarks.options import Options
from benchmarks.planning.planned_robot import kinematics_of
from benchmarks.stack import processor_seconds, running_stack
from benchmarks.tables import machine_load, publish, Table

JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
PLACE = (0.0, 0.0, 1.7, 0.7, 1.0, 0.0)
CONTROLLER, FORWARD = 'arm_joint_controller', 'position_stream'
RUNS, OBJECTS = 20, 20
#: A twist this old moves nothing any more [s].
TIMEOUT = ServoParameters().incoming_command_timeout
#: Share of the scale of a twist that is 0.1 m/s, and of one that is 0.05 m/s.
TENTH, TWENTIETH = 0.25, 0.125
FORWARD_CONTROLLER = f"""
sunday:
  {FORWARD}:
    type: position_controllers/JointGroupPositionController
    joints: [{', '.join(JOINTS)}]
"""


#: Arrival [s], stamp [s], reference and measured positions [rad].
Reference = tuple[float, float, Vector, Vector]


class User:
    """Jogs, and keeps what came back with the time of its arrival [s]."""

    def __init__(self, client: ClientNode) -> None:
        self.client, node = client, client.node
        self.status: list[float] = []
        self.outputs: list[float] = []
        self.references: list[Reference] = []
        self.measured: list[tuple[float, Vector]] = []
        deep = QoSProfile(depth=50)
        topics: tuple[tuple[type[Any], str, Callable[[Any], None]], ...] = (
            (ServoStatus, '/servo_node/status', lambda _: self.status.append(_now())),
            (JointTrajectory, f'/sunday/{CONTROLLER}/joint_trajectory',
             lambda _: self.outputs.append(_now())),
            (JointTrajectoryControllerState, f'/sunday/{CONTROLLER}/controller_state',
             self._state),
            (JointState, '/sunday/joint_states', self._joints),
        )
        for kind, name, receive in topics:
            node.create_subscription(kind, name, receive, deep)
        self.trajectories = node.create_publisher(
            JointTrajectory, f'/sunday/{CONTROLLER}/joint_trajectory', 10)
        self.positions = node.create_publisher(
            Float64MultiArray, f'/sunday/{FORWARD}/commands', 10)
        self.twists = node.create_publisher(TwistStamped, '/servo_node/delta_twist_cmds', 10)

    def _state(self, message: JointTrajectoryControllerState) -> None:
        stamp = message.header.stamp
        self.references.append((
            _now(), stamp.sec + 1e-9 * stamp.nanosec,
            np.array(message.reference.positions), np.array(message.feedback.positions)))

    def _joints(self, message: JointState) -> None:
        self.measured.append((_now(), np.array(message.velocity)))

    def go(self, positions: Sequence[float]) -> None:
        """Move to the place and rest there."""
        point = JointTrajectoryPoint(positions=[float(value) for value in positions])
        point.time_from_start.sec = 2
        self.trajectories.publish(JointTrajectory(joint_names=list(JOINTS), points=[point]))
        time.sleep(2.8)

    def jog(self, seconds: float, share: float, period: float = 0.01) -> tuple[float, float]:
        """Stream a twist downwards; return when the first and the last one went out [s]."""
        message = TwistStamped()
        message.header.frame_id = 'base_link'
        message.twist.linear.z = -share
        first, step = _now(), 0
        while True:
            message.header.stamp = self.client.node.get_clock().now().to_msg()
            last = _now()
            self.twists.publish(message)
            step += 1
            time.sleep(max(0.0, first + step * period - _now()))
            if _now() - first > seconds:
                return first, last

    def add_objects(self, count: int) -> None:
        """Put boxes around the arm, out of its way."""
        request = ApplyPlanningScene.Request()
        request.scene.is_diff = request.scene.robot_state.is_diff = True
        for number in range(count):
            angle = 2.0 * np.pi * number / count
            box = CollisionObject(id=f'box_{number}', operation=CollisionObject.ADD)
            box.header.frame_id = 'world'
            box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1] * 3)]
            box.pose.position.x, box.pose.position.y = np.cos(angle), np.sin(angle)
            box.pose.position.z, box.pose.orientation.w = 1.3, 1.0
            request.scene.world.collision_objects.append(box)
        assert self.client.call('/apply_planning_scene', ApplyPlanningScene, request).success


def main(options: Options) -> None:
    """Print the table, and put it into a page where one is named."""
    with tempfile.TemporaryDirectory() as folder:
        robot = Path(folder) / 'sunday'
        shutil.copytree(share_folder('armsim_ros') / 'config/sunday', robot)
        (robot / 'servo.yaml').unlink()  # the figures are those of servo's defaults
        (robot / 'forward_controllers.yaml').write_text(FORWARD_CONTROLLER, encoding='utf-8')
        with running_stack('robot:=sunday', f'config:={robot}', 'servo:=true') as stack:
            pid = stack.processes()['servo_node']
            time.sleep(3.0)
            idle = _load(pid, lambda: time.sleep(8.0))
            table = _measured(User(stack.client), pid, idle)
    publish(options.report, 'streaming', table, machine_load())


def _measured(user: User, pid: int, idle: float) -> Table:
    user.client.call('/servo_node/switch_command_type', ServoCommandType,
                     ServoCommandType.Request(command_type=1))
    time.sleep(1.0)
    user.go(PLACE)
    watched = _load(pid, lambda: time.sleep(8.0))
    user.status.clear()
    time.sleep(3.0)
    gaps = np.diff(user.status)
    rows: list[tuple[str, ...]] = [(
        'status', f'{len(gaps) / (user.status[-1] - user.status[0]):.1f} Hz',
        f'p95 of the gaps {1e3 * np.percentile(gaps, 95):.1f} ms',
    )]
    user.jog(0.3, TWENTIETH)
    out, reference, stops, rates = [], [], [], []
    for _ in range(RUNS):
        user.go(PLACE)
        user.outputs.clear()
        user.references.clear()
        first, last = user.jog(0.6, TWENTIETH)
        time.sleep(0.8)
        if not user.outputs:
            raise RuntimeError('servo has sent nothing')
        out.append(user.outputs[0] - first)
        rates.append(sum(one < last for one in user.outputs) / (last - user.outputs[0]))
        moved = _changes(user.references)
        reference.append(moved[0] - first)
        stops.append(moved[-1] - last)
    rows += [
        ('twist to joint command', *_spread(out)),
        ('twist to the first change of the reference', *_spread(reference)),
        ('joint commands', f'{np.median(rates):.0f} Hz', f'least {np.min(rates):.0f} Hz'),
        ('last twist to rest', *_spread(stops)),
        (f'silence, {TIMEOUT:g} s after the last twist, to rest',
         *_spread([stop - TIMEOUT for stop in stops])),
        ('forward command to the first change of the joint states', *_forward(user)),
    ]
    user.go(PLACE)
    user.references.clear()
    user.measured.clear()
    user.add_objects(OBJECTS)
    busy = _load(pid, lambda: user.jog(3.2, TENTH))
    time.sleep(0.8)
    rows += _straightness(user)
    rows += [
        ('processor time of servo_node at rest', f'{100 * idle:.1f} %', 'of a core'),
        ('the same while a client listens to its status', f'{100 * watched:.1f} %', ''),
        (f'the same while it streams among {OBJECTS} objects', f'{100 * busy:.1f} %', ''),
    ]
    return Table('Streaming to a running arm', ('what', 'figure', 'and'), rows)


def _changes(references: list[Reference]) -> list[float]:
    """Return when the reference had changed [s]."""
    return [
        later[0] for before, later in pairwise(references)
        if np.abs(later[2] - before[2]).max() > 1e-7]


def _forward(user: User) -> tuple[str, str]:
    """Return how long a position takes from the topic to the joint states."""
    manager = '/sunday/controller_manager/switch_controller'
    times = []

    def switch(on: str, off: str) -> None:
        request = SwitchController.Request(
            activate_controllers=[on], deactivate_controllers=[off], strictness=2)
        assert user.client.call(manager, SwitchController, request).ok
        time.sleep(0.3)

    switch(FORWARD, CONTROLLER)
    for run in range(RUNS):
        target = np.array(PLACE) + 0.05 * (run % 2 == 0)
        user.measured.clear()
        begin = _now()
        user.positions.publish(Float64MultiArray(data=target.tolist()))
        time.sleep(0.5)
        times.append(next(
            when for when, velocity in user.measured if np.abs(velocity).max() > 0.02) - begin)
    switch(CONTROLLER, FORWARD)
    return _spread(times)


def _straightness(user: User) -> list[tuple[str, ...]]:
    kinematics = kinematics_of('sunday')

    def tip(positions: Vector) -> Matrix:
        q = kinematics.insert(kinematics.default(), 'manipulator', positions)
        return kinematics.link_pose(q, 'link_6')[:3, 3]

    track = np.array([tip(entry[3]) for entry in user.references])
    times = np.array([entry[1] for entry in user.references])
    way = track[-1] - track[0]
    length = float(np.linalg.norm(way))
    along = (track - track[0]) @ way / max(length, 1e-9)
    sideways = np.linalg.norm(track - track[0] - along[:, None] * way / max(length, 1e-9), axis=1)
    middle = (along > 0.2 * length) & (along < 0.8 * length)
    speed = float('nan')
    if middle.sum() > 2:
        speed = np.polyfit(times[middle] - times[0], along[middle], 1)[0]
    velocities = np.array([entry[1] for entry in user.measured])
    turning = velocities[np.abs(velocities).max(axis=1) > 0.02]
    flips = sum(
        np.any(turning[:, k] > 0.01) and np.any(turning[:, k] < -0.01)
        for k in range(turning.shape[1]))
    return [
        ('straight line at 0.100 m/s', f'{length:.3f} m at {speed:.3f} m/s',
         f'at most {1e3 * sideways.max():.2f} mm sideways'),
        ('joints whose velocity changes its sign on the way', f'{flips}', ''),
    ]


def _spread(times: list[float]) -> tuple[str, str]:
    """Return median and 95th percentile of times [s] in words."""
    middle, late = 1e3 * np.percentile(times, (50, 95))
    return f'median {middle:.0f} ms', f'p95 {late:.0f} ms'


def _load(pid: int, work: Callable[[], object]) -> float:
    """Return the processor time of a process during some work, as a share of a core."""
    before, begin = processor_seconds(pid), _now()
    work()
    return (processor_seconds(pid) - before) / (_now() - begin)


def _now() -> float:
    return time.monotonic()
