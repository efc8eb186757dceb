# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A ring with the last seconds of a simulation, cheap to fill and written only when asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.model.cell import Cell
from armsim_ros.recording.message_definitions import message_definition
from armsim_ros.sim.simulation import Simulation
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

if TYPE_CHECKING:
    from mcap_ros2.writer import Writer


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """
    A moment of the simulation; the arrays are copies.

    :param position, velocity, effort: (n,) of the joints.
    :param body_names: of the bodies whose poses these are.
    :param body_positions: (m, 3) [m] in the world.
    :param body_quaternions: (m, 4) wxyz.
    :param contact_bodies: (k, 2) numbers of the bodies that touch.
    :param contact_depths: (k,) overlaps [m].
    :param controllers: controller's full name -> reference, feedback and error.
    """

    time_ns: int
    position: Vector
    velocity: Vector
    effort: Vector
    body_names: tuple[str, ...]
    body_positions: Matrix
    body_quaternions: Matrix
    contact_bodies: NDArray[np.int32]
    contact_depths: Vector
    controllers: Mapping[str, ControllerSnapshot]


@dataclass(frozen=True, slots=True, eq=False)
class GoalRecord:
    """A trajectory as a controller began to follow it."""

    time_ns: int
    controller: str
    goal: TrajectoryGoal


class FlightRecorder:
    """
    Keeps the last seconds.

    :param cell: the robots, for the descriptions that a recording carries.
    :param seconds: how far back the ring reaches [s].
    :param rate: samples a second of simulated time [Hz].
    """

    def __init__(
        self, cell: Cell, simulation: Simulation, managers: Mapping[str, ControllerManager], *,
        seconds: float = 10.0, rate: float = 50.0
    ) -> None:
        """Make an empty ring; the owner of time calls ``sample`` once a period."""
        self.cell = cell
        self.joint_names = simulation.joint_names
        self.period_ns = round(1e9 / rate)
        self.samples: deque[Sample] = deque(maxlen=max(1, round(seconds * rate)))
        self.goals: deque[GoalRecord] = deque(maxlen=100)
        self.start_ns = simulation.time_ns
        self._simulation, self._managers = simulation, managers
        self._generation: tuple[int, ...] = ()
        self._controllers: dict[str, JointTrajectoryController] = {}
        self._last_goals: dict[str, TrajectoryGoal] = {}
        self._body_names: tuple[str, ...] = ()

    def sample(self, now_ns: int) -> None:
        """Keep this moment; in the thread that moves time [ns]."""
        simulation, state = self._simulation, self._simulation.state
        if self.samples and now_ns < self.samples[-1].time_ns:  # time was reset
            self.samples.clear()
            self.goals.clear()
        generation = tuple(manager.generation for manager in self._managers.values())
        if generation != self._generation:
            self._generation = generation
            self._controllers = self._trajectory_controllers()
        positions, quaternions = simulation.body_poses()
        if len(positions) != len(self._body_names):
            self._body_names = simulation.body_names
        snapshots = {
            name: snapshot
            for name, controller in self._controllers.items()
            if controller.active and (snapshot := controller.snapshot()) is not None}
        for name, snapshot in snapshots.items():
            goal = snapshot.goal
            if goal is not None and goal is not self._last_goals.get(name):
                self._last_goals[name] = goal
                self.goals.append(GoalRecord(now_ns, name, goal))
        self.samples.append(Sample(
            now_ns, state.position.copy(), state.velocity.copy(), state.effort.copy(),
            self._body_names, positions, quaternions, *simulation.touching(), snapshots))

    def frozen(self) -> FlightRecorder:
        """Return a copy that stays as the ring is now; in the thread that moves time."""
        twin = copy(self)
        twin.samples, twin.goals = self.samples.copy(), self.goals.copy()
        return twin

    def save(self, path: Path, events: Iterable[ControllerEvent] = ()) -> Path:
        """
        Write the ring as MCAP.

        :param path: the file, replaced where it exists; its folder is made.
        :param events: log lines to be written along.
        :returns: the file.
        :raises OSError: it cannot be written.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        write_recording(path, self, events)
        return path

    def _trajectory_controllers(self) -> dict[str, JointTrajectoryController]:
        found = {}
        for manager, robot in zip(self._managers.values(), self.cell.robots, strict=True):
            for name, controller in manager.controllers.items():
                if isinstance(controller, JointTrajectoryController):
                    found[f'{robot.settings.namespace}/{name}'] = controller
        return found


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
    from mcap_ros2.writer import Writer  # a simulation seldom writes a recording

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
