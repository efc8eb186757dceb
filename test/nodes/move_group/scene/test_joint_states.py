# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How new the state of several robots is whose joints come in messages of their own."""

from types import SimpleNamespace

import pytest
from sensor_msgs.msg import JointState

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.move_group.scene.joint_states import StateMonitor
from armsim_ros.planning.scene.planning_scene import PlanningScene

START = 1_000_000_000


class Timer:
    """A timer that runs when a test says so, unless it is cancelled."""

    def __init__(self, callback):
        self.callback, self.cancelled = callback, False

    def cancel(self):
        self.cancelled = True

    def reset(self):
        self.cancelled = False

    def is_canceled(self):
        return self.cancelled

    def run(self):
        """Let the period pass."""
        if not self.cancelled:
            self.callback()


class Node:
    """What the monitor needs of a node and a steady clock, with invented time."""

    def __init__(self):
        self.time_ns = START
        self.steady_ns = 0
        self.warnings = []

    def poll(self, kind, topic, receive, profile):
        self.receive = receive

    def create_timer(self, period, callback, clock):
        timer = Timer(callback)
        self.sweep = timer.run
        return timer

    def get_clock(self):
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=self.time_ns))

    def now(self):
        return SimpleNamespace(nanoseconds=self.steady_ns)

    def get_logger(self):
        return SimpleNamespace(warning=self.warnings.append)

    def hear(self, side, time_ns, position=0.1):
        """Receive the joints of one arm."""
        self.time_ns = time_ns
        message = JointState(name=[f'{side}_joint{n}' for n in range(1, 6)],
                             position=[position] * 5, velocity=[0.0] * 5)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(time_ns, 1_000_000_000)
        self.receive(message)


@pytest.fixture(scope='module')
def robot():
    """Return the kinematics of two arms."""
    return KinematicModel(load_cell('two_bots').model)


@pytest.fixture
def node():
    """Return a node without ROS."""
    return Node()


@pytest.fixture
def monitor(node, robot):
    """Return a monitor of both arms."""
    topics = ('/left/joint_states', '/right/joint_states')
    return StateMonitor(node, PlanningScene(robot), topics, steady=node)


def test_the_state_is_as_new_as_the_last_message(monitor, node):
    """
    A message with a recent stamp makes the state recent, whatever joints it has.

    Upstream: current_state_monitor.cpp, waitForCurrentState and jointStateCallback.
    """
    waiting = monitor.newer_than(START + 20, 1.0)
    node.hear('left', START)
    assert not monitor.complete
    assert not waiting.done()
    node.hear('right', START + 30)
    assert waiting.result() is True
    assert monitor.stamp_ns == START + 30


def test_joints_that_are_never_published_are_not_waited_for(monitor, node):
    """
    Messages of one arm are enough where the other one has no publisher.

    Upstream: current_state_monitor.cpp, waitForCurrentState.
    """
    waiting = monitor.newer_than(START + 20, 1.0)
    node.hear('left', START + 30)
    assert waiting.result() is True


def test_states_that_have_stopped(monitor, node):
    """
    Where no message comes the wait ends without a recent state.

    Upstream: current_state_monitor.cpp, waitForCurrentState.
    """
    node.hear('left', START)
    node.hear('right', START)
    waiting = monitor.newer_than(START + 20, 1.0)
    for _ in range(120):
        node.steady_ns += 10_000_000
        node.sweep()
    assert waiting.result() is False


def test_steps_of_time_need_every_arm(monitor, node):
    """Where time moves in steps the state is that of the step once all arms have told it."""
    monitor.asks = lambda: None
    node.hear('left', START)
    node.hear('right', START)
    waiting = monitor.newer_than(START + 20, 1.0)
    node.hear('left', START + 20)
    assert not waiting.done()
    node.hear('right', START + 20)
    assert waiting.result() is True


def asking(monitor):
    """Return a coroutine that asks for the present state, and its result once it has one."""
    result = []

    async def ask():
        result.append(await monitor.current())

    coroutine = ask()
    coroutine.send(None)
    return coroutine, result


def test_the_start_of_simulated_time_is_no_time_that_passes(monitor, node):
    """The clock jumps from 0 to the present; who waits for the first state goes on waiting."""
    node.time_ns = 0
    coroutine, result = asking(monitor)
    node.time_ns = START
    node.steady_ns += 500_000_000
    node.sweep()
    node.hear('left', START)
    node.hear('right', START)
    with pytest.raises(StopIteration):
        coroutine.send(None)
    assert result == [True]


def test_the_first_state_is_waited_for_longer(monitor, node):
    """A simulation may just be starting: 5 s, then the answer is that there is none."""
    coroutine, result = asking(monitor)
    for _ in range(45):
        node.steady_ns += 100_000_000
        node.sweep()
        assert not monitor._waiting[0][2].done()
    node.steady_ns += 600_000_000
    node.sweep()
    with pytest.raises(StopIteration):
        coroutine.send(None)
    assert result == [False]


def test_no_state_is_waited_for_at_the_end(monitor, node):
    """Who waits for a state when the program ends, or asks later, learns that there is none."""
    waiting = monitor.newer_than(START, 5.0)
    monitor.patient = False
    node.sweep()
    assert waiting.result() is False
    waiting = monitor.newer_than(START, 5.0)
    node.sweep()
    assert waiting.result() is False


def test_arms_that_begin_one_after_the_other_give_no_warning(monitor, node):
    """One that stays away does, with its joints."""
    node.hear('left', START)
    node.hear('left', START + 200_000_000)
    assert node.warnings == []
    node.hear('left', START + 400_000_000)
    assert 'no position of right_joint1, right_joint2' in node.warnings[0]


def test_both_arms_reach_the_scene(monitor, node):
    """Messages of one arm leave the other where it is."""
    node.hear('left', START, 0.2)
    node.hear('right', START + 100_000_000, 0.3)
    monitor.update_scene()
    state = monitor._scene.snapshot()
    positions = state.kinematic_model.positions(state.q)
    assert (positions['left_joint2'], positions['right_joint2']) == (0.2, 0.3)
