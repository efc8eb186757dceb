# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Has a loop look after a suction cup while it is on, and only then."""

from __future__ import annotations

from collections.abc import Callable

from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.grippers.vacuum_gripper import LOOK_NS, VacuumGripper


class VacuumControl:
    """
    Switches a cup; only in the loop's thread.

    :param loop: steps the physics that the cup is in.
    :param gripper: the cup.
    :param changed: called when an object is grasped or let go.
    """

    def __init__(
        self, loop: ControlLoop, gripper: VacuumGripper, changed: Callable[[], object]
    ) -> None:
        self.gripper = gripper
        self._loop = loop
        self._changed = changed
        self._watched = False
        self._last = ''

    def on(self) -> None:
        """Begin to pull what is near."""
        self.gripper.switch_on()
        if not self._watched:
            self._watched = True
            self._loop.every(LOOK_NS, self._look, at_once=False)

    def off(self) -> None:
        """Let go."""
        self.gripper.switch_off()
        self._notice()

    def _look(self, _: int) -> None:
        self.gripper.look()
        self._notice()
        if not self.gripper.on:
            self._watched = False
            self._loop.forget(self._look)

    def _notice(self) -> None:
        if self.gripper.held != self._last:
            self._last = self.gripper.held
            self._changed()
