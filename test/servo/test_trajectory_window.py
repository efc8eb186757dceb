# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The points that a stream sends to a trajectory controller."""

import numpy as np
import pytest
from servo_streams import ELBOW_UP, jog, Streamer

from armsim_ros.servo.stream import StreamState
from armsim_ros.servo.trajectory_window import TrajectoryWindow

PERIOD, LATENCY, START = 10_000_000, 100_000_000, 1_000_000_000


def filled(*positions):
    """Return a window that began at 0 and got positions, one a period."""
    window = TrajectoryWindow(('a',), LATENCY)
    window.start(START, at(0.0))
    for k, position in enumerate(positions):
        window.add(START + k * PERIOD, at(position))
    return window


def at(position):
    """Return a stream's state at a position."""
    values = np.array([position])
    return StreamState(values, values, values, None)


def test_the_first_command_goes_out_at_once():
    """The first message leads from rest to the first command; before it there is none."""
    assert filled().trajectory() is None
    points = filled(0.1).trajectory()
    np.testing.assert_allclose(points.times, [0.0, 0.1])
    np.testing.assert_allclose(points.positions[:, 0], [0.0, 0.1])
    assert not points.velocities.any()
    np.testing.assert_allclose(filled(0.1, 0.2).trajectory().times, [0.0, 0.1])


def test_all_but_the_newest_from_the_first_stamp():
    """The stamp is that of the first point, the newest point is kept back."""
    points = filled(0.1, 0.2, 0.3).trajectory()
    assert points.stamp_ns == START
    np.testing.assert_allclose(points.times, [0.0, 0.1, 0.11])
    np.testing.assert_allclose(points.positions[:, 0], [0.0, 0.1, 0.2])


def test_velocities():
    """A velocity is the smaller difference, 0 where the motion turns and at the end."""
    points = filled(0.1, 0.11, 0.13, 0.12, 0.11, 0.10).trajectory()
    np.testing.assert_allclose(points.velocities[:, 0], [0.0, 1.0, 1.0, 0.0, -1.0, 0.0])


def test_the_past_is_forgotten():
    """Of what lies behind only the last point stays, besides what may still be on its way."""
    window = filled(*np.linspace(0.0, 1.0, 100))
    points = window.trajectory()
    now = START + 99 * PERIOD
    assert now - 4 * PERIOD <= points.stamp_ns <= now
    assert points.stamp_ns + round(points.times[-1] * 1e9) == now + LATENCY - PERIOD


class Sent:
    """A stream and the window of what it sends, cycle by cycle."""

    def __init__(self, kinematics, **parameters):
        self.made = Streamer(kinematics, **parameters)
        self.stream, self.now = self.made.stream, START
        self.window = TrajectoryWindow(self.stream.target.names, LATENCY)
        self.window.start(START, self.stream.state)

    def cycle(self, command):
        """Do one cycle and return what is sent."""
        def step():
            return self.stream.step(command, self.made.q, self.made.parameters)

        if self.stream.turns(command):
            self.window.replan(self.now, self.now, PERIOD, self.stream, step)
        step()
        self.window.add(self.now, self.stream.state)
        points = self.window.trajectory()
        self.now += PERIOD
        return points

    def run(self, command, count):
        """Do cycles and return what the last one sent."""
        for _ in range(count - 1):
            self.cycle(command)
        return self.cycle(command)


FILTERS = (
    'online_signal_smoothing::ButterworthFilterPlugin',
    'online_signal_smoothing::AccelerationLimitedPlugin',
    'online_signal_smoothing::RuckigFilterPlugin',
)


@pytest.mark.parametrize('plugin', FILTERS)
def test_silence_replaces_what_lies_ahead(kinematics, plugin):
    """The arm brakes from the next point on, as softly as ever, and not after the latency."""
    sent = Sent(kinematics, smoothing_filter_plugin_name=plugin)
    before = sent.run(jog(joint_1=0.4), 60)
    points = sent.cycle(None)
    now = sent.now - PERIOD
    due = points.stamp_ns + np.round(points.times * 1e9).astype(np.int64)
    speeds = np.diff(points.positions[:, 0]) / np.diff(points.times)
    assert speeds[due[1:] <= now + PERIOD] == pytest.approx(0.2, abs=1e-3)
    old = dict(zip((before.stamp_ns + np.round(before.times * 1e9)).tolist(),
                   before.positions[:, 0], strict=True))
    kept = [k for k, when in enumerate(due.tolist()) if when <= now + PERIOD and when in old]
    assert kept
    assert all(points.positions[k, 0] == old[due[k]] for k in kept)
    assert np.abs(np.diff(speeds)).max() <= 5.0 * 0.01 + 1e-6 or plugin == FILTERS[0]
    if plugin != FILTERS[2]:
        assert np.abs(speeds[due[1:] > now + 8 * PERIOD]).max() < 1e-3


def test_a_command_while_it_brakes(kinematics):
    """The motion goes on from where it is, forwards and without a step."""
    sent = Sent(kinematics)
    sent.run(jog(joint_1=0.4), 60)
    sent.run(None, 3)
    points = sent.cycle(jog(joint_1=0.4))
    speeds = np.diff(points.positions[:, 0]) / np.diff(points.times)
    assert speeds.min() > 0.0
    assert speeds[-1] == pytest.approx(0.2, abs=0.01)
    assert np.abs(np.diff(speeds)).max() < 0.1


def test_a_command_of_zero_is_silence(kinematics):
    """Who releases the stick is heard at once, too."""
    sent = Sent(kinematics)
    sent.run(jog(joint_1=0.4), 60)
    points = sent.cycle(jog(joint_1=0.0))
    assert points.positions[-1, 0] - points.positions[-2, 0] < 1e-4
    assert points.positions[-1, 0] > ELBOW_UP[0]
