# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Cycles of the streaming thread, one by one, with invented time and nobody else there."""

from types import SimpleNamespace

import numpy as np
import pytest
from servo_streams import ELBOW_UP, jog, Streamer, twist

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.servo.streaming import Streaming
from armsim_ros.servo.commands import CommandInbox, CommandType, PoseTarget
from armsim_ros.servo.trajectory_window import TrajectoryWindow

PERIOD_NS = 10_000_000


@pytest.fixture(scope='module')
def kinematics():
    """Return the robot's kinematics."""
    settings = load_robot_settings('sunday')
    return KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))


class Cycles:
    """The streaming thread's work, done when a test says so."""

    def __init__(self, kinematics):
        self.now = 1_000_000_000
        self.sent, self.stamps, self.said, self.replanned = [], [], [], []
        self.trajectories = []
        self.window = TrajectoryWindow(tuple('abcdef'), 100_000_000)
        self.inbox = CommandInbox(100_000_000)
        self.controller = SimpleNamespace(
            own=None, subscriptions=(), goal_runs=False, plan_runs=False, inactive='',
            reference=lambda now: self.reference, awaited=False,
        )
        self.reference = np.array(ELBOW_UP)
        self.output = SimpleNamespace(
            heard=True, topic='/arm/joint_trajectory',
            start=lambda now, stream: self.window.start(now, stream.state),
            go_back=lambda now, stream: self.window.go_back(now, PERIOD_NS, stream),
            publish=self._send, replan=lambda *arguments: self.replanned.append(self.now),
        )
        made = Streamer(kinematics)
        self.streaming = Streaming(
            node=SimpleNamespace(catch_up=lambda *subscriptions: None),
            clock=SimpleNamespace(now_ns=lambda: self.now, parted=False),
            inbox=self.inbox,
            commands=SimpleNamespace(subscriptions={}),
            states=SimpleNamespace(
                q=made.q, missing=(), subscriptions=(), read=lambda: None),
            controller=self.controller,
            stream=made.stream,
            output=self.output,
            status=SimpleNamespace(publish=self.said.append, heard=True),
            parameters=made.parameters,
            ready=lambda: None,
        )
        made.stream.stop()
        self.kinematics = kinematics

    def _send(self, cycle_ns, cycle, stream, parameters):
        self.sent.append(cycle.positions)
        self.stamps.append(cycle_ns)
        self.window.add(cycle_ns, stream.state)
        self.trajectories.append(self.window.trajectory())

    def run(self, command=None, count=30, steps=(PERIOD_NS,)):
        """Do cycles, a command before each, with those steps of time again and again."""
        for record in (self.said, self.sent, self.stamps, self.trajectories):
            record.clear()
        for k in range(count):
            if command is not None:
                self.inbox.receive(command.type, lambda: command, self.now, self.now)
            self.streaming._cycle()
            self.now += steps[k % len(steps)]

    @property
    def messages(self):
        """What was said."""
        return {finding.message for finding in self.said}


def largest_speed(trajectories):
    """Return how far joints go from one point to the next in that time at most [rad/s]."""
    return max(
        (np.abs(np.diff(each.positions, axis=0)) / np.diff(each.times)[:, None]).max()
        for each in trajectories)


@pytest.fixture
def cycles(kinematics):
    """Return cycles that follow twists."""
    made = Cycles(kinematics)
    made.inbox.choose(CommandType.TWIST)
    return made


def test_motion_and_silence(cycles):
    """Commands are followed; after them the arm brakes and says why, then nothing is sent."""
    cycles.run(twist((0, 0, -0.3)), 60)
    assert len(cycles.sent) == 60
    cycles.run(None, 100)
    assert 5 < len(cycles.sent) < 60
    assert cycles.messages == {
        'No warnings', 'No warnings: no command has come for 0.1 s; the arm comes to rest'}
    cycles.run(None, 20)
    assert not cycles.sent


def test_what_lies_ahead_is_replaced(cycles):
    """Once where silence is noticed, and once where a command resumes the motion."""
    cycles.run(twist((0, 0, -0.3)), 40)
    assert not cycles.replanned
    silent = cycles.now - PERIOD_NS + cycles.inbox.timeout_ns
    cycles.run(None, 12)
    assert cycles.replanned == [silent]
    cycles.run(twist((0, 0, -0.3)), 20)
    assert cycles.replanned == [silent, silent + 3 * PERIOD_NS]


def test_the_stream_lasts_until_the_arm_rests(cycles):
    """A command that comes before what was sent has been followed goes on from there."""
    cycles.run(twist((0, 0, -0.3)), 40)
    cycles.run(None, 10)
    while cycles.sent:
        assert cycles.streaming.stream.streaming
        cycles.run(None, 1)
    assert cycles.streaming.stream.streaming
    cycles.run(None, 10)
    assert not cycles.streaming.stream.streaming


def test_late_cycles_move_no_faster(cycles):
    """Points of cycles that come late, or follow quickly upon a late one, keep their distance."""
    cycles.run(twist((0, 0, -0.3)), 60, steps=(10_000_000, 27_000_000, 1_000_000, 2_000_000))
    speeds = np.diff(cycles.sent, axis=0) / np.diff(cycles.stamps)[:, None] * 1e9
    even = np.diff(cycles.sent, axis=0) / 0.01
    assert np.abs(speeds).max() <= np.abs(even).max() + 1e-9
    behind = cycles.now - 2_000_000 - np.array(cycles.stamps[-1])
    assert abs(behind) < 3 * PERIOD_NS
    cycles.run(twist((0, 0, -0.3)), 3, steps=(400_000_000,))
    assert np.diff(cycles.stamps).min() > 300_000_000


