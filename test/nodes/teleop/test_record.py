# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Episodes of a person: where they start and end, and what they have."""

import sys

import numpy as np
import pytest

from armsim_ros.data.episodes import EpisodeRunner, Source
from armsim_ros.data.features import ACTION, DONE, STATE
from armsim_ros.errors import ResourceError
from armsim_ros.nodes.teleop.commands import Command, DROP, HAND, Keys, MARK
from armsim_ros.nodes.teleop.devices import Ending
from armsim_ros.nodes.teleop.main import main
from armsim_ros.nodes.teleop.record import DroppedError, Operator
from armsim_ros.nodes.teleop.servo_link import JOINT, LINEAR


class Screen:
    """Keys of each read in turn, then none."""

    def __init__(self, *keys):
        self.keys, self.shown = list(keys), []

    def read(self, seconds):
        """Return the next keys."""
        return self.keys.pop(0)

    def show(self, text):
        """Keep what is printed."""
        self.shown.append(text)


@pytest.fixture(scope='module')
def runner():
    """Give a runner of a task that is local, without a policy yet."""
    made = EpisodeRunner(Source('armsim/Reach-v1', {
        'obs_type': 'environment_state_agent_pos', 'randomize': 'none'}), lambda _: None)
    yield made
    made.close()


def episode(runner, device, *keys, ending=None):
    """Return the episode of keys, one read per step, and the operator."""
    operator = Operator(Screen(*keys), ending or Ending(), Keys(), 0.5)
    operator.task, operator.device = runner.task, device
    runner._policy = operator
    return runner.run(0), operator


def test_a_package_that_recording_lacks_is_named(monkeypatch):
    """With the command that installs it."""
    monkeypatch.delitem(sys.modules, 'armsim_ros.nodes.teleop.record')
    monkeypatch.setitem(sys.modules, 'armsim_ros.data.episodes', None)
    with pytest.raises(ResourceError, match=r'is not installed: .*\[gym,data\]'):
        main(['--with', 'keyboard', '--record', 'armsim/Reach-v1', 'set'])


def test_an_episode_is_between_two_spaces(runner):
    """What is pressed before counts for nothing; its last frame is its end."""
    found, operator = episode(runner, lambda: None, 'w', '', MARK, '', '', '', MARK)
    assert found.length == 3
    assert found.columns[DONE].ravel().tolist() == [False, False, True]
    assert not found.facts['success']
    assert operator._screen.shown[0] == 'space starts the episode'


def test_a_space_at_once_does_not_end_it_without_a_frame(runner):
    """A set has no episodes without frames."""
    found, _ = episode(runner, lambda: None, MARK, MARK, MARK)
    assert found.length == 1


def test_backspace_and_the_end_drop_it(runner):
    """Nothing is returned."""
    with pytest.raises(DroppedError):
        episode(runner, lambda: None, MARK, '', DROP)
    ending = Ending()
    ending.signal = 2
    with pytest.raises(DroppedError):
        episode(runner, lambda: None, '', ending=ending)


def test_twists_move_the_tip_in_world_axes(runner):
    """At a share of the largest speed."""
    tips = []

    def up():
        tips.append(runner.task.hand.point.copy())
        return Command((0.0, 0.0, -1.0, 0.0, 0.0, 0.0))

    episode(runner, up, MARK, *[''] * 20, MARK)
    way = tips[-1] - tips[0]
    assert way[2] == pytest.approx(-0.5 * LINEAR * 19 * runner.task.period, rel=0.2)
    assert np.abs(way[:2]).max() < 0.01


def test_joints_and_positions_are_commanded_as_requested(runner):
    """A digit turns its joint, a leader's positions are the action's; g switches the hand."""
    task = runner.task
    found, _ = episode(runner, lambda: Command(joints={1: 1.0}), MARK, *[''] * 10, MARK)
    units = [task.to_units(action) for action in found.columns[ACTION]]
    assert np.diff([each[1] for each in units]) == pytest.approx(
        0.5 * JOINT * task.period, abs=1e-5)
    start = dict(zip(task.joints, found.columns[STATE][0], strict=False))
    goal = start['joint_3'] + 0.01
    found, _ = episode(
        runner, lambda: {'joint_3': goal}, MARK, '', HAND, '', MARK)
    units = [task.to_units(action) for action in found.columns[ACTION]]
    assert [each[2] for each in units] == pytest.approx([goal] * 3, abs=1e-5)
    assert [each[-1] > 0.5 for each in units] == [False, True, True]
