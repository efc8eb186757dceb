# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loop that alone moves time: requests, controllers, physics, listeners."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
import threading
from typing import Any, TypeVar

from armsim_ros.control.faults import Controllers
from armsim_ros.control.mailbox import Mailbox
from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.sim.pacer import Alarm, Pacer, PaceStatistics
from armsim_ros.sim.planned_flight import PlannedFlight
from armsim_ros.sim.realtime import prioritize_thread
from armsim_ros.sim.simulation import Simulation

Result = TypeVar('Result')

#: Requests served in one tick, so that a burst of them does not delay the physics.
REQUESTS_PER_TICK = 8
#: Physics steps done in one go at most, so that whoever waits for them does not wait long.
MOST_FREE_STEPS = 1000
#: Physics steps between two looks at requests where no pace is kept.
UNPACED_STEPS = 40
#: Wall time for which the loop dozes at most while nobody asks for anything [ns].
LONGEST_DOZE_NS = 20_000_000
#: Faults that are kept until somebody asks.
KEPT_FAULTS = 100


class _Listener:
    """A function that is called in simulated time's rhythm."""

    __slots__ = ('due_ns', 'function', 'period_ns')

    def __init__(self, period_ns: int, function: Callable[[int], object]) -> None:
        self.period_ns, self.function, self.due_ns = period_ns, function, 0

    def steps_until_due(self, now_ns: int, step_ns: int) -> int:
        """Return after how many steps from now it is called, at least 1."""
        if now_ns < self.due_ns - self.period_ns:
            return 1
        return max(1, -((now_ns - self.due_ns) // step_ns))

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

    Where no update matters, or the controllers know their commands beforehand, steps are done
    many at once, and ``run`` dozes until the next of them that somebody observes, or until it is
    asked for something. That changes no result: whoever looks sees an update made for him.

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
        self.simulation = simulation
        self.clock = simulation.clock
        self.steps_per_update = steps_per_update(self.clock.step_ns, update_rate)
        self._controllers = controllers
        self._period = self.steps_per_update * self.clock.step_ns * 1e-9
        self._step_in_period = 0
        self._pacer = pacer
        self._priority = priority
        self._alarm: Alarm | None = None
        self._requests: Mailbox[tuple[Callable[[], Any], Future[Any]]] = Mailbox(self._wake)
        controllers.wake_with(self._wake)
        self.clock.on_change = self._wake
        self._listeners: tuple[_Listener, ...] = ()
        self._faults: deque[str] = deque(maxlen=KEPT_FAULTS)
        self._flight = PlannedFlight(
            simulation, controllers, self.steps_per_update, self._period)
        self.has_priority = False
        #: Called by the thread that ticks when all that listeners of a time hand over is there.
        self.on_handed_over: Callable[[], object] = lambda: None

    def call(self, function: Callable[[], Result]) -> Future[Result]:
        """
        Have a function called between two ticks, also while paused; from any thread.

        :returns: its result or its exception; done within a few ticks.
        """
        future: Future[Result] = Future()
        self._requests.post((function, future))
        return future

    def every(self, period_ns: int, function: Callable[[int], object]) -> None:
        """
        Call a function with the time [ns] once in each period of simulated time.

        It runs in the loop's thread: it must be quick and must not wait. Times are the first
        steps at or after the multiples of the period.
        """
        self._listeners = (*self._listeners, _Listener(period_ns, function))

    def forget(self, function: Callable[[int], object]) -> None:
        """Call a function of ``every`` no more; only from the thread that ticks."""
        self._listeners = tuple(one for one in self._listeners if one.function != function)

    def tick(self) -> None:
        """Serve requests; unless paused, do one physics step with all that belongs to it."""
        self._serve()
        if self.clock.paused:
            self._controllers.process_requests(self.clock.now_ns)
        else:
            self.advance()

    def advance(self, steps: int = 1, until: Callable[[], bool] | None = None) -> bool:
        """
        Do physics steps even while paused; only from the thread that ticks.

        When the physics becomes unstable the plant goes back to where it last was stable, the
        clock is paused, and the reason is kept for ``poll_faults``; that ends it early.

        :param until: ends it after the step in which it becomes true; it may look at what
            controllers do, such as the end of a goal, but not at what moves.
        :returns: whether the physics stayed stable.
        """
        end = self.clock.steps + steps
        stable = True
        while stable and self.clock.steps < end:
            free = self._free_steps(end - self.clock.steps)
            glanced = free == 0 and self._glance(end - self.clock.steps)
            if glanced:
                free = max(self._free_steps(end - self.clock.steps), self.steps_per_update)
            if free > 0:
                stable = self._coast(free, glanced)
                continue
            before = self.clock.steps
            if self._step_in_period == 0:
                limit = self._until_observed(end - before)
                stable = self._move(partial(self._flight.fly, limit))
            if stable and self.clock.steps == before:
                if self._step_in_period == 0:
                    self._controllers.update(self.clock.now_ns, self._period)
                    self.simulation.write(self.steps_per_update)
                stable = self._step(1)
                now_ns = self.clock.now_ns
                for listener in self._listeners:
                    listener.tick(now_ns)
                if until is not None and until():
                    break
                if self.clock.steps < end:
                    self.on_handed_over()
        return stable

    def restart(self, reason: str, *, states: bool = True, time: bool = False) -> None:
        """
        Begin anew; only from the thread that ticks.

        Goals are aborted, controllers stay active and hold where the robot is then.

        :param reason: for those who wait for a goal.
        :param states: whether robot and world are put back to the start.
        :param time: whether it begins at 0 again; it goes on else.
        """
        self._controllers.interrupt(self.clock.now_ns, reason)
        if states:
            self.simulation.reset()
        if time:
            self.clock.reset()
            self._step_in_period = 0
        self._controllers.resume(self.clock.now_ns)

    def run(self, stop: threading.Event) -> None:
        """Tick in the wall clock's rhythm until ``stop`` is set; returns within a doze."""
        pacer = self._pacer or Pacer()
        self._pacer, self._alarm = pacer, pacer.alarm
        self.has_priority = prioritize_thread(self._priority)
        pacer.start()
        while not stop.is_set():
            pacer.alarm.clear()
            paused = self.clock.paused
            free = self._unobserved_steps()
            self.on_handed_over()
            if free:
                ticks = pacer.doze(self._wall_step_ns(), free + 1)
                if ticks and not (paused or self.clock.paused):
                    self._catch_up(ticks, free)
                    continue
                self._flight.land()
                if self.clock.paused:
                    self.tick()
            elif not (self.clock.wall_step_ns or self.clock.paused):
                self._serve()
                if not self.clock.paused:
                    self.advance(UNPACED_STEPS)
                pacer.breathe()
            else:
                pacer.wait(self._wall_step_ns())
                self.tick()
        for _, future in self._requests.take_all():
            future.cancel()

    def _catch_up(self, ticks: int, free: int) -> None:
        """Make ticks whose time has come; so many steps before them were known to be free."""
        if ticks > free and not self._flight.planned:
            ticks -= free if self._coast(free) else ticks
        self.advance(ticks)

    def _wall_step_ns(self) -> float:
        """Return the wall time of a tick [ns]; of a pause without a pace, that of a step."""
        return self.clock.wall_step_ns or self.clock.step_ns

    def _unobserved_steps(self) -> int:
        """Return how many steps can be made together with the tick after them, when it is due."""
        paced = self.clock.wall_step_ns or self.clock.paused
        if self._requests or not paced:
            return 0
        longest = int(LONGEST_DOZE_NS // self._wall_step_ns())
        if self.clock.paused:
            return longest
        free = self._free_steps(longest)
        if free or self._step_in_period:
            return free
        if self._look_early():
            return self._free_steps(longest)
        free = self._flight.plan(self._until_observed(longest))
        self._flight.look_early()
        return free

    def _until_observed(self, limit: int) -> int:
        """Return the steps until a listener is called, at most the limit."""
        now_ns, step_ns = self.clock.now_ns, self.clock.step_ns
        for listener in self._listeners:
            limit = min(limit, listener.steps_until_due(now_ns, step_ns))
        return limit

    def _free_steps(self, limit: int) -> int:
        """
        Return how many steps can be done in one go from now on, none where the next one counts.

        The last step before the limit, and before a listener is called, counts always.
        """
        simulation = self.simulation
        if limit < 2 or not simulation.ready_steps:
            return 0
        now_ns, step_ns = self.clock.now_ns, self.clock.step_ns
        free = self._until_observed(min(limit, MOST_FREE_STEPS)) - 1
        steps = self.steps_per_update
        rest_of_period = -self._step_in_period % steps
        if not simulation.resting:
            return min(free, rest_of_period, simulation.ready_steps)
        if free <= rest_of_period:
            return free
        update_ns = now_ns + rest_of_period * step_ns
        due_ns = self._controllers.next_update(update_ns)
        # An update that matters is the first at or after its time.
        updates = -((update_ns - due_ns) // (steps * step_ns)) if due_ns > update_ns else 0
        return rest_of_period + min(updates, (free - rest_of_period) // steps) * steps

    def _look_early(self) -> bool:
        """Have states read that are due now, at rest, not in the next tick, which is later."""
        now_ns, controllers = self.clock.now_ns, self._controllers
        if not self.simulation.resting or controllers.next_update(now_ns) > now_ns:
            return False
        due = controllers.only_looks(now_ns)
        if due:
            controllers.look_early(now_ns, self._period)
        return due

    def _glance(self, limit: int) -> bool:
        """
        Do an update that commands nothing, only reads states; return whether it was one.

        The last update before the limit, and before a listener is called, is a whole one.
        """
        steps, now_ns = self.steps_per_update, self.clock.now_ns
        if self._step_in_period or limit <= steps or not self.simulation.resting:
            return False
        if self._until_observed(limit) <= steps:
            return False
        if not self._controllers.only_looks(now_ns):
            return False
        self._controllers.glance(now_ns, self._period)
        return True

    def _coast(self, steps: int, glanced: bool = False) -> bool:
        """Do steps that need no update, except one that was a glance; return as ``_step``."""
        left_out = steps - (-self._step_in_period % self.steps_per_update)
        stable = self._step(steps)
        if left_out > 0:
            updates = left_out // self.steps_per_update - glanced
            self._controllers.skip(updates, self._period)
        return stable

    def _step(self, count: int) -> bool:
        """Do physics steps in one go; return False where the physics became unstable."""
        return self._move(partial(self.simulation.step, count))

    def _move(self, move: Callable[[], object]) -> bool:
        """Move time on; return False, and pause, where the physics became unstable."""
        begin = self.clock.steps
        try:
            move()
        except SimulationError as error:
            self.simulation.recover()
            self.clock.paused = True
            self._faults.append(f'{error}. The simulation is paused in the last stable state')
            return False
        finally:
            done = self._step_in_period + self.clock.steps - begin
            self._step_in_period = done % self.steps_per_update
        return True

    def _wake(self) -> None:
        """End a doze; from any thread."""
        if self._alarm is not None:
            self._alarm.set()

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
        if not self._requests:
            return
        for function, future in self._requests.take(REQUESTS_PER_TICK):
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(function())
            except Exception as error:  # noqa: BLE001 - it belongs to the one who asked
                future.set_exception(error)


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
