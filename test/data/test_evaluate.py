# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Outcomes of policies, their interval, and what is refused."""

import json
import sys

import numpy as np
import pytest

from armsim_ros.cli.main import main
from armsim_ros.data.evaluate import Outcome, success_interval


def still(observation):
    """Return an action that moves nothing far."""
    return np.zeros(7)


def test_outcomes_are_printed_and_reported(tmp_path, capsys):
    """Each seed, the rate with its interval, and all of it as JSON."""
    report = tmp_path / 'report.json'
    status = main(['evaluate', 'armsim/Reach-v1', '--policy', 'expert', '--episodes', '2',
                   '--seed', '5', '--report', str(report)])
    lines = capsys.readouterr().out.splitlines()
    assert status == 0
    assert lines[0].startswith('seed 5: success after ')
    assert lines[2].startswith('2 of 2 episodes succeed: 100.0 % (95 %: 34.2 to 100.0 %), ')
    found = json.loads(report.read_text())
    assert [episode['seed'] for episode in found['episodes']] == [5, 6]


def test_a_policy_of_the_user_can_fail_the_task(monkeypatch, capsys):
    """A function of a module is called; its episodes end without success."""
    assert main(['evaluate', 'armsim/Reach-v1', '--policy', f'{__name__}:still',
                 '--episodes', '1']) == 0
    assert '0 of 1 episodes succeed' in capsys.readouterr().out


class Counting:
    """A policy that remembers how often an episode began."""

    begun = 0

    def reset(self):
        """Count."""
        Counting.begun += 1

    def __call__(self, observation):
        """Return an action that moves nothing far."""
        return np.zeros(7)


counting = Counting()


def test_a_policy_with_a_memory_is_reset_for_each_episode(capsys):
    """What has ``reset`` hears of each beginning."""
    assert main(['evaluate', 'armsim/Reach-v1', '--policy', f'{__name__}:counting',
                 '--episodes', '2']) == 0
    assert Counting.begun == 2


class Instructed:
    """A policy that follows an instruction, which it gets before its ``reset``."""

    task_description = ''

    def __init__(self):
        self.instructions = []

    def reset(self):
        """Begin an episode."""
        self.instructions.append(self.task_description)

    def __call__(self, observation):
        """Return an action that moves nothing far."""
        return np.zeros(7)


instructed = Instructed()


def test_a_policy_with_an_instruction_gets_that_of_the_task(capsys):
    """As in LeRobot (lerobot_eval.py, rollout): the task's description, in each episode."""
    assert main(['evaluate', 'armsim/Reach-v1', '--policy', f'{__name__}:instructed',
                 '--episodes', '2']) == 0
    assert instructed.instructions == ['Move the hand to the green ball.'] * 2


def test_a_policy_of_lerobot_needs_the_plug_in(tmp_path, monkeypatch, capsys):
    """Without it, its folder is one message with what to install."""
    monkeypatch.setitem(sys.modules, 'lerobot_robot_armsim.checkpoint', None)
    (tmp_path / 'config.json').write_text('{}')
    assert main(['evaluate', 'armsim/Reach-v1', '--policy', str(tmp_path)]) == 2
    assert 'pip install lerobot_robot_armsim' in capsys.readouterr().err


@pytest.mark.parametrize(('successes', 'count', 'expected'), [
    (95, 100, (0.888, 0.978)), (0, 10, (0.0, 0.278)), (10, 10, (0.722, 1.0))])
def test_the_interval_is_wilsons(successes, count, expected):
    """Values of the literature."""
    outcomes = [Outcome(k, k < successes, 10, 0.0) for k in range(count)]
    assert success_interval(outcomes) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize('arguments', [
    ['armsim/Reach-v1', '--policy', 'expert', '--episodes', '0'],
    ['armsim/PickCub-v1', '--policy', 'expert'],
    ['armsim/Reach-v1', '--policy', 'nobody:here'],
])
def test_wrong_arguments_are_one_message(arguments, capsys):
    """Status 2, and what is allowed."""
    assert main(['evaluate', *arguments]) == 2
    assert 'allowed' in capsys.readouterr().err
