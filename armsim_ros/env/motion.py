# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Moves a simulation's joints along a line of commands, without controllers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Matrix, Vector
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
        for cup, wanted in zip(self._cups, on, strict=True):
            if wanted and not cup.on:
                cup.switch_on()
            elif not wanted and cup.on:
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
