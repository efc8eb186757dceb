# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reports a launch to the user: processes, missing programs and packages, errors."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
import re
import sys
from typing import Any

from armsim_ros.launch.api.configuration import DeclareLaunchArgument
from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.failures import (
    failure_of,
    import_place,
    MissingArgumentsError,
    MissingPackageError,
)
from armsim_ros.launch.gz_bridge import unserved_topics
from armsim_ros.launch.process_spec import ProcessSpec, ProgramRole, role_of

#: Programs with a window, which may be missing.
GUI_PROGRAMS = frozenset({
    'rviz2', 'rviz', 'rqt', 'rqt_gui', 'rqt_robot_steering', 'rqt_joint_trajectory_controller',
    'joint_state_publisher_gui', 'rqt_image_view', 'rqt_reconfigure', 'plotjuggler',
    'moveit_setup_assistant', 'gzclient',
})


class Report:
    """
    Prints, and counts what is missing.

    :param dry: whether nothing is started: the plan goes to standard output, all else to
        standard error.
    """

    def __init__(self, *, dry: bool, write: Callable[[str], None] | None = None) -> None:
        self.dry = dry
        self.lines: list[str] = []
        #: Everything that keeps the launch file from being evaluated whole.
        self.failures: list[str] = []
        self._write = write
        self._lost: set[str] = set()

    def process(self, spec: ProcessSpec) -> None:
        """Report a process that would be started."""
        self._plan(spec.dry_line())
        unserved = unserved_topics(spec)
        if unserved:
            self.log('WARNING', unserved, spec.name)

    def not_installed(self, spec: ProcessSpec) -> None:
        """Report a process that cannot be started."""
        program = spec.label.rpartition('/')[2]
        self.unknown(f'{spec.label} is not installed and not started',
                     is_loss=program not in GUI_PROGRAMS)

    def unknown(self, text: str, *, is_loss: bool = True) -> None:
        """Report an unknown name."""
        if self.dry:
            self._plan(f'unknown: {text}')
        else:
            self.log('WARNING' if is_loss else 'INFO', f'unknown: {text}')

    def missing_package(self, error: MissingPackageError) -> None:
        """Report a missing package that may not be needed, once."""
        line = f'missing package: {error.package}'
        if self.dry:
            self._plan(line)
        elif line not in self.lines:
            self.lines.append(line)
            self.log('WARNING', f'{line}: {error}')

    def log(self, level: str, text: str, logger: str = 'launch') -> None:
        """Print a line as launch does."""
        if level == 'DEBUG':
            return
        stream = sys.stderr if self.dry else sys.stdout
        print(f'[{level}] [{logger}]: {text}', file=stream, flush=True)

    def failure(self, error: BaseException, file: str) -> None:
        """Report what keeps a launch file from being evaluated."""
        if isinstance(error, EOFError):
            print(file=sys.stderr)  # the question is there without an end of line
        for line in failure_lines(error, file):
            if line in self.failures:
                continue
            self.failures.append(line)
            if not line.startswith('launch: ') and self.dry:
                self._plan(line)
            else:
                print(line if line.startswith('launch: ') else f'launch: {line}',
                      file=sys.stderr, flush=True)

    def keeps_going(self, error: Exception, entity: Any, context: Any) -> bool:
        """
        Report a failure and return whether to go on after the entity that failed.

        Only a dry run does, to name all that is missing. What depends on what was lost is not
        reported again.
        """
        if not self.dry:
            return False
        text = str(error)
        follows = any(f"configuration '{name}'" in text for name in self._lost)
        for name in _sets(entity, context):
            self._lost.add(name)
        if not follows:
            where = getattr(entity, 'where', None)
            if hasattr(error, 'at'):
                error = error.at(where)
            self.failure(error, context.current_file or (str(where) if where else ''))
        return True

    def _plan(self, line: str) -> None:
        if line.startswith('missing package:') and line in self.lines:
            return
        self.lines.append(line)
        if self._write is not None:
            self._write(line)


def failure_lines(error: BaseException, file: str) -> list[str]:
    """Return the lines of a failure's report."""
    if isinstance(error, MissingArgumentsError):
        return error.lines()
    if isinstance(error, MissingPackageError):
        return [f'missing package: {error.package}', f'launch: {failure_of(error, file)}']
    if isinstance(error, ModuleNotFoundError) and error.name is not None:
        return [f'unknown: module {error.name} imported by {import_place(error, file)}']
    if isinstance(error, ImportError) and error.name is not None:
        name = getattr(error, 'name_from', None) or _name_in(str(error))
        return [f'unknown: module {error.name}{"." + name if name else ""} imported by '
                f'{import_place(error, file)}']
    return [f'launch: {failure_of(error, file)}']


def _name_in(text: str) -> str:
    _, found, rest = text.partition("cannot import name '")
    return rest.partition("'")[0] if found else ''


def _sets(entity: Any, context: Any) -> list[str]:
    """Return the names of the configurations that an entity would have set."""
    if isinstance(entity, DeclareLaunchArgument):
        return [entity.name]
    name = getattr(entity, '_name', None)
    if name is None or not hasattr(entity, '_value'):
        return []
    try:
        return [''.join(substitution.perform(context) for substitution in name)]
    except Exception:  # noqa: BLE001 - the name is lost as well
        return []


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
