# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lockstep over ROS: a client in another process moves time, and runs end in the same digest."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
import json
from pathlib import Path

from mcap.reader import make_reader
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import (
    GetSimulationState,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
)
from std_srvs.srv import Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.move_group import MoveGroupClient
from armsim_ros.clients.trajectory import SUCCEEDED, TrajectoryClient
from armsim_ros.testing.program import private_domain, Program, start_program

GROUP = 'manipulator'
MILLISECOND_NS = 1_000_000


class Lockstep:
    """A client of a stack in lockstep."""

    def __init__(self, client: ClientNode, program: Program) -> None:
        self.client = client
        self.program = program
        self.move_group = MoveGroupClient(client)
        self.states = self.move_group.named_states()
        self.arm = TrajectoryClient(client, '/sunday/arm_joint_controller')
        self.joints = client.collect('/sunday/joint_states', JointState)

    def trigger(self, name):
        """Call one of the simulation's triggers; return its message."""
        answer = self.client.call(f'/simulation/{name}', Trigger, timeout=60.0)
        assert answer.success, answer.message
        return answer.message

    @property
    def time_ns(self):
        """Simulated time [ns]."""
        return int(self.trigger('sync'))

    def step(self, count):
        """Move time."""
        request = StepSimulation.Request(steps=count)
        answer = self.client.call('/step_simulation', StepSimulation, request, timeout=60.0)
        assert answer.result.result == Result.RESULT_OK, answer.result.error_message

    def reset(self, scope):
        """Begin anew."""
        request = ResetSimulation.Request(scope=scope)
        answer = self.client.call('/reset_simulation', ResetSimulation, request)
        assert answer.result.result == Result.RESULT_OK, answer.result.error_message

    def state(self, state):
        """Let time pass, or not."""
        request = SetSimulationState.Request(state=SimulationState(state=state))
        answer = self.client.call('/set_simulation_state', SetSimulationState, request)
        assert answer.result.result == Result.RESULT_OK, answer.result.error_message

    def positions(self):
        """Return the joint positions of now [rad]."""
        self.joints.clear()
        now_ns = self.time_ns
        message = self.joints.wait_for(lambda one: ns_of(one.header.stamp) == now_ns)
        return dict(zip(message.name, message.position, strict=True))

    def plan(self, state):
        """Return a trajectory to a named state, and its duration [s]."""
        answer = self.move_group.plan(GROUP, self.states[GROUP, state])
        assert answer.error_code.val == SUCCESS, answer.error_code.message
        trajectory = answer.planned_trajectory.joint_trajectory
        end = trajectory.points[-1].time_from_start
        return trajectory, end.sec + end.nanosec * 1e-9

    def move(self, state):
        """Plan to a named state, follow it, and stay a moment."""
        trajectory, duration = self.plan(state)
        goal = self.arm.send(trajectory)
        assert goal.accepted()
        self.step(round(duration * 1000) + 300)
        outcome = goal.result()
        assert outcome.status == SUCCEEDED, outcome.error_string


@contextmanager
def running(folder, *arguments):
    """Run a stack in lockstep whose recordings go to a folder."""
    overrides = json.dumps({'simulation.recorder.folder': str(folder)})
    with private_domain() as domain:
        program = start_program(
            'bringup', domain, 'mode:=lockstep', f'overrides:={overrides}', *arguments)
        try:
            program.wait_for_line('You can start planning now', 60.0)
            with ClientNode(domain, 'lockstep_user') as client:
                yield Lockstep(client, program)
        finally:
            program.stop()


@pytest.fixture(scope='module')
def stack(tmp_path_factory):
    """Run one stack for the module; its tests stand in the order of time."""
    with running(tmp_path_factory.mktemp('lockstep')) as stack:
        yield stack


def test_time_begins_at_zero_and_stands(stack):
    """Nothing moves time until a step is asked for, not even planning."""
    answer = stack.client.call('/get_simulation_state', GetSimulationState)
    assert answer.state.state == SimulationState.STATE_PAUSED
    assert stack.time_ns == 0
    stack.plan('scan_food')
    assert stack.time_ns == 0


