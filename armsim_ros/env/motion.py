# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Moves the joints of an environment without controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.sim.grippers.vacuum_gripper import LOOK_NS, VacuumGripper
from armsim_ros.sim.simulation import Simulation

#: Simulated time between checks of cups that all hold something [ns].
HELD_LOOK_NS = 10_000_000


class Motion(Protocol):
    """Moves the joints of an environment."""

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""

    def go(self, end: Vector) -> None:
        """Move from the last command to the next within a step (n,) [rad or m]."""


class JointMotion:
    """
    Commands positions to all drives, and has suction cups check what they hold.

    A step of the environment is one control period of the drives: the reference is a spline from
    command to command, and its dynamics is computed at the commands and interpolated between them.

    :param simulation: its joints must be claimed for positions.
    :param joints: (n,) the joints with drives.
    :param steps: physics steps in a step of the environment.
    """

    def __init__(self, simulation: Simulation, joints: Sequence[str], steps: int) -> None:
        self._simulation, self._steps = simulation, steps
        self._places = np.array([simulation.index[name] for name in joints], dtype=np.intp)
        self._cups: tuple[VacuumGripper, ...] = tuple(simulation.vacuum_grippers.values())
        self._step_ns = simulation.clock.step_ns

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""
        for cup, requested in zip(self._cups, on, strict=True):
            if requested and not cup.on:
                cup.switch_on()
            elif not requested and cup.on:
                cup.switch_off()

    def go(self, end: Vector) -> None:
        """
        Move from the last command to the next within a step.

        :param end: (n,) [rad or m].
        :raises SimulationError: the physics became unstable.
        """
        simulation, steps = self._simulation, self._steps
        simulation.command.position[self._places] = end
        simulation.write_period(steps)
        done = last = 0
        while done < steps:
            stride = max(1, self._until_check() // self._step_ns)
            count = min(max(1, last + stride - done), steps - done)
            simulation.step(count)
            done += count
            if stride <= done - last:
                for cup in self._cups:
                    cup.look((done - last) * self._step_ns)
                last = done

    def _until_check(self) -> int:
        """Return the time between two checks of the cups [ns]."""
        active = [cup for cup in self._cups if cup.on]
        if not active:
            return self._steps * self._step_ns
        return HELD_LOOK_NS if all(cup.held for cup in active) else LOOK_NS
