# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot in its world: physics behind the hardware interface."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
import math
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.control.hardware_interface import (
    COMMAND_INTERFACES,
    HardwareInterface,
    JointArrays,
    POSITION,
    UpdatePlan,
)
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.world_objects import initial_positions, world_objects
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.drives.drive_modes import MockCommands, offered_commands, offered_states
from armsim_ros.sim.drives.placeholder_efforts import with_sufficient_efforts
from armsim_ros.sim.drives.reference import fingers_driven
from armsim_ros.sim.drives.servo import Servo
from armsim_ros.sim.physics.mujoco_model import build_plant, Ground
from armsim_ros.sim.physics.plant import Plant
from armsim_ros.sim.physics.saved_state import RestorableSimulation
from armsim_ros.sim.sensors import Sensors, sensors_of, SimulatedLinks
from armsim_ros.sim.vacuum_gripper import VacuumGripper
from armsim_ros.sim.world.hull_overlaps import resolve_overlaps
from armsim_ros.sim.world.loaded_world import LoadedWorld
from armsim_ros.sim.world.world_scene import WorldScene

#: In a control period of so many physics steps the dynamics is interpolated between its ends.
LONG_PERIOD = 20
#: Updates that can be planned ahead.
MOST_PLANNED = 100


class Simulation(SimulatedLinks, RestorableSimulation, HardwareInterface):
    """
    A robot in its world, moved by MuJoCo in fixed steps.

    A control period is: controllers read ``state`` and write ``command``; ``write(steps)`` takes
    the commands over; ``step()`` is called ``steps`` times. Nothing here waits or reads a clock.

    :param settings: physics, servo, start.
    :param world: floor and objects; None is a floor alone.
    :param gains: joint -> gains of its position controller.
    :param clock: simulated time; by default starting at 0.
    :raises SimulationError: MuJoCo refuses the robot or the world.
    """

    def __init__(
        self, model: RobotModel, settings: SimulationSettings | None = None,
        world: WorldSettings | LoadedWorld | None = None, *,
        gains: Mapping[str, PidGains] | None = None, clock: SimClock | None = None
    ) -> None:
        super().__init__(model.movable_joints)
        self.settings = settings or SimulationSettings()
        start = model.complete(initial_positions(model, self.settings))
        model, self._effort_lines, weights = with_sufficient_efforts(model, self.settings, start)
        self.model = model
        self.clock = clock or SimClock(self.settings.timestep_ns)
        world = world or WorldSettings()
        items = world.items if isinstance(world, LoadedWorld) else world_objects(world)
        self._world_lines = ((*(f'not used of the world: {line}' for line in world.unused),
                              *world.remarks) if isinstance(world, LoadedWorld) else ())
        floor = world.floor if isinstance(world, LoadedWorld) else world.floor_height
        ground = Ground(floor, world.gravity)
        spec = build_plant(model, self.settings, items, ground)
        self._initial = np.array([start[name] for name in self.joint_names])
        inputs = np.full((9, len(self.joint_names)), np.nan)
        self.command, self.feedforward = JointArrays(*inputs[:4]), JointArrays(*inputs[4:8])
        self.effort_bound = inputs[8]
        self.effort_bound[:] = np.inf
        self._inputs, self._written = inputs, (b'', 0)
        self.plan = UpdatePlan.empty(MOST_PLANNED, len(self.joint_names))
        self._unchecked = np.zeros(len(self.joint_names))
        self._followed, self._update_steps, self._moves = 0, 1, False
        self._active = selector([self.index[name] for name in model.active_joints])
        self._driven_views = None
        if isinstance(self._active, slice):
            self._driven_views = (
                _part(self.command, self._active), _part(self.feedforward, self._active))
        self._plant = Plant(
            spec, self.joint_names, self.state, self._active, fingers_driven(model))
        self._bounded = self.effort_bound.tobytes()
        self._servo = Servo(model, self.settings, gains or {}, self._plant.tune, weights)
        self.gravity_compensated = self._servo.compensated
        self.world = WorldScene(self._plant, items, ground)
        self.vacuum_grippers = {
            name: VacuumGripper(name, gripper, self._plant, self.world)
            for name, gripper in self.settings.vacuum_grippers.items()}
        #: Link -> mass [kg] and centre (3,) [m] of what the drives compensate there.
        self.payloads: dict[str, tuple[float, Vector]] = {}
        self._command_interfaces = {name: offered_commands(model, name)
                                    for name in self.joint_names}
        self._state_interfaces = {name: offered_states(model, name) for name in self.joint_names}
        self._sensors = Sensors(model, self._plant, sensors_of(self.settings.sensors, model))
        self._mock = MockCommands.of(model)
        self.other_commands = {name: math.nan for system in model.hardware
                               for name in system.other_commands}
        self.reset()
        self._overlaps, self.remarks = resolve_overlaps(self._plant, model, self._initial)

    @property
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be claimed; a mimic joint has none."""
        return self._command_interfaces

    @property
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be read; a mimic joint has no effort."""
        return self._state_interfaces

    @property
    def sensor_links(self) -> Mapping[str, str]:
        """Sensor of forces and torques -> the link on which it sits."""
        return self._sensors.load_links

    @property
    def other_states(self) -> Mapping[str, float]:
        """Interface of a sensor or gpio -> its value: commanded, else measured, else initial."""
        found = {name: value for system in self.model.hardware
                 for name, value in system.other_states.items()}
        found.update(self._sensors.read())
        found.update((name, value) for name, value in self.other_commands.items()
                     if name in found and not math.isnan(value))
        found.update(self.given_states)
        return found

    @property
    def time_ns(self) -> int:
        """Simulated time [ns]."""
        return self.clock.now_ns

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know of robot, world and gains; a line each."""
        return (
            *self._world_lines, *self._effort_lines, *self._plant.spec.warnings,
            *self._servo.stiffness_warnings(), *self._overlaps)

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Take over a change of claims.

        A joint that is let go holds its last position command, which stays readable; commands
        of other interfaces are forgotten, and the position too once something else drives. A joint
        that followed velocities rests where its drive's reference is, as if commanded there.

        :param claimed: joint -> interfaces claimed from now on; the others hold their position.
        :raises SimulationError: a joint that cannot be driven, or interfaces that it cannot
            follow together; nothing changes then.
        """
        for name, interfaces in claimed.items():
            if (interfaces and not self._command_interfaces.get(name)
                    and name not in self.device_joints):
                raise SimulationError(self._undriven(name))
        left = dict(zip(self.model.active_joints, self._servo.switch(claimed), strict=True))
        for name, i in self.index.items():
            claim = claimed.get(name, frozenset())
            kept = claim or {POSITION}
            for interface in COMMAND_INTERFACES:
                if interface not in kept:
                    self.command.of(interface)[i] = np.nan
                if POSITION not in claim:
                    self.feedforward.of(interface)[i] = np.nan
            if POSITION in kept and np.isfinite(left.get(name, np.nan)):
                self.command.position[i] = left[name]

    def tare(self, foreign: Collection[str] = ()) -> None:
        """Zero forces and torques of the sensors."""
        self._sensors.tare(foreign)

    def set_payload(self, link: str, mass: float, centre: Sequence[float]) -> None:
        """
        Compensate a load at a link, in place of the link's last.

        :raises SimulationError: a link that is not there.
        """
        self.link_body(link)
        self._servo.set_payload(f'{self.model.name}/{link}', mass, centre)
        self.payloads[link] = mass, np.array(centre, dtype=np.float64)

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:
        """Take over gains of position commands."""
        self._servo.set_gains(gains)

    def write(self, steps: int = 1) -> None:
        """
        Take the commands over; they are for the time after ``steps`` physics steps.

        In a long period without feed-forward they are taken over as by ``write_period``.
        """
        if (steps >= LONG_PERIOD and np.isnan(self.feedforward.velocity).all()
                and self.effort_bound.tobytes() == self._bounded):
            self.write_period(steps)
        else:
            self._write(steps)

    def _write(self, steps: int) -> None:
        written = self._inputs.tobytes(), steps
        if self._servo.resting and written == self._written:
            return
        self._written = written
        if (bounds := self.effort_bound.tobytes()) != self._bounded:
            self._bounded = bounds
            self._plant.bound(self.effort_bound[self._active])
        self._servo.write(*self._driven(), steps)

    @property
    def resting(self) -> bool:
        """Whether the drives have nothing to do as long as no command changes."""
        return self._servo.resting

    def can_plan(self, steps: int) -> bool:
        """Return whether commands of the periods ahead, of so many steps, can be planned."""
        servo = self._servo
        return (steps < LONG_PERIOD and self._mock is None and not servo.resting
                and servo.can_plan(steps))

    def begin_plan(self) -> None:
        """Let controllers write what they know of the updates ahead into ``plan``."""
        self.plan.begin(self.command, self.feedforward)

    def take_plan(self, updates: int, steps: int) -> None:
        """
        Take planned updates over; ``follow_plan`` does their steps, ``end_plan`` ends it.

        While the drives rest, the present commands serve all of them; ``plan`` is not read.

        :param updates: that are planned.
        :param steps: physics steps in the period of each.
        """
        plan, active = self.plan, self._active
        self._followed, self._update_steps = 0, steps
        self._moves = not self._servo.resting
        if self._moves:
            self._servo.plan(
                plan.position[:updates, active], plan.velocity[:updates, active],
                plan.acceleration[:updates, active], steps)

    def follow_plan(self, updates: int) -> bool:
        """
        Do all steps of some planned updates, and refresh ``state`` after them.

        :param updates: the number of the first update, counted from the plan's start, that is
            not done any more.
        :returns: whether they were done; False where the joints are not where the plan expects
            them.
        :raises SimulationError: as ``step``.
        """
        plan, first, begin = self.plan, self._followed, self.clock.steps
        count = (updates - first) * self._update_steps
        try:
            if count <= 0:
                return True
            if not self._moves:
                self.step(count)
                return True
            return self._follow(count, plan.expected[first:updates], plan.weights) == count
        finally:
            self._followed += (self.clock.steps - begin) // self._update_steps

    def end_plan(self) -> int:
        """End the plan; return how many of its updates were done."""
        if self._moves:
            self._servo.end_plan()
        return self._followed

    def write_period(self, steps: int) -> None:
        """
        Take the position commands over, as ``write`` does, for a long period at once.

        Between its ends the dynamics of the reference is interpolated; ``step`` then does many
        steps at once.
        """
        rest = self._servo.resting and self._inputs.tobytes() == self._written[0]
        position = self.command.position[self._active]
        if not rest and self._mock is None and float(position.dot(position)) < np.inf:
            moves = not self._servo.resting or (position != self._servo.reference).any()
            if moves and self._servo.plan_period(position, steps):
                self._written = (b'', 0)
                return
        self._write(steps)
        if not self._servo.resting:
            self._servo.plan_written()

    def step(self, count: int = 1) -> None:
        """
        Do physics steps and refresh ``state``.

        :param count: faster than single steps where so many are ready.
        :raises SimulationError: the physics became unstable; ``state`` is still valid,
            ``recover`` puts the plant back to where it was stable.
        """
        plant, servo = self._plant, self._servo
        if servo.resting:
            self._end_steps(*plant.step(count))
        elif 1 < count <= servo.planned_steps:
            self._follow(count, self.plan.expected[:1], self._unchecked)
        else:
            state, active = self.state, self._active
            for _ in range(count):
                if not servo.resting:
                    plant.drive(servo.next_inputs(state.position[active], state.velocity[active]))
                self._end_steps(*plant.step())

    def _follow(self, count: int, expected: Matrix, weights: Vector) -> int:
        """Do steps with planned inputs, a row of ``expected`` per update; return how many."""
        servo = self._servo
        done, culprit = self._plant.follow(
            *servo.planned(count), count // len(expected), expected, weights)
        servo.pass_steps(done)
        self._end_steps(done, culprit)
        return done

    def _end_steps(self, done: int, culprit: str) -> None:
        self.clock.advance(done)
        if culprit:
            raise SimulationError(
                f'the physics became unstable at {self.time_ns / 1e9:.3f} s: {culprit}; lower '
                "the joint's gains or the timestep, or raise the armature")
        self._plant.read()

    def scale_gains(self, factor: float) -> None:
        """Multiply p, i and d of all drives by a factor, from now on."""
        self._servo.scale_gains(factor)

    @property
    def reference_positions(self) -> Vector:
        """Where the drives want all movable joints to be now (n,) [rad or m]."""
        return self._servo.dynamics.expand(self._servo.reference)

    def _driven(self) -> tuple[JointArrays, JointArrays]:
        """Return commands and feed-forward of the joints with drives."""
        views = self._driven_views or (
            _part(self.command, self._active), _part(self.feedforward, self._active))
        if self._mock is None:
            return views
        return self._mock.arriving(views[0]), self._mock.arriving(views[1])


def _part(arrays: JointArrays, which: Any) -> JointArrays:
    return JointArrays(*(arrays.of(name)[which] for name in COMMAND_INTERFACES))
