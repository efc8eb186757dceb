# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts and ends the processes of a launch and forwards their output; dry, it only prints."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
import contextlib
from dataclasses import dataclass, field
import os
import re
import signal
import subprocess
import sys
import time
from typing import Any, Protocol, TYPE_CHECKING

from armsim_ros.cli.environment import child_environment, die_with_parent, signal_group, StopLadder
from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.failures import missing_module_text
from armsim_ros.launch.lookup import current_lookup
from armsim_ros.launch.mapping import Kind, Mapping, Start
from armsim_ros.launch.process_spec import ProcessSpec
from armsim_ros.launch.report import LostControllers, Report

if TYPE_CHECKING:
    from armsim_ros.launch.engine import Engine


Batch = Sequence[tuple[ExecuteLocal, ProcessSpec]]


class Runner(Protocol):
    """Starts processes and keeps the time."""

    is_dry: bool

    @property
    def is_busy(self) -> bool:
        """Whether anything is running that may still cause events."""

    def open(self, engine: Engine) -> None:
        """Begin; the engine is notified of starts and ends."""

    def start(self, batch: Batch) -> None:
        """Start the processes of a batch."""

    def now(self) -> float:
        """Return the time [s]."""

    async def wait(self, until: float | None) -> None:
        """Wait for an event, at most for a time [s]."""

    def wake(self) -> None:
        """End a wait: there is something to do."""

    def send_signal(self, event: Any) -> None:
        """Send a signal to the processes that an event matches."""

    def stop(self) -> None:
        """Begin to end all processes."""

    async def close(self) -> None:
        """Kill the remaining processes."""


class DryRunner:
    """
    Starts nothing: processes end at once, and time passes only when nothing else is left.

    :param report: takes a line for each process.
    :param is_known: whether a process would be started here.
    """

    is_dry = True
    is_busy = False

    def __init__(self, report: Report, is_known: Callable[[ProcessSpec], bool]) -> None:
        self._report, self._is_known = report, is_known
        self._now = 0.0
        self._started = 0
        self._engine: Engine | None = None

    def open(self, engine: Engine) -> None:
        """Remember the engine."""
        self._engine = engine
        self._changed = asyncio.Event()

    def start(self, batch: Batch) -> None:
        """Print each process and report its end."""
        assert self._engine is not None
        for action, spec in batch:
            self._started += 1
            name = f'{spec.name}-{self._started}'
            if self._is_known(spec):
                self._report.process(spec)
                self._engine.process_started(action, name, 0, spec)
                self._engine.process_ended(action, name, 0, spec, 0)
            else:
                self._report.not_installed(spec)
                self._engine.process_ended(action, name, 0, spec, 0, was_run=False)

    def now(self) -> float:
        """Return the time [s]."""
        return self._now

    async def wait(self, until: float | None) -> None:
        """Let the time pass; without a time, wait for the end of a coroutine."""
        if until is not None:
            self._now = max(self._now, until)
        else:
            await self._changed.wait()
        self._changed.clear()

    def wake(self) -> None:
        """End a wait."""
        self._changed.set()

    def send_signal(self, event: Any) -> None:
        """Do nothing: nothing runs."""

    def stop(self) -> None:
        """Do nothing: nothing runs."""

    async def close(self) -> None:
        """Do nothing: nothing runs."""


#: Last line of a Python program that lacks a module.
_MISSING_MODULE = re.compile(r"ModuleNotFoundError: No module named '([^']+)'")
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
#: Longest line that is printed whole [bytes].
_LONGEST_LINE = 1 << 20


@dataclass
class _Process:
    """A running process."""

    start: Start
    name: str
    process: asyncio.subprocess.Process
    tasks: list[asyncio.Task[Any]] = field(default_factory=list)
    retries: int = 0
    missing_module: str = ''

    @property
    def pid(self) -> int:
        return self.process.pid


