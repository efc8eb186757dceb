# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm that a test moves, whether it is stepped in the test's process or runs in its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.config.world import BoxSettings, PartSettings, ShapeSettings, WorldObjectSettings
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.trajectory import JointTrajectory

Target = str | Mapping[str, float] | Matrix
Points = JointTrajectory | Sequence[tuple[float, Mapping[str, float] | Sequence[float]]]

#: Fingers without a gripper controller move so long [s].
FINGERS_MOVE = 1.0
BUILT_WITHOUT_FAULTS = (
    "joints fail only where the marker sets it: armsim(faults={'joint': {...}})")


@dataclass(frozen=True)
class Touch:
    """
    Two bodies that touched.

    :param bodies: their names: ``robot/link``, ``object/name`` or ``world``.
    :param start: simulated time of the first look that saw it [s].
    :param end: of the last [s].
    :param depth: the deepest overlap [m].
    """

    bodies: tuple[str, str]
    start: float
    end: float
    depth: float

    def names(self, body: str) -> bool:
        """Whether a link, an object or a full name is either of the two."""
        return any(body in (full, full.partition('/')[2]) for full in self.bodies)


class Arm(ABC):
    """
    A robot arm under test; every wait is for simulated time or for a condition.

    :param model: of the robot, or of all robots of a cell.
    :param seed: of the planner's random numbers.
    """

    def __init__(self, model: RobotModel, seed: int) -> None:
        self._model, self.seed = model, seed

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self._model.name

    @property
    @abstractmethod
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    @abstractmethod
    def positions(self) -> dict[str, float]:
        """Joint -> measured position [rad or m]."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints of the first planning group; the order of ``follow``'s points."""
        model = self._model
        group = model.semantic.first_group
        return model.group(group).active_joints if group else model.active_joints

    @cached_property
    def named_states(self) -> dict[str, dict[str, float]]:
        """Named state -> joint -> position [rad or m]; of equal names that of the first group."""
        states: dict[str, dict[str, float]] = {}
        for of_group in self._model.semantic.named_states.values():
            for name, state in of_group.items():
                states.setdefault(name, dict(state))
        return states

    @abstractmethod
    def move_to(self, target: Target, *, group: str = '', speed: float = 1.0) -> None:
        """
        Plan a motion, execute it, and wait for its end.

        :param target: a named state of the group, joint -> position [rad or m], or the pose (4, 4)
            of the group's tip in the model's frame.
        :param group: planning group; by default the first.
        :param speed: share of the velocity limits in 0..1.
        :raises ModelError: the group has no such named state.
        :raises PlanningError: there is no such motion.
        :raises ControllerError: it was refused or aborted.
        """

    @abstractmethod
    def follow(self, points: Points) -> None:
        """
        Have the controllers run a trajectory as it is, and wait for its end.

        :param points: (time from start [s], positions [rad or m]) of each waypoint, the positions
            by joint or in the order of ``joints``; or a trajectory.
        :raises ControllerError: it was refused or aborted; with the reason.
        """

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let simulated time pass [s]."""

    @abstractmethod
    def fault(self, joint: str, **fault: Any) -> None:
        """
        Make a joint fail from now on, or be well again where nothing is given.

        :param fault: ``lag`` [s], ``bias`` [rad or m], ``blocked``.
        :raises ControllerError: an unknown joint, or an arm that was built without faults.
        """

    @contextmanager
    def refusing(self, controller: str) -> Iterator[None]:
        """
        Have a controller refuse all goals within the context: it is inactive then.

        :raises ControllerError: there is no such controller.
        """
        self._switch(controller, active=False)
        try:
            yield
        finally:
            self._switch(controller, active=True)

    @abstractmethod
    def _switch(self, controller: str, *, active: bool) -> None:
        """Activate or deactivate a controller; ControllerError where that cannot be."""

    def grasp(self, effort: float = 0.0) -> None:
        """
        Close the fingers, or switch the suction cup on, and wait for the end of it.

        Fingers go to the first named state whose name begins with ``close``; what is between
        them stops them.

        :param effort: of a gripper controller [N*m or N]; 0 leaves it to its parameters.
        :raises ControllerError: the arm has neither, or a controller refuses.
        """
        if not self._switch_cups(on=True):
            self._move_fingers('close', effort)

    def release(self) -> None:
        """
        Open the fingers, to the first named state that begins with ``open``, or switch off.

        :raises ControllerError: the arm has neither, or a controller refuses.
        """
        if not self._switch_cups(on=False):
            self._move_fingers('open', 0.0)

    @abstractmethod
    def _switch_cups(self, *, on: bool) -> bool:
        """Switch the suction cups, and wait for the end of it; False where there are none."""

    def _move_fingers(self, word: str, effort: float) -> None:
        state = self.finger_state(word)
        if not self._command_grippers(state, effort):
            self.follow([(FINGERS_MOVE, state)])

    @abstractmethod
    def _command_grippers(self, state: Mapping[str, float], effort: float) -> bool:
        """
        Have gripper controllers move joints, and wait for the end of it.

        :param state: joint -> position [rad or m].
        :param effort: [N*m or N]; 0 leaves it to their parameters.
        :returns: False where no gripper controller has any of the joints.
        :raises ControllerError: a controller refuses.
        """

    @abstractmethod
    def held(self) -> tuple[str, ...]:
        """Return the objects that the arm holds."""

    def spawn(
        self, name: str, size: Sequence[float] = (0.05, 0.05, 0.05),
        xyz: Sequence[float] = (0.0, 0.0, 0.0), *, shape: ShapeSettings | None = None,
        rpy: Sequence[float] = (0.0, 0.0, 0.0), mass: float | None = None, friction: float = 0.8,
    ) -> None:
        """
        Put an object into the world that physics and planner share.

        :param size: of a box along x, y, z [m].
        :param xyz: position in the world [m].
        :param shape: another shape than a box, see ``armsim_ros.config.world``.
        :param rpy: roll, pitch, yaw in the world [rad].
        :param mass: [kg]; None for an object that never moves.
        :raises SimulationError: it is refused; with the reason.
        """
        x, y, z = size
        box = BoxSettings(type='box', size=(x, y, z))
        (px, py, pz), (roll, pitch, yaw) = xyz, rpy
        self._spawn(name, WorldObjectSettings(
            parts=[PartSettings(shape=shape or box)],
            xyz=(px, py, pz), rpy=(roll, pitch, yaw), mass=mass, friction=friction))

    @abstractmethod
    def _spawn(self, name: str, item: WorldObjectSettings) -> None:
        """Put an object of a single part into the world."""

    @abstractmethod
    def touches(self, since: float | None = None) -> tuple[Touch, ...]:
        """Return what touched what after a simulated time [s], oldest first; None: ever."""

    @abstractmethod
    def summary(self) -> str:
        """Return where the arm is and what it does, in a line."""

    def digest(self) -> str:
        """Return a hash of the state of plant, drives and time; '' where no run is repeatable."""
        return ''

    def event_lines(self) -> list[str]:
        """Return what controllers and programs logged last, oldest first."""
        return []

    def save_artifacts(self, place: Path) -> Iterator[tuple[str, Path]]:
        """
        Write what helps to understand a failure.

        :param place: path without a suffix.
        :returns: kind and path of each file that was written.
        :raises OSError: a file cannot be written.
        """
        yield from ()

    def finger_state(self, word: str) -> dict[str, float]:
        """
        Return joint -> position of the named state that opens or closes the fingers.

        :param word: ``open`` or ``close``.
        :raises ControllerError: there is no such state.
        """
        for name, state in self.named_states.items():
            if name.lower().startswith(word):
                return state
        raise ControllerError(
            f"{self.name} has no suction cup, and no named state that begins with '{word}'; "
            f'there are: {", ".join(self.named_states) or "none"}; add a state for the fingers to '
            'the SRDF')

    def distance(self, target: Target) -> tuple[str, float]:
        """Return the joint that is farthest from a target state, and how far [rad or m]."""
        requested = self.state(target)
        now = self.positions
        worst = max(requested, key=lambda joint: abs(now[joint] - requested[joint]))
        return worst, now[worst] - requested[worst]

    def state(self, target: Target) -> Mapping[str, float]:
        """
        Return joint -> position of a named state or of joints [rad or m].

        :raises ValueError: a pose, or a state or joint that there is not.
        """
        if isinstance(target, str):
            states = self.named_states
            if target not in states:
                raise ValueError(
                    f"there is no named state '{target}'; there are: {', '.join(states)}")
            return states[target]
        if not isinstance(target, Mapping):
            raise ValueError('a pose is not a joint state; give a named state or joint positions')
        unknown = [joint for joint in target if joint not in self.positions]
        if unknown:
            raise ValueError(
                f"there is no joint '{unknown[0]}'; there are: {', '.join(self.positions)}")
        return target

    def trajectory(self, points: Points) -> JointTrajectory:
        """
        Return the trajectory of points given as ``follow`` takes them.

        :raises ControllerError: a point without a position for each joint.
        """
        if isinstance(points, JointTrajectory):
            return points
        first: Any = points[0][1] if points else ()
        names = tuple(first) if isinstance(first, Mapping) else self.joints
        rows = []
        for i, (_, at) in enumerate(points):
            values = [at.get(name) for name in names] if isinstance(at, Mapping) else list(at)
            if len(values) != len(names) or None in values or len(at) != len(names):
                raise ControllerError(
                    f'point {i} lacks a position for each of the joints {", ".join(names)}')
            rows.append(values)
        return JointTrajectory(names, np.array([time for time, _ in points]), np.array(rows))
