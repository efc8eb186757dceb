# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The event loop of a launch: visits actions, starts processes, fires events and timers."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine, Iterable, Iterator
from contextlib import contextmanager
import heapq
import itertools
import os
import signal
import sys
import threading
import time
from types import FrameType
from typing import Any

from armsim_ros.errors import Location, USAGE_STATUS
from armsim_ros.launch.api import events
from armsim_ros.launch.api.context import Action, LaunchContext, LaunchDescriptionEntity
from armsim_ros.launch.api.event_handlers import OnIncludeLaunchDescription
from armsim_ros.launch.api.process import ExecuteLocal
from armsim_ros.launch.failures import (
    calling_place,
    MissingArgumentsError,
    MissingPackageError,
    StoppedError,
)
from armsim_ros.launch.lookup import KeptFiles
from armsim_ros.launch.process_spec import ProcessSpec
from armsim_ros.launch.report import Report
from armsim_ros.launch.runner import Runner

#: Processor time that a launch file's code may take without a break [s].
LONGEST_EVALUATION = 30.0
#: Factor by which it may take longer in wall time, waiting or on a busy machine.
_PATIENCE = 4.0
#: How often code that catches everything is interrupted before the process ends.
_TRIES = 5


@contextmanager
def watchdog(seconds: float = LONGEST_EVALUATION) -> Iterator[None]:
    """
    Limit the time of the code inside.

    :param seconds: of processor time; four times as much of wall time [s].
    :raises StoppedError: in the code that runs then, with its line.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    tries = 0
    used, begun = time.process_time(), time.monotonic()

    def stop(_number: int, frame: FrameType | None) -> None:
        nonlocal tries
        if (time.process_time() - used < 0.9 * seconds
                and time.monotonic() - begun < _PATIENCE * seconds):
            return
        tries += 1
        place = _place(frame)
        text = (f'{place}: the launch file does not come to an end; stopped after '
                f'{time.monotonic() - begun:.1f} s')
        if tries > _TRIES:
            print(f'launch: {text}', file=sys.stderr, flush=True)
            os._exit(USAGE_STATUS)
        raise StoppedError(text)

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds, min(1.0, seconds))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _place(frame: FrameType | None) -> Location | None:
    inner = frame
    while inner is not None:
        name = inner.f_code.co_filename
        if not name.startswith('<') and 'armsim_ros' + os.sep + 'launch' not in name \
                and not name.startswith(os.path.dirname(os.__file__)):
            return Location(name, inner.f_lineno)
        inner = inner.f_back
    return calling_place()


#: The most processes of a launch; more means a loop of exit handlers.
MOST_STARTS = 1000


class Engine:
    """
    Runs a launch.

    A job is a function that may queue further ones. Processes that actions ask for are started
    when all jobs are done: what is in the same description starts together, and an error in it
    starts nothing.

    :param context: what substitutions and actions see.
    :param runner: starts processes; that of a dry run lets them end at once.
    :param report: takes what a user should know.
    """

    def __init__(self, context: LaunchContext, runner: Runner, report: Report) -> None:
        self.context = context
        self.handlers: list[Any] = [OnIncludeLaunchDescription()]
        self.is_dry = runner.is_dry
        self.status = 0
        self.files = KeptFiles()
        self._runner, self._report = runner, report
        self._jobs: deque[Callable[[], None]] = deque()
        self._batch: list[tuple[ExecuteLocal, ProcessSpec]] = []
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._starts = 0
        self._is_absent = False
        self._tasks: set[asyncio.Task[Any]] = set()
        # The event of each action that goes on after its visit, None where nothing waits for it.
        self._unfinished: dict[Action, events.ExecutionComplete | None] = {}
        context.engine = self

    # What actions request.

    def visit(self, entity: LaunchDescriptionEntity) -> None:
        """Visit an entity and all that it returns, depth-first."""
        try:
            found = entity.visit(self.context)
        except Exception as error:
            if isinstance(error, MissingArgumentsError) and not self._is_include(entity):
                error = MissingArgumentsError(error.arguments)
            if not self._report.keeps_going(error, entity, self.context):
                raise
            return
        for child in found or ():
            self.visit(child)

    def emit(self, event: Any) -> None:
        """Queue an event; the end of what never ran does not end the launch."""
        if not (self._is_absent and isinstance(event, events.Shutdown)):
            self._jobs.append(lambda: self._handle(event))
            self._runner.wake()

    def executed(self, action: Action) -> None:
        """Emit that an action is complete if a handler waits for it, once it is."""
        event = events.ExecutionComplete(action=action)
        if not any(handler.matches(event) for handler in self.handlers):
            return
        if action in self._unfinished:
            self._unfinished[action] = event
        else:
            self.emit(event)

    def _finish(self, action: Action, *, was_run: bool = True) -> None:
        event = self._unfinished.pop(action, None)
        if event is not None:
            self._emit_end(event, was_run=was_run)

    def call_later(self, action: Action, period: float,
                   due: Callable[[], Iterable[LaunchDescriptionEntity]]) -> None:
        """Visit entities after a time [s]; their action is complete then."""
        scope = self._capture()

        def do() -> None:
            self._visit_all(due(), scope)
            self._finish(action)

        self._unfinished[action] = None
        heapq.heappush(self._timers, (self._runner.now() + period, next(self._order), do))

    def start_process(self, action: ExecuteLocal, spec: ProcessSpec) -> None:
        """Start a process together with the others of its batch."""
        self._starts += 1
        if self._starts > MOST_STARTS:
            raise StoppedError(f'{action.where}: more than {MOST_STARTS} processes were started; '
                               'an exit handler seems to start its own process again')
        self._unfinished[action] = None
        self._batch.append((action, spec))

    def tell_unknown(self, text: str) -> None:
        """Report an unknown name."""
        self._report.unknown(text)

    def tell_missing(self, error: MissingPackageError) -> None:
        """Report a missing package, once."""
        self._report.missing_package(error)

    def log(self, level: str, text: str, logger: str = 'launch') -> None:
        """Print a line as launch does."""
        self._report.log(level, text, logger)

    def run_coroutine(self, action: Action, coroutine: Coroutine[Any, Any, Any]) -> None:
        """Run a user's coroutine concurrently; its action is complete at its end."""
        def ended(task: asyncio.Task[Any]) -> None:
            self._tasks.discard(task)
            self._finish(action)
            self._runner.wake()

        self._unfinished[action] = None
        task = asyncio.get_running_loop().create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(ended)

    # The loop.

    def run(self, description: LaunchDescriptionEntity) -> int:
        """
        Visit a description and wait until everything it started has ended.

        :returns: 0; 1 where a required process failed.
        """
        try:
            return asyncio.run(self._run(description))
        finally:
            self.files.remove()

    async def _run(self, description: LaunchDescriptionEntity) -> int:
        self._runner.open(self)
        try:
            with watchdog():
                self.visit(description)
                self._do_jobs()
            self._start_batch()
            while True:
                self._do_jobs()
                self._start_batch()
                if self._jobs:
                    continue
                if not (self._timers or self._tasks or self._runner.is_busy):
                    break
                await self._runner.wait(self._timers[0][0] if self._timers else None)
                self._take_due()
        finally:
            for task in self._tasks:
                task.cancel()
            await self._runner.close()
        return self.status

    def _do_jobs(self) -> None:
        with watchdog():
            while self._jobs:
                self._jobs.popleft()()

    def _take_due(self) -> None:
        now = self._runner.now()
        while self._timers and self._timers[0][0] <= now:
            self._jobs.append(heapq.heappop(self._timers)[2])

    def _start_batch(self) -> None:
        batch, self._batch = self._batch, []
        if batch and not self.context.is_shutdown:
            self._runner.start(batch)

    # Events.

    def process_started(self, action: ExecuteLocal, name: str, pid: int,
                        spec: ProcessSpec) -> None:
        """Emit the event of a started process."""
        action.started(name, pid, spec)
        self.emit(events.ProcessStarted(action=action, name=name, cmd=spec.command, pid=pid,
                                        cwd=spec.cwd, env=spec.environment))

    def process_ended(self, action: ExecuteLocal, name: str, pid: int, spec: ProcessSpec,
                      status: int, *, was_run: bool = True, is_last: bool = True) -> None:
        """
        Emit the event of an ended process.

        :param is_last: whether the process is not started again.
        :param was_run: whether the process was there at all; the end of the launch does not
            depend on a process that was not.
        """
        event = events.ProcessExited(action=action, name=name, cmd=spec.command, pid=pid,
                                     cwd=spec.cwd, env=spec.environment, returncode=status)
        if was_run or not action.ends_launch:
            scope = self._capture()
            self._jobs.append(lambda: self._visit_all(self._at_end(action, event), scope))
        self._emit_end(event, was_run=was_run)
        if is_last:
            self._finish(action, was_run=was_run)

    def printed(self, action: ExecuteLocal, name: str, pid: int, text: bytes, fd: int) -> None:
        """Emit the event of a process's output."""
        kind = events.ProcessStdout if fd == 1 else events.ProcessStderr
        self._handle(kind(action=action, name=name, pid=pid, text=text, fd=fd))

    def shut_down(self, reason: str, *, failed: bool = False) -> None:
        """End the launch."""
        self.emit(events.Shutdown(reason=reason, due_to_failure=failed))

    def _at_end(self, action: ExecuteLocal, event: Any) -> Iterable[LaunchDescriptionEntity]:
        self.context.extend_locals({'event': event})
        return action.ended(self.context, event)

    def _handle(self, event: Any) -> None:
        if isinstance(event, events.Shutdown):
            self._begin_shutdown(event)
        elif isinstance(event, (events.ShutdownProcess, events.SignalProcess)):
            self._runner.send_signal(event)
        for handler in list(self.handlers):
            if handler in self.handlers and handler.matches(event):
                self._visit_all(handler.handle(event, self.context) or (),
                                getattr(handler, 'scope', None))

    def _emit_end(self, event: Any, *, was_run: bool) -> None:
        def handle() -> None:
            self._is_absent = not was_run
            try:
                self._handle(event)
            finally:
                self._is_absent = False

        self._jobs.append(handle)
        self._runner.wake()

    def _begin_shutdown(self, event: events.Shutdown) -> None:
        if event.due_to_failure:
            self.status = 1
        if self.context.is_shutdown or self.is_dry:
            return
        self.context.is_shutdown = True
        self._timers.clear()
        self._jobs.append(self._runner.stop)

    # Scopes: what an event does later sees the file and the arguments of its place.

    def capture_scope(self, handler: Any) -> None:
        """Remember the scope in which a handler was registered."""
        handler.scope = self._capture()

    def _capture(self) -> tuple[dict[str, Any], dict[str, Any]]:
        return self.context.get_locals_as_dict(), dict(self.context.launch_configurations)

    def _visit_all(self, entities: Iterable[Any], scope: Any) -> None:
        context = self.context
        if scope is None:
            for entity in entities:
                self.visit(entity)
            return
        values, configurations = scope
        event = context.get_locals_as_dict().get('event')
        context.push_locals()
        context.extend_locals({**values, **({'event': event} if event is not None else {})})
        lost = {name: value for name, value in configurations.items()
                if name not in context.launch_configurations}
        context.launch_configurations.update(lost)
        try:
            for entity in entities:
                self.visit(entity)
        finally:
            context.pop_locals()
            for name, value in lost.items():
                if context.launch_configurations.get(name) is value:
                    del context.launch_configurations[name]

    @staticmethod
    def _is_include(entity: Any) -> bool:
        return hasattr(entity, 'launch_description_source')