def test_simulated_time_that_is_slower(cycles):
    """Where simulated time goes at a third of our own pace, so does the stream."""
    cycles.streaming.clock.parted = True
    cycles.run(twist((0, 0, -0.3)), 60, steps=(PERIOD_NS // 3,))
    assert 18 <= len(cycles.sent) <= 22
    cycles.run(twist((0, 0, -0.3)), 10, steps=(0,))
    assert len(cycles.sent) <= 1


@pytest.mark.parametrize('back', [25, 60, 90, 96, 150])
def test_time_that_is_set_back(cycles, back):
    """The stream goes back to what was sent for that time: no point leads on with a step."""
    down = twist((0, 0, -0.3))
    cycles.run(down, 60)
    usual = largest_speed(cycles.trajectories)
    cycles.now -= back * 1_000_000
    cycles.reference = np.array(cycles.sent[-1 - (100 + back) // 10])
    cycles.run(down, 20)
    assert len(cycles.sent) >= 19
    assert usual / 2 < largest_speed(cycles.trajectories[1:]) < 1.2 * usual


def test_rest(cycles):
    """It rests where there is no command, nothing moves, and nobody listens to the status."""
    cycles.run(None, 2)
    assert not cycles.streaming._rests()
    cycles.streaming.status.heard = False
    assert cycles.streaming._rests()
    cycles.run(twist((0, 0, -0.3)), 10)
    assert not cycles.streaming._rests()
    cycles.run(None, 100)
    assert cycles.streaming._rests()
    cycles.inbox.complain('what is wrong', cycles.now)
    assert not cycles.streaming._rests()


@pytest.mark.parametrize('command', [twist(), jog(), jog(joint_1=0.0)], ids=['twist', 'no', 'jog'])
def test_commands_of_zero(cycles, command):
    """
    While a command is fresh, a message goes out each period, though nothing moves.

    Upstream: servo_node.cpp, servoLoop; test_integration.cpp.
    """
    cycles.inbox.choose(command.type)
    cycles.run(command, 80)
    assert len(cycles.sent) == 80
    assert np.ptp(cycles.sent, axis=0).max() == 0.0
    cycles.run(None, 40)
    assert len(cycles.sent) < 15
    assert not cycles.streaming.stream.streaming


def test_pose_that_is_reached_already(cycles):
    """
    It is reported and held, with a message each period.

    Upstream: servo_node.cpp, processPoseCommand.
    """
    cycles.inbox.choose(CommandType.POSE)
    cycles.run(PoseTarget('link_6', np.eye(4)), 60)
    assert 'No warnings: pose reached' in cycles.messages
    assert len(cycles.sent) == 60


def test_parameters_hold_from_the_next_cycle_on(cycles):
    """
    A change while commands stream takes effect at once, without a step.

    Upstream: servo.cpp, updateParams.
    """
    down = twist((0, 0, -0.3))
    cycles.run(down, 40)
    before = cycles.sent[-1]
    faster = Streamer(cycles.kinematics, scale={'linear': 0.8})
    cycles.streaming.change(faster.parameters, faster.stream)
    slow = np.abs(np.diff(cycles.sent, axis=0)[-1]).max()
    cycles.run(down, 30)
    steps = np.abs(np.diff([before, *cycles.sent], axis=0)).max(axis=1)
    assert steps[0] == pytest.approx(slow, rel=0.2)
    assert steps[-1] > 1.5 * slow


def test_the_controller_is_asked_first(cycles):
    """A command waits for the controller's first state, so as to begin at its reference."""
    reference, cycles.reference, cycles.controller.awaited = cycles.reference, None, True
    cycles.run(twist((0, 0, -0.3)), 5)
    assert not cycles.sent
    cycles.reference, cycles.controller.awaited = reference + 0.1, False
    cycles.run(twist((0, 0, -0.3)), 1)
    assert np.abs(cycles.sent[0] - cycles.reference).max() < 1e-3


def test_pause(cycles):
    """The arm brakes, commands are forgotten, the status goes on."""
    cycles.run(twist((0, 0, -0.3)), 40)
    cycles.streaming.pause(True)
    cycles.run(twist((0, 0, -0.3)), 100)
    assert cycles.messages == {'No warnings: paused'}
    cycles.run(twist((0, 0, -0.3)), 10)
    assert not cycles.sent
    cycles.streaming.pause(False)
    cycles.run(twist((0, 0, -0.3)), 10)
    assert cycles.sent


def test_a_goal_has_the_arm(cycles):
    """While a goal runs nothing is sent; afterwards the stream begins anew."""
    cycles.run(twist((0, 0, -0.3)), 40)
    cycles.controller.goal_runs = True
    cycles.run(twist((0, 0, -0.3)), 10)
    assert not cycles.sent
    cycles.controller.goal_runs = False
    cycles.reference = np.array(ELBOW_UP) + 0.2
    cycles.run(None, 5)
    assert not cycles.sent
    cycles.run(twist((0, 0, -0.3)), 10)
    assert np.abs(cycles.sent[0] - cycles.reference).max() < 1e-3


@pytest.mark.parametrize('obstacle', ['nobody', 'inactive'])
def test_nobody_to_move(cycles, obstacle):
    """Where nobody listens, or the controller is inactive, the status says so."""
    cycles.output.heard = obstacle != 'nobody'
    if obstacle == 'inactive':
        cycles.controller.inactive = "controller '/arm' is inactive"
    cycles.run(twist((0, 0, -0.3)), 10)
    assert not cycles.sent
    word = 'has no subscriber' if obstacle == 'nobody' else 'is inactive'
    assert any(word in message and message.startswith('Invalid') for message in cycles.messages)
