# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Moves the joints of an environment without controllers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.sim.grippers.vacuum_gripper import LOOK_NS, VacuumGripper
from armsim_ros.sim.simulation import Simulation


class JointMotion:
    """
    Commands positions to all drives, and has suction cups check what they hold.

    A step of the environment is one control period of the drives: the reference is a spline from
    command to command, and its dynamics is computed every ten physics steps.

    :param simulation: its joints must be claimed for positions.
    :param joints: (n,) the joints with drives.
    :param steps: physics steps in a step of the environment.
    """

    def __init__(self, simulation: Simulation, joints: Sequence[str], steps: int) -> None:
        self._simulation, self._steps = simulation, steps
        self._places = np.array([simulation.index[name] for name in joints], dtype=np.intp)
        self._cups: tuple[VacuumGripper, ...] = tuple(simulation.vacuum_grippers.values())
        self._check_steps = max(1, LOOK_NS // simulation.clock.step_ns)

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
        simulation.write(steps)
        done = 0
        if not simulation.resting:
            simulation.step()  # makes the inputs of all steps of the period
            done = 1
        stride = self._check_steps if any(cup.on for cup in self._cups) else steps
        while done < steps:
            count = min(stride - done % stride, steps - done)
            simulation.step(count)
            done += count
            if done % stride == 0:
                for cup in self._cups:
                    cup.look()
