# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The loop that alone moves time: requests, controllers, physics, listeners.

Before an update the loop asks the controllers for how many updates ahead all commands are known:
at rest those that change no command, in a motion those whose references follow from the
trajectory. Such updates are planned instead of made, and their physics steps are done together.
The plan ends where the next update has to be made: where the caller or a listener observes the
robot after it, a controller fails, a joint is not where the plan expects it, or there is something
new for the controllers.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
import threading
from typing import Any, TypeVar

from armsim_ros.control.controllers import Controllers
from armsim_ros.control.mailbox import Mailbox
from armsim_ros.errors import SimulationError
from armsim_ros.sim.clock import steps_per_update
from armsim_ros.sim.pacer import Alarm, Pacer, PaceStatistics, prioritize_thread
from armsim_ros.sim.simulation import MOST_PLANNED, Simulation

Result = TypeVar('Result')

#: Requests served in a tick, so that a burst of them does not delay the physics.
REQUESTS_PER_TICK = 8
#: Physics steps of a plan at rest at most, so that a request does not wait long.
MOST_STEPS_AT_REST = 1000
#: Updates of a motion that are worth a plan.
LEAST_PLANNED = 3
#: Physics steps after which requests are served where no pace is kept.
UNPACED_STEPS = 40
#: Longest wall time for which the loop dozes while no request comes [ns].
LONGEST_DOZE_NS = 20_000_000
#: Faults that are kept for ``poll_faults``.
KEPT_FAULTS = 100