class ProcessRunner:
    """
    The runner of a real launch.

    :param report: prints.
    """

    is_dry = False

    def __init__(self, report: Report) -> None:
        self._report = report
        self._count = 0
        self._running: dict[str, _Process] = {}
        self._parts: dict[str, tuple[ExecuteLocal, ProcessSpec]] = {}
        self._starting: set[asyncio.Task[Any]] = set()
        self._stopping = False
        self._interrupts = 0
        self._lost = LostControllers(report)

    def open(self, engine: Engine) -> None:
        """Install the signal handlers."""
        self._engine = engine
        self._mapping = Mapping(engine.files.write)
        self._changed = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        for number in _STOP_SIGNALS:
            self._loop.add_signal_handler(number, self._interrupted, number)

    @property
    def is_busy(self) -> bool:
        """Whether a process runs, or the simulation replaces it."""
        return bool(self._running or self._starting or (self._parts and not self._stopping))

    def start(self, batch: Sequence[tuple[ExecuteLocal, ProcessSpec]]) -> None:
        """Start the processes of a batch."""
        for start in self._mapping.decide(batch):
            if start.simulation is not None:
                self._begin(start.simulation, 'simulation')
            self._count += 1
            name = f'{start.spec.name}-{self._count}'
            if start.kind is Kind.UNKNOWN:
                self._report.not_installed(start.spec)
                self._lost.not_started(start.action, start.spec)
                self._engine.process_ended(start.action, name, 0, start.spec, 0, was_run=False)
            elif start.kind is Kind.RUN:
                self._run(start, name, 0)
            elif start.kind is Kind.REFUSED:
                self._report.log('ERROR', f'{start.action.where}: {start.note}', name)
                self._engine.shut_down(start.note, failed=True)
            else:
                self._report.log(start.level, start.note, name)
                self._engine.process_started(start.action, name, 0, start.spec)
                if start.kind is Kind.DONE:
                    self._engine.process_ended(start.action, name, 0, start.spec, 0)
                else:
                    self._parts[name] = (start.action, start.spec)

    def now(self) -> float:
        """Return the time [s]."""
        return time.monotonic()

    async def wait(self, until: float | None) -> None:
        """Wait for an event, at most for a time [s]."""
        left = None if until is None else max(0.0, until - self.now())
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._changed.wait(), left)
        self._changed.clear()

    def wake(self) -> None:
        """End a wait."""
        self._changed.set()

    def send_signal(self, event: Any) -> None:
        """Send a signal to the processes that an event matches."""
        number = getattr(event, 'signal', signal.SIGINT)
        number = signal.Signals[number] if isinstance(number, str) else signal.Signals(number)
        for process in list(self._running.values()):
            if event.process_matcher(process.start.action):
                self._send(process, number)

    def stop(self) -> None:
        """Begin to end all processes."""
        if self._stopping:
            return
        self._stopping = True
        self._changed.set()
        for name, (action, spec) in self._parts.items():
            self._engine.process_ended(action, name, 0, spec, 0)
        self._parts.clear()
        for process in self._running.values():
            spec = process.start.spec
            ladder = StopLadder(spec.sigterm_timeout, spec.sigterm_timeout + spec.sigkill_timeout)
            (_, first), *later = ladder.rungs
            self._send(process, first)
            for after, number in later:
                self._loop.call_later(after, self._escalate, process, number)

    async def close(self) -> None:
        """Kill the remaining processes."""
        self._lost.report()
        for number in _STOP_SIGNALS:
            self._loop.remove_signal_handler(number)
        for process in self._running.values():
            self._send(process, signal.SIGKILL)
        for process in list(self._running.values()):
            await process.process.wait()

    # Starting and watching ----------------------------------------------------------------------

    def _begin(self, start: Start, name: str) -> None:
        self._count += 1
        self._run(start, f'{name}-{self._count}', 0)

    def _run(self, start: Start, name: str, retries: int, delay: float = 0.0) -> None:
        task = self._loop.create_task(self._start(start, name, retries, delay))
        self._starting.add(task)
        task.add_done_callback(self._starting.discard)
        task.add_done_callback(lambda _: self._changed.set())

    async def _start(self, start: Start, name: str, retries: int, delay: float) -> None:
        if delay:
            await asyncio.sleep(delay)
        if self._engine.context.is_shutdown:
            return
        spec = start.spec
        environment = dict(spec.environment)
        if start.is_ours:
            environment.update({key: value for key, value in child_environment().items()
                                if key in ('PYTHONPATH', 'RCUTILS_COLORIZED_OUTPUT')})
        else:
            paths = environment.get('PYTHONPATH', ''), self._engine.files.source_modules()
            environment['PYTHONPATH'] = os.pathsep.join(filter(None, paths))
        environment.setdefault('PYTHONUNBUFFERED', '1')
        try:
            process = await asyncio.create_subprocess_exec(
                *start.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, env=environment, cwd=spec.cwd, limit=_LONGEST_LINE,
                start_new_session=True,
                preexec_fn=die_with_parent(holds_sigint=start.is_ours))
        except OSError as error:
            self._report.log('ERROR', f'cannot start {start.command[0]}: {error.strerror}', name)
            self._engine.process_ended(start.action, name, 0, spec, 127)
            return
        running = _Process(start, name, process, retries=retries)
        self._running[name] = running
        self._report.log('INFO', f'process started with pid [{process.pid}]', name)
        self._lost.started(spec, name, is_simulation=start.is_simulation)
        if not (start.is_simulation and start.spec.label.endswith('create')):
            self._engine.process_started(start.action, name, process.pid, spec)
        for fd, stream in ((1, process.stdout), (2, process.stderr)):
            assert stream is not None
            running.tasks.append(self._loop.create_task(self._forward(running, stream, fd)))
        self._loop.create_task(self._watch(running)).add_done_callback(_raise)
        if self._stopping:
            self._send(running, signal.SIGINT)

    async def _forward(self, running: _Process, stream: asyncio.StreamReader, fd: int) -> None:
        while True:
            try:
                line = await stream.readline()
            except ValueError:
                line = await stream.read(_LONGEST_LINE)
            if not line:
                return
            sink = sys.stdout if fd == 1 else sys.stderr
            text = line.decode(errors='replace').rstrip('\r\n')
            with contextlib.suppress(BrokenPipeError):
                print(f'[{running.name}] {text}', file=sink, flush=True)
            self._lost.printed(running.name, text)
            if fd == 2 and (missing := _MISSING_MODULE.match(text)):
                running.missing_module = missing[1]
            self._engine.printed(running.start.action, running.name, running.pid, line, fd)
            self._changed.set()

    async def _watch(self, ended: _Process) -> None:
        status = await ended.process.wait()
        # Processes left in its group would hold its pipes open.
        signal_group(ended.pid, signal.SIGKILL)
        await asyncio.wait(ended.tasks, timeout=1.0)
        del self._running[ended.name]
        spec = ended.start.spec
        if status == 0:
            self._report.log('INFO', f'process has finished cleanly [pid {ended.pid}]', ended.name)
        else:
            level = 'INFO' if self._stopping and status in (-2, 130) else 'ERROR'
            words = ' '.join(ended.start.command)
            words = words if len(words) < 300 else words[:300] + '...'
            self._report.log(level, f'process has died [pid {ended.pid}, exit code {status}, cmd '
                             f"'{words}']", ended.name)
            if ended.missing_module:
                lookup, name = current_lookup(), ended.missing_module.split('.')[0]
                text = missing_module_text(
                    ended.missing_module, lookup.module(name), lookup.find(name))
                self._report.log('ERROR', text, ended.name)
        if not self._stopping:
            self._lost.ended(ended.start.action, spec, ended.name, status)
        if ended.start.is_simulation:
            self._simulation_ended(status)
        retries = spec.respawn_max_retries
        respawns = spec.respawn and not self._stopping and not ended.start.is_simulation and (
            retries < 0 or ended.retries < retries)
        if not (ended.start.is_simulation and spec.label.endswith('create')):
            self._engine.process_ended(ended.start.action, ended.name, ended.pid, spec, status,
                                       is_last=not respawns)
        if respawns:
            self._run(ended.start, ended.name, ended.retries + 1, spec.respawn_delay)
        self._changed.set()

    def _simulation_ended(self, status: int) -> None:
        """End what was part of it; a failure ends the launch, which has no robot left."""
        self._mapping.simulation_ended()
        for name, (action, spec) in self._parts.items():
            self._engine.process_ended(action, name, 0, spec, 0)
        self._parts.clear()
        if status != 0 and not self._stopping:
            self._engine.shut_down('the simulation has failed', failed=True)

    # Ending -------------------------------------------------------------------------------------

    def _interrupted(self, number: int) -> None:
        self._interrupts += 1
        if self._interrupts == 1:
            name = 'ctrl-c (SIGINT)' if number == signal.SIGINT else 'SIGTERM'
            self._report.log('WARNING', f'user interrupted with {name}')
            self._engine.shut_down('interrupted')
        else:
            for process in self._running.values():
                self._send(process, signal.SIGTERM if self._interrupts == 2 else signal.SIGKILL)
        self._changed.set()

    def _escalate(self, running: _Process, number: signal.Signals) -> None:
        if self._running.get(running.name) is running:
            self._report.log('ERROR', f"process does not end; sending '{number.name}'",
                             running.name)
            self._send(running, number)

    def _send(self, running: _Process, number: signal.Signals) -> None:
        if running.process.returncode is None:
            signal_group(running.pid, number)


def _raise(task: asyncio.Task[Any]) -> None:
    error = None if task.cancelled() else task.exception()
    if error is not None:
        raise error
