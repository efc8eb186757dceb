# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names again, when a launch has started, what should have loaded controllers and did not."""

from __future__ import annotations

import asyncio
import re

from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.originals import ProgramRole, role_of
from armsim_ros.launch.process_spec import ProcessSpec
from armsim_ros.launch.report import Report

#: The last line of a move_group's start.
READY = 'You can start planning now!'
#: A launch without move_group has started when no process began or ended for so long [s].
QUIET = 3.0
_LOADS_CONTROLLERS = re.compile(
    r'spawner|controller_manager|(load|configure|switch|set)_controller|ros2 control\b')


class LostControllers:
    """
    The commands of a launch that should have loaded controllers.

    :param report: prints.
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._lost: list[str] = []
        self._starting: set[str] = set()
        self._has_manager = False
        self._timer: asyncio.TimerHandle | None = None

    def started(self, spec: ProcessSpec, name: str, *, is_simulation: bool) -> None:
        """Note that a process runs, and whether it has the controller manager."""
        self._has_manager |= is_simulation
        if role_of(spec) is ProgramRole.MOVE_GROUP:
            self._starting.add(name)
        self._wait()

    def printed(self, name: str, text: str) -> None:
        """Note a line of a process."""
        if text.endswith(READY):
            self._starting.discard(name)
            self._wait()

    def not_started(self, action: ExecuteLocal, spec: ProcessSpec) -> None:
        """Note a process whose program is not installed."""
        self._lose(action, spec, 'is not installed')

    def ended(self, action: ExecuteLocal, spec: ProcessSpec, name: str, status: int) -> None:
        """Note the end of a process."""
        self._starting.discard(name)
        if status:
            self._lose(action, spec, f'has failed with status {status}')
        self._wait()

    def report(self) -> None:
        """Print the lines, once."""
        if self._timer is not None:
            self._timer.cancel()
        lost, self._lost = self._lost, []
        if lost:
            remedy = ("'armsim spawner NAME' loads it" if self._has_manager else
                      'the launch starts no controller manager, so start the launch file of the '
                      "robot's simulation or hardware as well")
            self._report.log('WARNING', 'controllers may be missing, because of '
                             f"{'these lines' if len(lost) > 1 else 'this line'} of the launch "
                             f'file; {remedy}:')
        for line in lost:
            self._report.log('WARNING', line)

    def _lose(self, action: ExecuteLocal, spec: ProcessSpec, how: str) -> None:
        words = spec.node.arguments if spec.node is not None else spec.command
        if _LOADS_CONTROLLERS.search(f"{spec.label} {' '.join(words)}"):
            where = f'{action.where}: ' if action.where else ''
            self._lost.append(f'{where}{spec.label.removeprefix("-/")} {how}')
            self._wait()

    def _wait(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._lost and not self._starting:
            self._timer = asyncio.get_running_loop().call_later(QUIET, self.report)
