# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm that is stepped in the test's own process: no ROS, no thread, no wall clock."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.config.simulation import JointFault
from armsim_ros.config.world import WorldObjectSettings
from armsim_ros.control.command_controllers.gripper_controller import GripperBase
from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.errors import ControllerError
from armsim_ros.model.cell import Cell
from armsim_ros.model.world_objects import object_from_settings
from armsim_ros.recording.flight_recorder import FlightRecorder
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.vacuum_control import VacuumControl
from armsim_ros.stack import ArmSim
from armsim_ros.testing.arm import Arm, BUILT_WITHOUT_FAULTS, Points, Target, Touch

Pair = tuple[str, str]


class ContactLog:
    """
    Samples the contacts of a simulation, and keeps what has begun to touch.

    Pairs that touch when the log is begun are at rest on each other and left out.

    :param simulation: whose contacts are recorded.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._ended: list[Touch] = []
        self._lasting: dict[Pair, tuple[float, float]] = {}
        self._now = 0.0
        self._last = b''
        self._resting = frozenset(self._deepest())

    def look(self, now_ns: int) -> None:
        """Note what touches at a simulated time [ns]."""
        self._now = now_ns * 1e-9
        bodies, depths = self._simulation.touching()
        signature = bodies[depths >= 0.0].tobytes()
        if not signature and not self._lasting:
            self._last = signature
            return
        if signature == self._last and not self._lasting:
            return  # what rests on something goes on resting
        self._last = signature
        deepest = {
            pair: depth for pair, depth in self._deepest().items() if pair not in self._resting}
        for pair in [pair for pair in self._lasting if pair not in deepest]:
            self._ended.append(self._touch(pair))
            del self._lasting[pair]
        for pair, depth in deepest.items():
            start, before = self._lasting.get(pair, (self._now, 0.0))
            self._lasting[pair] = (start, max(before, depth))

    def touches(self, since: float | None = None) -> tuple[Touch, ...]:
        """Return all touches that lasted beyond a time [s], oldest first; None: all."""
        seen = [*self._ended, *(self._touch(pair) for pair in self._lasting)]
        requested = (touch for touch in seen if since is None or touch.end >= since)
        return tuple(sorted(requested, key=lambda touch: touch.start))

    def _deepest(self) -> dict[Pair, float]:
        bodies, depths = self._simulation.touching()
        names = self._simulation.body_names
        found: dict[Pair, float] = {}
        for i in np.flatnonzero(depths >= 0.0):
            pair = (names[bodies[i, 0]], names[bodies[i, 1]])
            found[pair] = max(found.get(pair, 0.0), float(depths[i]))
        return found

    def _touch(self, pair: Pair) -> Touch:
        start, depth = self._lasting[pair]
        return Touch(pair, start, self._now, depth)


#: Time between samples of the contacts [ns]; a touch of stiff bodies lasts several times that.
LOOK_NS = 2_000_000
#: A suction cup is waited for so long [s].
SUCTION = 2.0
#: Events that a report can show.
KEPT_EVENTS = 200


class TimeLimitError(AssertionError):
    """A test took longer than its marker allows."""


class InProcessArm(Arm):
    """
    A stack of its own for a test, from a build that tests share.

    :param cell: the robot's files.
    :param seed: of the planner's random numbers.
    :param faults: joint -> what is wrong with it from the start.
    :param time_limit: simulated time that the test may take [s].
    """

    def __init__(
        self, cell: Cell, *, seed: int = 0, faults: Mapping[str, Mapping[str, Any]] | None = None,
        time_limit: float = 60.0
    ) -> None:
        self.sim = ArmSim(cell, seed=seed)
        super().__init__(self.sim.model, seed)
        self.events: deque[ControllerEvent] = deque(maxlen=KEPT_EVENTS)
        self.recorder = FlightRecorder(self.sim.cell, self.sim.simulation, self.sim.managers)
        self._time_limit_ns = round(time_limit * 1e9)
        self._contacts = ContactLog(self.sim.simulation)
        self.sim.loop.every(LOOK_NS, self._look)
        self.sim.loop.every(self.recorder.period_ns, self.recorder.sample)
        for joint, fault in (faults or {}).items():
            self.fault(joint, **fault)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.sim.time

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> measured position [rad or m]."""
        return self.sim.joint_positions

    def move_to(self, target: Target, *, group: str = '', speed: float = 1.0) -> None:
        """Plan a motion, execute it, and wait for its end."""
        self.sim.execute(self.sim.plan(target, group, velocity=speed))

    def follow(self, points: Points) -> None:
        """Have the controllers run a trajectory as it is, and wait for its end."""
        self.sim.execute(self.trajectory(points))

    def wait(self, seconds: float) -> None:
        """Let simulated time pass [s]."""
        self.sim.run_until(self.time + seconds)

    def _switch_cups(self, *, on: bool) -> bool:
        """Switch the suction cups; wait until the arm holds something, for a while at most."""
        for cup in self._cups:
            if on:
                cup.on()
            else:
                cup.off()
        if self._cups and on:
            limit = self.time + SUCTION
            self.sim.run_until(lambda: bool(self.sim.held) or self.time >= limit)
        return bool(self._cups)

    def held(self) -> tuple[str, ...]:
        """Return the objects that the arm holds."""
        return tuple(self.sim.held)

    @cached_property
    def _cups(self) -> tuple[VacuumControl, ...]:
        return tuple(VacuumControl(self.sim.loop, cup, lambda: None)
                     for cup in self.sim.simulation.vacuum_grippers.values())

    def _command_grippers(self, state: Mapping[str, float], effort: float) -> bool:
        """Have the active gripper controllers move their joints."""
        grippers = [controller for manager in self.sim.managers.values()
                    for controller in manager.controllers.values()
                    if isinstance(controller, GripperBase) and controller.active
                    and controller.joints[0] in state]
        for gripper in grippers:
            response = gripper.close_to(state[gripper.joints[0]], effort)
            goal = response.goal
            if goal is None:
                raise ControllerError(f"controller '{gripper.name}' refuses: {response.reason}")
            self.sim.run_until(partial(getattr, goal, 'done'))
        return bool(grippers)

    def touches(self, since: float | None = None) -> tuple[Touch, ...]:
        """Return what touched what after a simulated time [s], oldest first; None: ever."""
        return self._contacts.touches(since)

    def fault(self, joint: str, **fault: Any) -> None:
        """Make a joint fail from now on, or be well again where nothing is given."""
        if self.sim.faults is None:
            raise ControllerError(BUILT_WITHOUT_FAULTS)
        self.sim.faults.set_fault(joint, JointFault(**fault))

    def protective_stop(self, cause: str = 'injected') -> None:
        """Stop the arm: goals end, the joints brake and are held until ``clear_stop``."""
        self.sim.protective_stop(cause)

    def clear_stop(self) -> None:
        """
        End a protective stop.

        :raises ControllerError: it goes on; with the reason.
        """
        self.sim.clear_stop()

    @property
    def safety(self) -> str:
        """State of the safety of the first robot, such as ``NORMAL``."""
        return next(iter(self.sim.safety.values()))

    def _switch(self, controller: str, *, active: bool) -> None:
        """Activate or deactivate a controller."""
        for manager in self.sim.managers.values():
            if controller in manager.controllers:
                words = {'activate' if active else 'deactivate': [controller]}
                result = manager.switch(**words, strictness=Strictness.STRICT)
                if not result.ok:
                    raise ControllerError(result.message)
                return
        known = [name for manager in self.sim.managers.values() for name in manager.controllers]
        raise ControllerError(
            f"there is no controller '{controller}'; there are: {', '.join(known)}")

    def _spawn(self, name: str, item: WorldObjectSettings) -> None:
        """Put an object into the world that physics and planner share."""
        self.sim.add_object(object_from_settings(name, item))

    def delete(self, name: str) -> None:
        """
        Take an object out of the world.

        :raises SimulationError: there is none of that name.
        """
        self.sim.remove_object(name)

    def entity(self, name: str) -> Matrix:
        """
        Return where an object is in the world (4, 4).

        :raises SimulationError: there is none of that name.
        """
        return self.sim.simulation.world.pose(name)

    def digest(self) -> str:
        """Return a hash of the state of plant, drives and time."""
        return self.sim.digest()

    def last_events(self) -> tuple[ControllerEvent, ...]:
        """Return what the controllers logged, oldest first."""
        for manager in self.sim.managers.values():
            self.events.extend(manager.poll_events())
        return tuple(sorted(self.events, key=lambda event: event.time_ns))

    def event_lines(self) -> list[str]:
        """Return what the controllers logged, a line each."""
        return [
            f'{event.time_ns * 1e-9:.3f} s {event.level} {event.source}: {event.text}'
            for event in self.last_events()]

    def save_artifacts(self, place: Path) -> Iterator[tuple[str, Path]]:
        """Write the last seconds as MCAP."""
        yield 'recording', self.recorder.save(place.with_name(f'{place.name}.mcap'),
                                              self.last_events())

    def _look(self, now_ns: int) -> None:
        if now_ns > self._time_limit_ns:
            raise TimeLimitError(
                f'the test took more than {self._time_limit_ns * 1e-9:g} s of simulated time; '
                f'{self.summary()}')
        self._contacts.look(now_ns)

    def summary(self) -> str:
        """Return where the arm is, in a line."""
        goals = [
            f"'{name}' runs a goal"
            for manager in self.sim.managers.values()
            for name, controller in manager.controllers.items()
            if getattr(controller, 'active_goal', None) is not None]
        at = ', '.join(f'{joint} {value:.4f}' for joint, value in self.positions.items())
        return '; '.join([*goals, f'at {self.time:.3f} s: {at}'])