def test_the_clock_tells_every_control_period(stack):
    """After five control periods /clock has had the time of each."""
    clock = stack.client.collect('/clock', Clock, 100)
    begin_ns = stack.time_ns
    clock.wait(1)
    stack.step(5)
    clock.wait_for(lambda message: ns(message) == begin_ns + 5 * MILLISECOND_NS)
    heard = {ns(message) for message in clock.messages}
    assert {begin_ns + k * MILLISECOND_NS for k in range(1, 6)} <= heard


def test_the_same_requests_end_in_the_same_digest(stack, tmp_path):
    """A second stack that is asked for the same does the same to the bit, planning included."""
    begin = stack.time_ns // MILLISECOND_NS
    with running(tmp_path) as other:
        other.plan('scan_food')
        other.step(begin)
        for one in (stack, other):
            one.move('scan_food')
            one.move('home')
        assert stack.trigger('digest') == other.trigger('digest')
        other.step(1)
        assert stack.trigger('digest') != other.trigger('digest')


def test_move_group_executes_while_a_client_steps(stack):
    """Plan and execute by the move action ends as in real time, though time leaps."""
    with ThreadPoolExecutor(1) as pool:
        moved = pool.submit(stack.move_group.move, GROUP, stack.states[GROUP, 'scan_food'])
        while not moved.done():
            stack.step(200)
    result = moved.result()
    assert result.error_code.val == SUCCESS, result.error_code.message


def test_half_a_minute_of_a_resting_arm(stack):
    """As many steps as one request may have, three times."""
    begin_ns = stack.time_ns
    for _ in range(3):
        stack.step(10_000)
    assert stack.time_ns == begin_ns + 30_000 * MILLISECOND_NS


def test_a_dump_has_the_last_seconds(stack):
    """The recording on request has joint states up to now, readable by the mcap library."""
    stack.step(10_000)
    path = Path(stack.trigger('dump'))
    with path.open('rb') as stream:
        times = [message.log_time for _, _, message in make_reader(stream).iter_messages(
            topics=['/sunday/joint_states'])]
    now_ns = stack.time_ns
    assert now_ns - times[-1] <= 20 * MILLISECOND_NS
    assert times[-1] - times[0] > 9_000 * MILLISECOND_NS


def test_after_a_reset_of_all_the_run_repeats_itself(stack):
    """Time is 0 again, and the same requests end in the same digest as before."""
    digests = []
    for _ in range(2):
        stack.reset(ResetSimulation.Request.SCOPE_ALL)
        assert stack.time_ns == 0
        digests.append([stack.trigger('digest')])
        stack.move('scan_food')
        digests[-1].append(stack.trigger('digest'))
    assert digests[0] == digests[1]


def test_stopped_is_at_time_zero(stack):
    """A stop resets all. simulation_interfaces SimulationState.msg, STATE_STOPPED."""
    stack.step(10)
    stack.state(SimulationState.STATE_STOPPED)
    assert stack.time_ns == 0


def test_a_reset_of_time_alone_ends_goals_and_moves_nothing(stack):
    """The arm stays where it is, its goal ends with the reason, and then it moves on."""
    stack.move('scan_food')
    trajectory, _ = stack.plan('home')
    goal = stack.arm.send(trajectory)
    assert goal.accepted()
    stack.step(200)
    before = stack.positions()
    stack.reset(ResetSimulation.Request.SCOPE_TIME)
    assert 'reset' in goal.result().error_string
    assert stack.time_ns == 0
    stack.step(300)
    after = stack.positions()
    assert max(abs(after[name] - before[name]) for name in before) < 0.1
    stack.move('home')


def test_playing_is_as_fast_as_it_goes(stack):
    """Played, ten simulated seconds pass at once; paused, time stands."""
    begin_ns = stack.time_ns
    stack.state(SimulationState.STATE_PLAYING)
    while stack.time_ns < begin_ns + 10_000 * MILLISECOND_NS:
        stack.client.settle()
    stack.state(SimulationState.STATE_PAUSED)
    assert stack.time_ns == stack.time_ns


def ns(message):
    """Return the time of a message of /clock [ns]."""
    return ns_of(message.clock)


def ns_of(time):
    """Return a time [ns]."""
    return time.sec * 1_000_000_000 + time.nanosec
