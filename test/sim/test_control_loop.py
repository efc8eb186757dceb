# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loop that moves time."""

import threading

from invented_time import invented_pacer
import numpy as np
import pytest

from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.sim.clock import steps_per_update
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import Pacer
from armsim_ros.sim.simulation import Simulation


class Recorder:
    """Controllers that hold still until a time, and write down when they were updated."""

    def __init__(self):
        self.updates = []
        self.requests = []
        self.due_ns = 0
        self.left_out = 0

    def update(self, time_ns, period):
        self.updates.append((time_ns, period))

    def process_requests(self, time_ns):
        self.requests.append(time_ns)

    def plan(self, updates, time_ns, period, *, moving):
        waiting = -((time_ns - self.due_ns) // round(period * 1e9))
        return 0 if moving else max(0, min(updates, waiting))

    def next_reading(self, update, updates):
        return updates

    def pass_updates(self, updates, period):
        self.left_out += updates

    def wake_with(self, wake):
        self.wake = wake

    def interrupt(self, time_ns, reason):
        self.updates.clear()

    def resume(self, time_ns):
        pass


@pytest.fixture
def controllers():
    """Return controllers that move nothing."""
    return Recorder()


@pytest.fixture
def loop(simulation, controllers):
    """Return a loop with controllers at 1 kHz."""
    return ControlLoop(simulation, controllers, 1000)


def test_updates_controllers_at_their_rate(simulation, controllers):
    """At 250 Hz and 1 ms every fourth step begins with an update."""
    loop = ControlLoop(simulation, controllers, 250)
    for _ in range(10):
        loop.tick()
    assert controllers.updates == [(0, 0.004), (4_000_000, 0.004), (8_000_000, 0.004)]
    assert simulation.time_ns == 10_000_000


def test_updates_begin_with_time_after_a_reset(simulation, controllers):
    """The first update is at 0 again, in whichever step of a period the reset came."""
    loop = ControlLoop(simulation, controllers, 250)
    loop.advance(6)
    loop.restart('again', time=True)
    loop.advance(5)
    assert [time_ns for time_ns, _ in controllers.updates] == [0, 4_000_000]


@pytest.mark.parametrize('rate', [300, 2000, 999])
def test_refuses_a_rate_that_does_not_fit(rate):
    """A rate that is no whole part of the physics rate is refused with rates that fit."""
    with pytest.raises(ControllerError, match=f'{rate} Hz.*1000, 500, 250'):
        steps_per_update(1_000_000, rate)


def test_a_pause_stops_time_and_serves_requests(simulation, controllers, loop):
    """P5: while paused time stands still, requests and switches are served."""
    simulation.clock.paused = True
    answer = loop.call(lambda: 42)
    for _ in range(3):
        loop.tick()
    assert answer.result(0) == 42
    assert simulation.time_ns == 0
    assert (len(controllers.requests), controllers.updates) == (3, [])
    loop.advance()
    assert simulation.time_ns == 1_000_000


def test_a_request_s_exception_goes_to_the_one_who_asked(loop):
    """A request that fails does not stop the loop."""

    def refuse():
        raise SimulationError('no')

    answer = loop.call(refuse)
    loop.tick()
    assert isinstance(answer.exception(0), SimulationError)
    loop.tick()


def test_a_burst_of_requests_is_served_in_portions(loop):
    """Many requests take several ticks, in their order."""
    served = []
    for i in range(20):
        loop.call(lambda i=i: served.append(i))
    loop.tick()
    assert 0 < len(served) < 20
    for _ in range(5):
        loop.tick()
    assert served == list(range(20))


def test_listeners_hear_the_multiples_of_their_period(loop):
    """A listener with 10 ms is called at 10, 20, 30 ms; after a jump back at once."""
    heard = []
    loop.tick()
    loop.every(10_000_000, heard.append)
    for _ in range(35):
        loop.tick()
    assert heard == [2_000_000, 10_000_000, 20_000_000, 30_000_000]
    loop.clock.reset()
    loop.tick()
    assert heard[-1] == 1_000_000


def test_an_unstable_plant_pauses_the_loop_with_the_reason(simulation, loop):
    """A fault of the physics is kept for the user; the loop goes on, paused and sane."""
    loop.tick()
    simulation.apply_wrench('hand', force=(1e12, 0.0, 0.0))
    for _ in range(10):
        loop.tick()
    assert simulation.clock.paused
    (fault,) = loop.poll_faults()
    assert 'unstable' in fault
    assert 'paused' in fault
    assert np.isfinite(simulation.state.position).all()
    assert loop.poll_faults() == []


def test_runs_in_a_thread_until_told_to_stop(simulation, controllers):
    """The loop ticks in its thread, answers requests there and ends when it is told."""
    turn = threading.Event()
    loop = ControlLoop(
        simulation, controllers, 1000, pacer=Pacer(clock=lambda: 0, sleep=lambda _: None)
    )
    stop = threading.Event()
    loop.every(50_000_000, lambda time_ns: turn.set() if time_ns >= 50_000_000 else None)
    thread = threading.Thread(target=loop.run, args=(stop,))
    thread.start()
    assert turn.wait(20.0)
    assert loop.call(threading.get_ident).result(20.0) == thread.ident
    stop.set()
    thread.join(20.0)
    assert not thread.is_alive()
    assert loop.statistics().ticks >= 50


def test_updates_that_do_not_matter_are_left_out(simulation, controllers, loop):
    """Steps at rest are done in one go up to the update that matters, and the last one."""
    loop.advance(3)
    controllers.updates.clear()
    controllers.due_ns = 40_000_000
    loop.advance(97)
    assert [time_ns for time_ns, _ in controllers.updates] == [
        *range(40_000_000, 100_000_000, 1_000_000)
    ]
    assert (controllers.left_out, simulation.time_ns) == (37, 100_000_000)
    controllers.due_ns = 10**12
    loop.advance(50)
    assert controllers.updates[-1] == (149_000_000, 0.001)
    assert controllers.left_out == 37 + 49


def test_who_looks_finds_an_update_made_for_him(simulation, controllers, loop):
    """Before a listener is called the controllers are updated, whatever else is left out."""
    loop.advance(3)
    controllers.due_ns = 10**12
    seen = []
    loop.every(10_000_000, lambda time_ns: seen.append((time_ns, controllers.updates[-1][0])))
    loop.advance(37)
    assert seen[1:] == [(t, t - 1_000_000) for t in (10_000_000, 20_000_000, 30_000_000,
                                                     40_000_000)]


@pytest.mark.parametrize('rate', [1000, 250, 100])
def test_steps_in_one_go_keep_the_controllers_rhythm(simulation, controllers, rate):
    """Updates stay at the multiples of their period."""
    loop = ControlLoop(simulation, controllers, rate)
    for due_ns, steps in ((0, 5), (33_000_000, 41), (10**12, 17), (0, 24)):
        controllers.due_ns = due_ns
        loop.advance(steps)
    period = 1_000_000_000 // rate
    assert all(time_ns % period == 0 for time_ns, _ in controllers.updates)
    assert len(controllers.updates) + controllers.left_out == -(-87_000_000 // period)


def test_a_fault_in_many_steps_is_told_as_in_single_ones(arm, settings, controllers):
    """What becomes unstable while the arm rests is found at the step where it happens."""
    told = []
    for steps in ([1] * 500, [500]):
        simulation = Simulation(arm, settings, WorldSettings(floor=False))
        loop = ControlLoop(simulation, controllers, 1000)
        loop.advance(3)
        controllers.due_ns = 10**12
        simulation.apply_wrench('hand', force=(3e5, 0.0, 0.0))
        for count in steps:
            if not simulation.clock.paused:
                loop.advance(count)
        told.append((loop.poll_faults(), simulation.time_ns))
    assert told[0][0]
    assert told[0] == told[1]


def test_a_request_ends_a_doze_and_is_served_at_the_next_tick(simulation, controllers):
    """While nobody looks the loop sleeps; what is asked for is done within a millisecond."""
    pacer, clock, alarm = invented_pacer()
    loop = ControlLoop(simulation, controllers, 1000, pacer=pacer)
    loop.advance(3)
    controllers.due_ns = 10**12
    stop = threading.Event()
    alarm.at = 7_400_000
    served = []

    def request_at_the_alarm(time_ns):
        if not served:
            loop.call(lambda: served.append((clock.now, simulation.time_ns)))
        if clock.now > 60_000_000:
            stop.set()

    controllers.process_requests = controllers.pass_updates = lambda *_: None
    loop.every(7_000_000, request_at_the_alarm)
    loop.run(stop)
    asked, (wall_ns, simulated_ns) = 7_400_000, served[0]
    assert wall_ns <= asked + 1_000_000
    assert simulated_ns - 3_000_000 == wall_ns - wall_ns % 1_000_000 - 1_000_000
    # From then on the simulation has kept up with the wall clock in a few long naps.
    assert simulation.time_ns - 3_000_000 == clock.now
    assert len(controllers.updates) < 30


def test_states_are_read_in_the_tick_of_their_time_at_rest(simulation, controllers):
    """States that are due are read when their time has come, not at the next tick."""
    (pacer, clock, _), stop, read_at = invented_pacer(), threading.Event(), []
    loop = ControlLoop(simulation, controllers, 1000, pacer=pacer)
    loop.advance(3)
    begin, controllers.due_ns = simulation.time_ns, 10**12
    due = [begin + time_ns for time_ns in (17_000_000, 37_000_000, 57_000_000)]

    def next_reading(update, updates):
        first = (due[0] - simulation.time_ns) // 1_000_000
        return min(updates, max(update, first))

    def read(update):
        read_at.append((simulation.time_ns - begin + update * 1_000_000, clock.now))
        due.append(due.pop(0) + 60_000_000)
        if len(read_at) == 3:
            stop.set()
        return True

    controllers.next_reading, controllers.read = next_reading, read
    loop.every(10_000_000, lambda time_ns: None)
    loop.run(stop)
    assert read_at == [(t, t) for t in (17_000_000, 37_000_000, 57_000_000)]


def test_an_arm_at_rest_is_woken_once_for_each_listener(simulation, controllers):
    """An update that changes nothing may be made late, with the steps that follow it."""
    (pacer, clock, _), stop, called = invented_pacer(), threading.Event(), []
    loop = ControlLoop(simulation, controllers, 500, pacer=pacer)
    loop.advance(4)
    controllers.due_ns = 10**12

    def listen(time_ns):
        called.append((time_ns, controllers.updates[-1][0]))
        if len(called) == 11:
            stop.set()

    loop.advance(16)
    loop.every(10_000_000, listen)
    before = clock.naps
    loop.run(stop)
    assert called[1:] == [(t, t - 2_000_000) for t in range(30_000_000, 130_000_000, 10_000_000)]
    assert clock.naps - before <= 22


def test_an_update_that_reads_states_is_made_in_time_at_rest(simulation, controllers):
    """The last update before a listener is not put off where states are due in it."""
    (pacer, clock, _), stop, made_at = invented_pacer(), threading.Event(), []
    loop = ControlLoop(simulation, controllers, 500, pacer=pacer)
    loop.advance(10)
    begin, controllers.due_ns = simulation.time_ns, 10**12
    due_ns = begin + 18_000_000

    def next_reading(update, updates):
        return min(updates, max(update, (due_ns - simulation.time_ns) // 2_000_000))

    def update(time_ns, period):
        if time_ns == due_ns:
            made_at.append(clock.now)
            stop.set()

    controllers.next_reading, controllers.update = next_reading, update
    loop.every(10_000_000, lambda time_ns: None)
    loop.run(stop)
    assert made_at == [19_000_000]


def test_what_was_handed_over_is_told_once_a_time(loop):
    """It is told when all listeners of a time have been called, not after each of them."""
    handed, told = [], []
    for _ in range(3):
        loop.every(10_000_000, handed.append)
    loop.on_handed_over = lambda: told.append(len(handed))
    loop.advance(25)
    assert set(told) == {3, 6, 9}
