# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A second attempt at a request that takes long, in a process of its own, by other chances.

The time of a search by chance has a long tail: of two attempts the quicker one is often much
quicker. The process is started for the first request that takes long, so whoever has none never
pays for it, and it ends when nothing was asked of it for a while.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
import math
import os
import subprocess
import sys
import time

from armsim_ros.errors import PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.log import Log, silent_log
from armsim_ros.planning.messages import readable, received, send
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ
from armsim_ros.planning.request import MotionPlanRequest, MotionPlanResponse
from armsim_ros.planning.scene_content import SceneContent
from armsim_ros.planning.settings import PlanningSettings

POLL = 0.002
"""Time [s] between two looks at what the process says."""

MOST_STARTS = 3
"""A process that ended so often before it was ready is not started again."""

MOST_GIVEN = 2
"""A job is given to one more process where the first one died of it, or before it."""

READY, GIVE_UP = 'ready', 'give up'
_PROGRAM = 'from armsim_ros.planning.second_planner import main; main()'


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """
    A request for the process.

    :param robot: given with the first job of a process.
    """

    number: int
    robot: RobotModel | None
    settings: PlanningSettings
    content: SceneContent
    request: MotionPlanRequest


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What the process found."""

    number: int
    response: MotionPlanResponse


class Race:
    """
    One request, planned here and after a while by the process as well.

    :param process: the other side.
    :param job: makes the job, with the time that is left.
    :param begins: when the process begins, on the clock of ``time.monotonic`` [s].
    :param cancelled: whether nobody wants an answer any more.
    """

    def __init__(
        self, process: SecondProcess, job: Callable[[], Job], begins: float,
        cancelled: Callable[[], bool],
    ) -> None:
        """Begin without the process."""
        self._process = process
        self._job = job
        self._numbers: list[int] = []
        self._answered = False
        self._next_look = begins
        self._cancelled = cancelled
        self._answer: MotionPlanResponse | None = None

    @property
    def answer(self) -> MotionPlanResponse | None:
        """The trajectory of the process, where it was the first to have one."""
        return None if self._cancelled() else self._answer

    def over(self) -> bool:
        """Return whether to stop planning here; polled often."""
        if self._answer is not None or self._cancelled():
            return True
        now = time.monotonic()
        if now >= self._next_look:
            self._next_look = now + POLL
            try:
                self._look()
            except Exception as error:  # noqa: BLE001 - the search here goes on without
                self._next_look = math.inf
                self._process.fail(error)
        return self._answer is not None

    def _look(self) -> None:
        message = self._process.message()
        if isinstance(message, Answer) and message.number in self._numbers:
            self._answered = True
            if message.response.success:
                self._answer = message.response
        if self._process.idle and not self._answered and len(self._numbers) < MOST_GIVEN:
            job = self._job()
            self._numbers.append(job.number)
            self._process.give(job)

    def end(self) -> None:
        """Let the process give up what it still does for this request."""
        if self._numbers and not self._answered:
            self._process.give_up()


class SecondProcess:
    """
    The process, started at the first need; one thread at a time.

    :param robot: what is planned for.
    :param delay: [s] a request has to take before the process begins with it; 0 for never.
    :param log: hears when it cannot be used.
    """

    def __init__(self, robot: RobotModel, delay: float, log: Log) -> None:
        """Start nothing yet."""
        self._robot = robot
        self._delay = delay
        self._log = log
        self._process: subprocess.Popen[bytes] | None = None
        self._ready = self._knows_robot = self._busy = False
        self._starts_in_vain = 0
        self._jobs = 0

    @contextmanager
    def race(
        self, request: MotionPlanRequest, content: SceneContent, settings: PlanningSettings,
        seconds: float, cancelled: Callable[[], bool],
    ) -> Iterator[Race]:
        """
        Have the process plan a request, too, where it takes longer than the delay.

        Left alone are requests that have to be repeatable, or whose planner knows no chance or
        takes all the time that it is given.

        :param content: of the scene that the request comes to.
        :param seconds: that the request has from now on [s].
        """
        began = time.monotonic()
        if self._process is not None and self._process.poll() is not None:
            self._gone()

        def job() -> Job:
            self._jobs += 1
            left = max(began + seconds - time.monotonic(), POLL)
            robot = None if self._knows_robot else self._robot
            return Job(
                self._jobs, robot, settings, content,
                replace(request, allowed_planning_time=left))

        begins = began + self._delay if self._of_use(request, settings) else math.inf
        race = Race(self, job, begins, cancelled)
        try:
            yield race
        finally:
            race.end()

    def _of_use(self, request: MotionPlanRequest, settings: PlanningSettings) -> bool:
        """Return whether chance decides how long a request takes, and may do so."""
        if (
            self._delay <= 0.0 or self._starts_in_vain >= MOST_STARTS
            or max(request.seed, settings.seed) >= 0
            or (request.pipeline_id or settings.default_pipeline) == PILZ
        ):
            return False
        try:
            planner = settings.planners.choose(
                request.planner_id, request.group_name, silent_log())
        except PlanningError:
            return False
        return not planner.takes_all_time

    @property
    def idle(self) -> bool:
        """Whether a job can be given."""
        return self._ready and not self._busy

    @property
    def pid(self) -> int | None:
        """Number of the process, while it runs."""
        return None if self._process is None else self._process.pid

    def message(self) -> object:
        """Return what the process says, None for nothing; start it where it does not run."""
        if self._process is None:
            if self._starts_in_vain < MOST_STARTS:
                self._start()
            return None
        assert self._process.stdout is not None
        if not readable(self._process.stdout.fileno()):
            return None
        message = received(self._process.stdout.fileno())
        if message is None:
            self._gone()
        elif message == READY:
            self._ready = True
        else:
            self._busy = False
        return message

    def give(self, job: Job) -> None:
        """Give the process something to do."""
        self._busy = self._knows_robot = True
        self._send(job)

    def give_up(self) -> None:
        """Take back what the process has to do; its answer comes nevertheless."""
        if self._process is not None:
            self._send(GIVE_UP)

    def fail(self, error: Exception) -> None:
        """Never use a process again."""
        self._log.warning(
            'requests are planned without a second attempt from now on: '
            f'{type(error).__name__}: {error}')
        self._starts_in_vain = MOST_STARTS
        self.close()

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._gone()

    def _start(self) -> None:
        try:
            self._process = subprocess.Popen(
                [sys.executable, '-c', _PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, start_new_session=True, bufsize=0,
                env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'})
        except OSError as error:
            self._starts_in_vain = MOST_STARTS
            self._log.warning(f'no process for second attempts can be started: {error}')

    def _send(self, message: object) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            send(self._process.stdin.fileno(), message)
        except BrokenPipeError:
            self._gone()

    def _gone(self) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        if self._starts_in_vain < MOST_STARTS:
            self._starts_in_vain = 0 if self._ready else self._starts_in_vain + 1
            if self._starts_in_vain == MOST_STARTS:
                self._log.warning('the process for second attempts does not start; requests '
                                  'are planned without')
        self._process.kill()
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()
        self._process = None
        self._ready = self._knows_robot = self._busy = False
