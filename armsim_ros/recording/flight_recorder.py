# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A ring with the last seconds of a simulation, cheap to fill and written only when asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.model.cell import Cell
from armsim_ros.sim.simulation import Simulation


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
        self._simulation = simulation
        self._managers = managers
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
            self._body_names, positions, quaternions, *simulation.touching(), snapshots,
        ))

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
        from armsim_ros.recording.mcap_file import write_recording

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
