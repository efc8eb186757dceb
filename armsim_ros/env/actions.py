# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an action is, and how it moves the joints without controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.env.gym_base import Box
from armsim_ros.errors import SimulationError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.sim.grippers.vacuum_gripper import LOOK_NS, VacuumGripper
from armsim_ros.sim.simulation import Simulation


class PositionCommands:
    """
    Commands positions to all drives, and has suction cups look after what they hold.

    :param simulation: its joints must be claimed for positions.
    :param joints: (n,) the joints with drives.
    :param steps: physics steps in a control period.
    """

    def __init__(self, simulation: Simulation, joints: Sequence[str], steps: int) -> None:
        self._simulation, self._steps = simulation, steps
        self._places = np.array([simulation.index[name] for name in joints], dtype=np.intp)
        self._cups: tuple[VacuumGripper, ...] = tuple(simulation.vacuum_grippers.values())
        self._periods_per_look = max(1, LOOK_NS // (steps * simulation.clock.step_ns))

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""
        for cup, requested in zip(self._cups, on, strict=True):
            if requested and not cup.on:
                cup.switch_on()
            elif not requested and cup.on:
                cup.switch_off()

    def go(self, start: Vector, end: Vector, periods: int) -> None:
        """
        Move from a command to the next within some control periods.

        :param start: (n,) the last command [rad or m].
        :param end: (n,) [rad or m].
        :raises SimulationError: the physics became unstable.
        """
        simulation = self._simulation
        rows = start + np.arange(1, periods + 1)[:, None] / periods * (end - start)
        rows[-1] = end
        done = 0
        while done < periods:
            if simulation.can_plan(self._steps):
                left = rows[done : done + len(simulation.plan)]
                self._go_planned(left)
                done += len(left)
                continue
            simulation.command.position[self._places] = rows[done]
            simulation.write(self._steps)
            for _ in range(self._steps):
                simulation.step()
            done += 1
            if done % self._periods_per_look == 0:
                self._look()
        simulation.command.position[self._places] = end

    def _go_planned(self, rows: Matrix) -> None:
        simulation, count = self._simulation, len(rows)
        simulation.begin_plan()
        simulation.plan.position[:count, self._places] = rows
        simulation.take_plan(count, self._steps)
        stride = self._periods_per_look if any(cup.on for cup in self._cups) else count
        for end in range(stride, count + stride, stride):
            simulation.follow_plan(min(end, count))
            self._look()
        simulation.end_plan()

    def _look(self) -> None:
        for cup in self._cups:
            cup.look()


ActionKind = Literal['position', 'velocity', 'twist']
KINDS: tuple[ActionKind, ...] = ('position', 'velocity', 'twist')

#: Range of a joint that has no limits [rad or m].
_UNBOUNDED = 2.0 * np.pi
#: Fastest action of a joint without a velocity limit [rad/s or m/s].
_UNLIMITED_SPEED = 1.0
#: Keeps joint velocities small next to a singularity (damped least squares).
_DAMPING = 1e-4


class Actions:
    """
    Reads action vectors.

    :param kind: what the first numbers are: a position of each joint at the end of the step, a
        velocity of each joint, or the tip's linear and angular velocity in world axes, after
        which come positions of the joints that do not move the tip.
    :param kinematics: of the robot.
    :param joints: (n,) all joints with drives.
    :param group: planning group whose tip a twist moves.
    :param tip: its link.
    :param world: (3, 3) axes of the model frame in the world.
    :param twist: fastest linear [m/s] and angular [rad/s] velocity.
    :param cups: names of the suction cups; each has a number at the end, above 0.5 is on.
    :param period: time of a step [s].
    """

    def __init__(
        self,
        kind: ActionKind,
        kinematics: KinematicModel,
        joints: tuple[str, ...],
        group: str,
        tip: str,
        world: Matrix,
        *,
        twist: tuple[float, float],
        cups: tuple[str, ...],
        period: float,
    ) -> None:
        self._kind, self._kinematics, self._period = kind, kinematics, period
        self._group, self._tip, self._world = group, tip, world
        places = np.array([kinematics.index(name) for name in joints], dtype=np.int64)
        lower, upper = kinematics.lower[places], kinematics.upper[places]
        speed = kinematics.velocity_limits[places]
        self.lower = np.where(np.isfinite(lower), lower, -_UNBOUNDED)
        self.upper = np.where(np.isfinite(upper), upper, _UNBOUNDED)
        self.speed = np.where(np.isfinite(speed), speed, _UNLIMITED_SPEED)
        self._places, self._cups = places, len(cups)
        moved = kinematics.group_indices(group).tolist() if kind == 'twist' else []
        self._moved = np.array([places.tolist().index(i) for i in moved], dtype=np.int64)
        self._others = np.flatnonzero(~np.isin(places, moved))
        names = {
            'position': joints,
            'velocity': tuple(f'velocity of {name}' for name in joints),
            'twist': ('x', 'y', 'z', 'about x', 'about y', 'about z',
                      *(joints[i] for i in self._others)),
        }[kind]
        self.names = (*names, *cups)
        """What each number of an action is."""
        reach = np.repeat(twist, 3)
        low, high = {
            'position': (self.lower, self.upper),
            'velocity': (-self.speed, self.speed),
            'twist': (np.append(-reach, self.lower[self._others]),
                      np.append(reach, self.upper[self._others])),
        }[kind]
        self.space = Box(np.append(low, np.zeros(len(cups))), np.append(high, np.ones(len(cups))),
                         dtype=np.float64)

    def read(self, action: Vector, start: Vector) -> tuple[Vector, tuple[bool, ...]]:
        """
        Return where the joints shall be at the end of the step, and which cups shall be on.

        What is beyond the action space is taken as its bound.

        :param start: (n,) where they are commanded to be now [rad or m].
        :returns: (n,) [rad or m], and a value for each cup.
        :raises SimulationError: it is no such vector.
        """
        values = np.asarray(action, dtype=np.float64)
        if values.shape != self.space.shape or not np.isfinite(values).all():
            raise SimulationError(
                f'an action is {len(self.names)} finite numbers ({", ".join(self.names)}); got '
                f'{values.shape}: {values}')
        values = np.clip(values, self.space.low, self.space.high)
        cups = tuple((values[len(values) - self._cups:] > 0.5).tolist())
        values = values[: len(values) - self._cups]
        if self._kind == 'position':
            return values, cups
        if self._kind == 'velocity':
            target = start + self._period * values
        else:
            target = start + self._period * self._velocities(values[:6], start)
            target[self._others] = values[6:]
        return np.clip(target, self.lower, self.upper), cups

    def _velocities(self, twist: Vector, start: Vector) -> Vector:
        """Return velocities (n,) that move the tip so on average over the step."""
        first = self._solve(twist, start)
        velocity = self._solve(twist, start + 0.5 * self._period * first)
        return velocity / max(1.0, float(np.max(np.abs(velocity) / self.speed)))

    def _solve(self, twist: Vector, positions: Vector) -> Vector:
        q = self._kinematics.default()
        q[self._places] = positions
        jacobian = self._kinematics.jacobian(
            self._kinematics.apply_mimic(q), self._tip, self._group)
        turn = self._world.T
        requested = np.concatenate((turn @ twist[:3], turn @ twist[3:]))
        square = jacobian @ jacobian.T + _DAMPING * np.eye(6)
        velocity = np.zeros(len(positions))
        velocity[self._moved] = jacobian.T @ np.linalg.solve(square, requested)
        return velocity
