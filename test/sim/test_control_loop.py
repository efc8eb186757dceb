# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loop that moves time."""

import threading

import numpy as np
import pytest

from armsim_ros.errors import ControllerError, SimulationError
from armsim_ros.sim.control_loop import ControlLoop, steps_per_update
from armsim_ros.sim.pacer import Pacer


class Recorder:
    """Controllers that write down when they were asked."""

    def __init__(self):
        self.updates = []
        self.requests = []

    def update(self, time_ns, period):
        self.updates.append((time_ns, period))

    def process_requests(self, time_ns):
        self.requests.append(time_ns)


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
