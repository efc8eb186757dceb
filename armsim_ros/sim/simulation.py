# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated robot in its world: physics behind the hardware interface."""

from __future__ import annotations

from collections.abc import Mapping
import hashlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsim_ros.config.pid_gains import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.control.hardware_interface import (
    ACCELERATION,
    COMMAND_INTERFACES,
    EFFORT,
    HardwareInterface,
    JointArrays,
    POSITION,
    VELOCITY,
)
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.initial_state import initial_positions
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.world_objects import world_objects
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.contacts import Contact, contacts, start_overlaps
from armsim_ros.sim.mujoco_model import build_plant
from armsim_ros.sim.plant import Plant, selector
from armsim_ros.sim.servo import Servo
from armsim_ros.sim.world_scene import WorldScene

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


class Simulation(HardwareInterface):
    """
    One robot in its world, moved by MuJoCo in fixed steps.

    A control period is: controllers read ``state`` and write ``command``; ``write(steps)`` takes
    the commands over; ``step()`` is called ``steps`` times. Nothing here waits or reads a clock.

    :param model: the robot.
    :param settings: physics, servo, start.
    :param world: floor and objects; None is a floor alone.
    :param gains: joint -> gains of its position controller.
    :param clock: simulated time; by default one that starts at 0.
    :raises SimulationError: MuJoCo refuses the robot or the world.
    """

    def __init__(
        self,
        model: RobotModel,
        settings: SimulationSettings | None = None,
        world: WorldSettings | None = None,
        *,
        gains: Mapping[str, PidGains] | None = None,
        clock: SimClock | None = None,
    ) -> None:
        """Build the physics and put the robot into its initial state."""
        super().__init__(model.movable_joints)
        self.model = model
        self.settings = settings or SimulationSettings()
        self.clock = clock or SimClock(self.settings.timestep_ns)
        world = world or WorldSettings()
        spec = build_plant(model, self.settings, world_objects(world), floor=world.floor)
        start = model.complete(initial_positions(model, self.settings))
        self._initial = np.array([start[name] for name in self.joint_names])
        self._servo = Servo(model, self.settings, gains or {})
        self._active = selector([self.index[name] for name in model.active_joints])
        self._plant = Plant(spec, self.joint_names)
        self.world = WorldScene(self._plant)
        self._command_interfaces = {
            name: COMMAND_INTERFACES if model.joints[name].active else ()
            for name in self.joint_names
        }
        self._state_interfaces = {
            name: (POSITION, VELOCITY, ACCELERATION, EFFORT)
            if model.joints[name].active
            else (POSITION, VELOCITY, ACCELERATION)
            for name in self.joint_names
        }
        self.reset()
        self._start_overlaps = start_overlaps(self._plant.model, self._plant.data, model.name)

    @property
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be claimed; a mimic joint has none."""
        return self._command_interfaces

    @property
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        """Joint -> interfaces that can be read; a mimic joint has no effort."""
        return self._state_interfaces

    @property
    def time_ns(self) -> int:
        """Simulated time [ns]."""
        return self.clock.now_ns

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know of robot, world and gains; one line each."""
        return (
            *self._plant.spec.warnings,
            *self._servo.stiffness_warnings(),
            *self._start_overlaps,
        )

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """What touched what in the last step, the deepest first."""
        return contacts(self._plant.model, self._plant.data)

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        """
        Take over a change of claims.

        A joint that is let go holds its last position command, which stays readable; commands
        of other interfaces are forgotten, and the position too once something else drives.

        :param claimed: joint -> interfaces claimed from now on; the others hold their position.
        :raises SimulationError: a joint that cannot be driven, or interfaces that it cannot
            follow together; nothing changes then.
        """
        for name, interfaces in claimed.items():
            if interfaces and not self._command_interfaces.get(name):
                raise SimulationError(self._undriven(name))
        self._servo.switch(claimed)
        for name, i in self.index.items():
            claim = claimed.get(name, frozenset())
            kept = claim or {POSITION}
            for interface in COMMAND_INTERFACES:
                if interface not in kept:
                    self.command.of(interface)[i] = np.nan
                if POSITION not in claim:
                    self.feedforward.of(interface)[i] = np.nan

    def write(self, steps: int = 1) -> None:
        """Take the commands over; they are for the time after ``steps`` physics steps."""
        active = self._active
        self._servo.write(_part(self.command, active), _part(self.feedforward, active), steps)

    def step(self) -> None:
        """
        Do one physics step and refresh ``state``.

        :raises SimulationError: the physics became unstable; ``state`` is still the last good
            one, ``recover`` puts the plant back to it.
        """
        state, active = self.state, self._active
        torques = self._servo.torques(state.position[active], state.velocity[active])
        culprit = self._plant.step(torques)
        self.clock.advance()
        if culprit:
            raise SimulationError(
                f'the physics became unstable at {self.time_ns / 1e9:.3f} s: {culprit}; lower '
                "the joint's gains or the timestep, or raise the armature"
            )
        self._plant.read(state, active)

    def reset(self) -> None:
        """Put robot and objects back to the start; time goes on, claims stay."""
        self._plant.reset(self._initial)
        self._settle_in()

    def recover(self) -> None:
        """Put everything at rest where it last was stable, after ``step`` has raised."""
        self._plant.restore()
        self._settle_in()

    def set_positions(self, positions: Mapping[str, float]) -> None:
        """
        Put joints elsewhere at once, at rest; mimic joints follow.

        :param positions: joint -> [rad or m]; joints that are not there stay.
        :raises SimulationError: a joint that is not there or that follows another.
        """
        for name in positions:
            if not self._command_interfaces.get(name):
                raise SimulationError(self._undriven(name))
        now = dict(zip(self.joint_names, self.state.position, strict=True))
        full = self.model.complete({**now, **positions})
        self._plant.place(np.array([full[name] for name in self.joint_names]))
        self._settle_in()

    def apply_wrench(
        self, link: str, force: ArrayLike = (0, 0, 0), torque: ArrayLike = (0, 0, 0)
    ) -> None:
        """
        Push a link until another wrench is set.

        :param force: (3,) at its centre of mass, world axes [N].
        :param torque: (3,) world axes [N*m].
        :raises SimulationError: a link that is not there.
        """
        self._plant.push(self._link_body(link), force, torque)

    def link_pose(self, link: str) -> Matrix:
        """
        Return where a link is in the world (4, 4).

        :raises SimulationError: a link that is not there.
        """
        return self._plant.pose(self._link_body(link))

    @property
    def mujoco_model(self) -> Any:
        """The ``MjModel``, to look at; an edit of the world replaces it."""
        return self._plant.model

    @property
    def mujoco_data(self) -> Any:
        """The ``MjData``, to look at; an edit of the world replaces it."""
        return self._plant.data

    @property
    def reference_positions(self) -> Vector:
        """Where the drives want all movable joints to be now (n,) [rad or m]."""
        return self._servo.dynamics.expand(self._servo.reference)

    def digest(self) -> str:
        """Return a hash of all that the future depends on: plant, drives, time."""
        parts = hashlib.sha256(self._plant.state_bytes())
        parts.update(self._servo.state_bytes())
        parts.update(self.time_ns.to_bytes(16, 'little', signed=True))
        return parts.hexdigest()

    def _settle_in(self) -> None:
        for interface in COMMAND_INTERFACES:
            self.command.of(interface)[:] = np.nan
            self.feedforward.of(interface)[:] = np.nan
        self._plant.read(self.state, self._active)
        self._servo.restart(self.state.position[self._active])

    def _link_body(self, link: str) -> int:
        if link not in self.model.links:
            raise SimulationError(
                f"robot '{self.model.name}' has no link '{link}'; "
                + (nearest(link, tuple(self.model.links)) or 'see its URDF')
            )
        return self._plant.body(link)

    def _undriven(self, name: str) -> str:
        joint = self.model.joints.get(name)
        if joint is not None and joint.mimic is not None:
            return f"joint '{name}' follows '{joint.mimic.joint}' and cannot be driven itself"
        hint = nearest(name, self.model.active_joints) or ', '.join(self.model.active_joints)
        return f"robot '{self.model.name}' has no joint '{name}' that can be driven; {hint}"


def _part(arrays: JointArrays, which: Any) -> JointArrays:
    return JointArrays(*(arrays.of(name)[which] for name in COMMAND_INTERFACES))
