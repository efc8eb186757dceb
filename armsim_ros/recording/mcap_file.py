# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A recording as MCAP with ROS 2 messages, as rosbag2 and Foxglove read it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TYPE_CHECKING

from mcap_ros2.writer import Writer

from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.recording.message_definitions import message_definition
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

if TYPE_CHECKING:
    from armsim_ros.recording.flight_recorder import FlightRecorder, Sample


#: Severity of ``rcl_interfaces/msg/Log``.
LOG_LEVELS = {'info': 20, 'warning': 30, 'error': 40}

TF = 'tf2_msgs/msg/TFMessage'
JOINT_STATE = 'sensor_msgs/msg/JointState'
STRING = 'std_msgs/msg/String'
LOG = 'rcl_interfaces/msg/Log'
CONTROLLER_STATE = 'control_msgs/msg/JointTrajectoryControllerState'
TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'

Message = Mapping[str, Any]


class _File:
    """Topics of a file; a type is written once, when it is first used."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._schemas: dict[str, Any] = {}

    def write(self, topic: str, datatype: str, time_ns: int, message: Message) -> None:
        schema = self._schemas.get(datatype)
        if schema is None:
            schema = self._writer.register_msgdef(datatype, message_definition(datatype))
            self._schemas[datatype] = schema
        self._writer.write_message(topic, schema, message, time_ns, time_ns)


def write_recording(
    path: Path, recorder: FlightRecorder, events: Iterable[ControllerEvent]
) -> None:
    """
    Write what a recorder keeps.

    Topics: ``robot_description``, ``joint_states`` and the controllers' ``controller_state`` and
    ``joint_trajectory`` under their usual names, poses of all links and objects in ``/tf``,
    contacts and controllers' words in ``/rosout``.

    :param path: the file; it is replaced.
    :raises OSError: it cannot be written.
    """
    with path.open('wb') as stream:
        writer = Writer(stream)
        file = _File(writer)
        samples = list(recorder.samples)
        overwritten = len(samples) == recorder.samples.maxlen
        start = samples[0].time_ns if overwritten else recorder.start_ns
        for robot in recorder.cell.robots:
            topic = f'{robot.settings.namespace}/robot_description'
            file.write(topic, STRING, start, {'data': robot.model.urdf})
        for sample in samples:
            _write_sample(file, recorder, sample)
        for record in recorder.goals:
            if record.time_ns >= start:
                topic = f'{record.controller}/joint_trajectory'
                message = _trajectory(record.goal.trajectory)
                file.write(topic, TRAJECTORY, record.time_ns, message)
        for event in events:
            if event.time_ns >= start:
                level = LOG_LEVELS[event.level]
                file.write('/rosout', LOG, event.time_ns,
                           _log(event.time_ns, level, event.source, event.text))
        writer.finish()  # type: ignore[no-untyped-call] # mcap's


def _write_sample(file: _File, recorder: FlightRecorder, sample: Sample) -> None:
    time_ns = sample.time_ns
    names = recorder.joint_names
    for robot in recorder.cell.robots:
        own = [i for i, name in enumerate(names) if name in robot.model.joints]
        file.write(robot.settings.joint_states_topic, JOINT_STATE, time_ns, {
            'header': _header(time_ns),
            'name': [names[i] for i in own],
            'position': sample.position[own].tolist(),
            'velocity': sample.velocity[own].tolist(),
            'effort': sample.effort[own].tolist(),
        })
    for name, state in sample.controllers.items():
        file.write(f'{name}/controller_state', CONTROLLER_STATE, time_ns, {
            'header': _header(time_ns),
            'joint_names': list(state.joint_names),
            'reference': _point(state.reference, state.desired_time_from_start),
            'feedback': _point(state.feedback, state.actual_time_from_start),
            'error': _point(state.error, 0.0),
            'output': _point(state.output, 0.0),
            'speed_scaling_factor': state.speed_scaling_factor,
        })
    file.write('/tf', TF, time_ns, {'transforms': [
        _transform(time_ns, name, position, quaternion)
        for name, position, quaternion in zip(
            sample.body_names[1:], sample.body_positions[1:].tolist(),
            sample.body_quaternions[1:].tolist(), strict=True)]})
    for (first, second), depth in zip(
            sample.contact_bodies.tolist(), sample.contact_depths.tolist(), strict=True):
        text = (f"contact '{sample.body_names[first]}' '{sample.body_names[second]}' "
                f'{depth * 1e3:.3f} mm')
        file.write('/contacts', LOG, time_ns, _log(time_ns, 20, 'contacts', text))


def _stamp(time_ns: int) -> Message:
    seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
    return {'sec': seconds, 'nanosec': nanoseconds}


def _header(time_ns: int, frame: str = '') -> Message:
    return {'stamp': _stamp(time_ns), 'frame_id': frame}


def _point(point: TrajectoryPoint, seconds: float) -> Message:
    return {
        'positions': point.positions.tolist(),
        'velocities': point.velocities.tolist(),
        'accelerations': point.accelerations.tolist(),
        'effort': point.effort.tolist(),
        'time_from_start': _stamp(round(seconds * 1e9)),
    }


def _trajectory(trajectory: JointTrajectory) -> Message:
    return {
        'header': _header(trajectory.stamp_ns),
        'joint_names': list(trajectory.joint_names),
        'points': [_point(point, time) for point, time in zip(
            trajectory.points(), trajectory.times.tolist(), strict=True)],
    }


def _transform(
    time_ns: int, body: str, position: list[float], quaternion_wxyz: list[float]
) -> Message:
    x, y, z = position
    qw, qx, qy, qz = quaternion_wxyz
    return {
        'header': _header(time_ns, 'world'),
        'child_frame_id': body.partition('/')[2] or body,
        'transform': {
            'translation': {'x': x, 'y': y, 'z': z},
            'rotation': {'x': qx, 'y': qy, 'z': qz, 'w': qw},
        },
    }


def _log(time_ns: int, level: int, name: str, text: str) -> Message:
    return {'stamp': _stamp(time_ns), 'level': level, 'name': name, 'msg': text,
            'file': '', 'function': '', 'line': 0}