class _Listener:
    """A function that is called in simulated time's rhythm."""

    __slots__ = ('due_ns', 'function', 'period_ns')

    def __init__(self, period_ns: int, function: Callable[[int], object], due_ns: int = 0) -> None:
        self.period_ns, self.function, self.due_ns = period_ns, function, due_ns

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

    A tick is a physics step; the controllers run first where their period begins. Only the
    thread that ticks may touch simulation and clock; others hand it a function by ``call``.

    Planned updates change no result; ``run`` sleeps through them until a listener is due.

    :param simulation: the plant.
    :param controllers: the controller manager.
    :param update_rate: rate of the controllers [Hz]; its period must hold a whole number of
        physics steps.
    :param pacer: keeps ``run`` to the wall clock; ``tick`` does without.
    :param priority: SCHED_FIFO priority that ``run`` asks for; 0 asks for none.
    :raises ControllerError: an update rate that does not fit the timestep.
    """

    def __init__(
        self, simulation: Simulation, controllers: Controllers, update_rate: float, *,
        pacer: Pacer | None = None, priority: int = 0
    ) -> None:
        self.simulation = simulation
        self.clock = simulation.clock
        self.steps_per_update = steps_per_update(self.clock.step_ns, update_rate)
        self._controllers = controllers
        self._period = self.steps_per_update * self.clock.step_ns * 1e-9
        self._step_in_period = 0
        #: Updates of the open plan, 0 where there is none, and physics steps before its first.
        self._planned = self._before = 0
        #: Whether its commands change.
        self._moving = False
        self._longest_motion = MOST_PLANNED
        #: Whether there may be something new for the controllers since the plan was made.
        self._news = False
        self._pacer, self._priority = pacer, priority
        self._alarm: Alarm | None = None
        self._requests: Mailbox[tuple[Callable[[], Any], Future[Any]]] = Mailbox(self._wake)
        controllers.wake_with(self._wake)
        self.clock.on_change = self._wake
        self._listeners: tuple[_Listener, ...] = ()
        self._faults: deque[str] = deque(maxlen=KEPT_FAULTS)
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

    def every(
        self, period_ns: int, function: Callable[[int], object], *, at_once: bool = True
    ) -> None:
        """
        Call a function with the time [ns] once in each period of simulated time.

        It runs in the loop's thread: it must be quick and must not wait. Times are the first
        steps at or after the multiples of the period.

        :param at_once: whether it is called after the next step, too.
        """
        due_ns = 0 if at_once else (self.clock.now_ns // period_ns + 1) * period_ns
        self._listeners = (*self._listeners, _Listener(period_ns, function, due_ns))

    def forget(self, function: Callable[[int], object]) -> None:
        """Call a function of ``every`` no more; only from the thread that ticks."""
        self._listeners = tuple(known for known in self._listeners if known.function != function)

    def tick(self) -> None:
        """Serve requests; unless paused, do a physics step with all that belongs to it."""
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

        :param until: ends it after the step in which it becomes true; it may depend on
            what controllers do, such as the end of a goal, but not on what moves.
        :returns: whether the physics stayed stable.
        """
        clock, stable = self.clock, True
        end = clock.steps + steps
        while stable and clock.steps < end:
            begin, rest = clock.steps, -self._step_in_period % self.steps_per_update
            limit = self._until_observed(end - begin) if end - begin > 1 else 1
            if (self._planned or limit > rest + 1) and self._plan(limit, rest):
                stable = self._move(partial(self._follow, limit))
                if not stable or clock.steps > begin:
                    continue
            if rest == 0:
                self._controllers.update(clock.now_ns, self._period)
                self.simulation.write(self.steps_per_update)
            stable = self._move(partial(self.simulation.step, min(limit, rest) or 1))
            if rest and clock.steps - begin < limit:
                continue
            now_ns = clock.now_ns
            for listener in self._listeners:
                listener.tick(now_ns)
            if until is not None and until():
                break
            if clock.steps < end:
                self.on_handed_over()
        return stable

    def restart(self, reason: str, *, states: bool = True, time: bool = False) -> None:
        """
        Begin anew; only from the thread that ticks.

        Goals are aborted, controllers stay active and hold where the robot is then.

        :param reason: for clients that wait for a goal.
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
                    self.advance(ticks)
                    continue
                self._end_plan()
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

    def _wall_step_ns(self) -> float:
        """Return the wall time of a tick [ns]; of a pause without a pace, that of a step."""
        return self.clock.wall_step_ns or self.clock.step_ns

    def _unobserved_steps(self) -> int:
        """
        Return how many steps can be made together with the tick after them, when it is due.

        The plan that they belong to stays open, and states that it has to read now are read.
        """
        paced = self.clock.wall_step_ns or self.clock.paused
        if self._requests or not paced:
            return 0
        longest = int(LONGEST_DOZE_NS // self._wall_step_ns())
        if self.clock.paused:
            return longest
        steps, limit = self.steps_per_update, self._until_observed(longest)
        rest = -self._step_in_period % steps
        free = max(0, min(limit - 1, rest))
        # At rest, what is due now is read in time even where no update can be left out; and one
        # more update is planned: if it changes and reads nothing, it may be made late, too.
        more = steps if self.simulation.resting else 0
        if free < rest or not self._plan(max(limit + more, rest + steps + 1), rest):
            return free
        controllers, planned = self._controllers, self._planned
        reading = controllers.next_reading(0, planned)
        if reading == rest == 0:
            controllers.read(0)
            reading = controllers.next_reading(0, planned)
        horizon = planned if self._moving else reading
        most = (limit - 1 - rest) // steps
        if not self._moving and horizon > most:
            return limit - 1
        free += max(0, min(horizon, most)) * steps
        if free == 0:
            self._end_plan()
        return free

    def _until_observed(self, limit: int) -> int:
        """Return the steps until a listener is called, at most the limit."""
        now_ns, step_ns = self.clock.now_ns, self.clock.step_ns
        for listener in self._listeners:
            limit = min(limit, listener.steps_until_due(now_ns, step_ns))
        return limit

    def _plan(self, limit: int, rest: int) -> bool:
        """
        Have updates planned, unless a valid plan is open; return whether there is a plan.

        :param limit: steps until the robot is observed; the last update before is not planned.
        :param rest: steps until the next update.
        """
        if self._planned:
            if self._moving or not self._news:
                return True
            self._end_plan()
        simulation, steps = self.simulation, self.steps_per_update
        most = (limit - 1 - rest) // steps
        if most < 1:
            return False
        self._moving = not simulation.resting
        if self._moving:
            most = min(most, self._longest_motion)
            if rest or most < LEAST_PLANNED or not simulation.can_plan(steps):
                return False
            simulation.begin_plan()
        else:
            most = min(most, MOST_STEPS_AT_REST // steps)
        self._news = False
        time_ns = self.clock.now_ns + rest * self.clock.step_ns
        planned = self._controllers.plan(most, time_ns, self._period, moving=self._moving)
        if planned:
            simulation.take_plan(planned, steps)
            if self._moving and simulation.resting:
                # The motion dwells: the drives come to rest in the next update.
                planned = simulation.end_plan()
        self._planned, self._before = planned, rest
        return planned > 0

    def _follow(self, limit: int) -> None:
        """
        Do the steps of planned updates, as long as the plan holds, and end it.

        :param limit: steps until the robot is observed.
        :raises SimulationError: the physics became unstable.
        """
        simulation, controllers = self.simulation, self._controllers
        updates = min(self._planned, (limit - 1 - self._before) // self.steps_per_update)
        self._news = False
        try:
            if updates > 0 and self._before:
                simulation.step(self._before)
            update = controllers.next_reading(0, updates)
            while simulation.follow_plan(update) and update < updates and controllers.read(update):
                if self._news:
                    updates = update + 1
                update = controllers.next_reading(update + 1, updates)
        finally:
            done = self._end_plan()
            if self._moving:
                # What cannot be foreseen, such as a joint that is blocked, is not planned far.
                self._longest_motion = min(2 * done + LEAST_PLANNED, MOST_PLANNED)

    def _end_plan(self) -> int:
        """End the open plan, if any; return how many of its updates were done."""
        if not self._planned:
            return 0
        self._planned = 0
        done = self.simulation.end_plan()
        if done:
            self._controllers.pass_updates(done, self._period)
        return done

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
        """End a doze, for something new; from any thread."""
        self._news = True
        if self._alarm is not None:
            self._alarm.set()

    def statistics(self) -> PaceStatistics | None:
        """Return how well ``run`` keeps its deadlines; None where it never ran."""
        return self._pacer.statistics() if self._pacer else None

    def poll_faults(self) -> list[str]:
        """Return the faults of the physics since the last call; from any thread."""
        return [self._faults.popleft() for _ in range(len(self._faults))]

    def _serve(self) -> None:
        if not self._requests:
            return
        for function, future in self._requests.take(REQUESTS_PER_TICK):
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(function())
            except Exception as error:  # noqa: BLE001 - it belongs to the caller
                future.set_exception(error)
