# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loop that alone moves time: requests, controllers, physics, listeners."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
import threading
from typing import Any, Protocol, TypeVar

from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.sim.pacer import Pacer, PaceStatistics
from armsim_ros.sim.realtime import prioritize_thread
from armsim_ros.sim.simulation import Simulation

Result = TypeVar('Result')

#: Requests served in one tick, so that a burst of them does not delay the physics.
REQUESTS_PER_TICK = 8
#: Faults that are kept until somebody asks.
KEPT_FAULTS = 100


class Controllers(Protocol):
    """What the loop needs of a controller manager."""

    def update(self, time_ns: int, period: float, /) -> object:
        """Read states and write commands for the next period [s]."""

    def process_requests(self, time_ns: int, /) -> object:
        """Take up switches, goals and cancels without moving time."""


class _Listener:
    """A function that is called in simulated time's rhythm."""

    __slots__ = ('due_ns', 'function', 'period_ns')

    def __init__(self, period_ns: int, function: Callable[[int], object]) -> None:
        self.period_ns, self.function, self.due_ns = period_ns, function, 0

    def tick(self, now_ns: int) -> None:
        """Call the function where it is due; after a jump of time at once."""
        if now_ns >= self.due_ns or now_ns < self.due_ns - self.period_ns:
            self.due_ns = (now_ns // self.period_ns + 1) * self.period_ns
            self.function(now_ns)


class ControlLoop:
    """
    Runs controllers and physics, in a thread of its own or tick by tick.

    One tick is one physics step; the controllers run first where their period begins. Only the
    thread that ticks may touch simulation and clock; others hand it a function by ``call``.

    :param simulation: the plant.
    :param controllers: the controller manager.
    :param update_rate: rate of the controllers [Hz]; its period must hold a whole number of
        physics steps.
    :param pacer: keeps ``run`` to the wall clock; ``tick`` does without.
    :param priority: SCHED_FIFO priority that ``run`` asks for; 0 asks for none.
    :raises ControllerError: an update rate that does not fit the timestep.
    """

    def __init__(
        self,
        simulation: Simulation,
        controllers: Controllers,
        update_rate: float,
        *,
        pacer: Pacer | None = None,
        priority: int = 0,
    ) -> None:
        """Prepare; nothing runs yet."""
        self.simulation = simulation
        self.clock = simulation.clock
        self.steps_per_update = steps_per_update(self.clock.step_ns, update_rate)
        self._controllers = controllers
        self._period = self.steps_per_update * self.clock.step_ns * 1e-9
        self._step_in_period = 0
        self._pacer = pacer
        self._priority = priority
        self._requests: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._listeners: tuple[_Listener, ...] = ()
        self._faults: deque[str] = deque(maxlen=KEPT_FAULTS)
        self.has_priority = False

    def call(self, function: Callable[[], Result]) -> Future[Result]:
        """
        Have a function called between two ticks, also while paused; from any thread.

        :returns: its result or its exception; done within a few ticks.
        """
        future: Future[Result] = Future()
        self._requests.append((function, future))
        return future

    def every(self, period_ns: int, function: Callable[[int], object]) -> None:
        """
        Call a function with the time [ns] once in each period of simulated time.

        It runs in the loop's thread: it must be quick and must not wait. Times are the first
        steps at or after the multiples of the period.
        """
        self._listeners = (*self._listeners, _Listener(period_ns, function))

    def tick(self) -> None:
        """Serve requests; unless paused, do one physics step with all that belongs to it."""
        self._serve()
        if self.clock.paused:
            self._controllers.process_requests(self.clock.now_ns)
        else:
            self.advance()

    def advance(self) -> None:
        """
        Do one physics step even while paused; only from the thread that ticks.

        When the physics becomes unstable the plant goes back to where it last was stable, the
        clock is paused, and the reason is kept for ``poll_faults``.
        """
        simulation = self.simulation
        if self._step_in_period == 0:
            self._controllers.update(self.clock.now_ns, self._period)
            simulation.write(self.steps_per_update)
        self._step_in_period = (self._step_in_period + 1) % self.steps_per_update
        try:
            simulation.step()
        except SimulationError as error:
            simulation.recover()
            self.clock.paused = True
            self._faults.append(f'{error}. The simulation is paused in the last stable state')
        now_ns = self.clock.now_ns
        for listener in self._listeners:
            listener.tick(now_ns)

    def run(self, stop: threading.Event) -> None:
        """Tick in the wall clock's rhythm until ``stop`` is set; returns within a tick."""
        pacer = self._pacer or Pacer()
        self._pacer = pacer
        self.has_priority = prioritize_thread(self._priority)
        pacer.start()
        while not stop.is_set():
            pacer.wait(self.clock.wall_step_ns)
            self.tick()
        self._refuse_requests()

    def statistics(self) -> PaceStatistics | None:
        """Return how well ``run`` keeps its deadlines; None where it never ran."""
        return self._pacer.statistics() if self._pacer else None

    def poll_faults(self) -> list[str]:
        """Return the faults of the physics since the last call; from any thread."""
        faults = []
        while self._faults:
            faults.append(self._faults.popleft())
        return faults

    def _serve(self) -> None:
        for _ in range(min(len(self._requests), REQUESTS_PER_TICK)):
            function, future = self._requests.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(function())
            except Exception as error:  # noqa: BLE001 - it belongs to the one who asked
                future.set_exception(error)

    def _refuse_requests(self) -> None:
        while self._requests:
            self._requests.popleft()[1].cancel()


def steps_per_update(step_ns: int, update_rate: float) -> int:
    """
    Return how many physics steps a control period holds.

    :param step_ns: time of one physics step [ns].
    :param update_rate: rate of the controllers [Hz].
    :raises ControllerError: the period does not hold a whole number of steps.
    """
    steps = round(1e9 / (update_rate * step_ns))
    if steps < 1 or abs(steps * step_ns * update_rate * 1e-9 - 1.0) > 1e-6:
        highest = 1e9 / step_ns
        fitting = [highest / n for n in (1, 2, 4, 5, 10)]
        raise ControllerError(
            f'an update rate of {update_rate:g} Hz does not fit a timestep of '
            f'{step_ns * 1e-9:g} s; allowed: {highest:g} Hz by a whole number, such as '
            + ', '.join(f'{rate:g}' for rate in fitting)
        )
    return steps
