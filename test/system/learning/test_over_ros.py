# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim evaluate --over ros``: the same policy on an arm that it knows by topics alone."""

import json

import gymnasium
import pytest

from armsim_ros.cli.main import main
from armsim_ros.clients.task_over_ros import task_over_ros
from armsim_ros.errors import ConfigError, SimulationError
import armsim_ros.tasks  # noqa: F401 - registers the ids
from armsim_ros.testing.program import private_domain


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """Give each test a ROS domain of its own."""
    with private_domain() as number:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(number))
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        yield number


def evaluated(folder, *arguments):
    """Run the expert over ROS for two seeds and return the report."""
    report = folder / 'report.json'
    assert main(['evaluate', *arguments, '--policy', 'expert', '--episodes', '2', '--over', 'ros',
                 '--report', str(report)]) == 0
    return json.loads(report.read_text())


@pytest.mark.parametrize(('task', 'robot'), [
    ('Reach', 'sunday'), ('PickCube', 'sunday'), ('PushCube', 'panda')])
def test_in_lockstep_the_joints_are_where_the_local_run_has_them(tmp_path, task, robot):
    """At each step to a micrometre or microradian, and as often successful."""
    found = evaluated(tmp_path, f'armsim/{task}-v1', '--robot', robot, '--mode', 'lockstep')
    assert found['success_rate'] == found['local']['success_rate'] == 1.0
    assert found['deviation_max'] <= 1e-6


def test_in_real_time_the_gap_is_reported(tmp_path, capsys):
    """How far the joints are from the local run, how late commands are, and both rates."""
    found = evaluated(tmp_path, 'armsim/Reach-v1')
    assert found['success_rate'] == 1.0
    assert 0.0 < found['deviation_p95'] <= found['deviation_max']
    assert 0.0 < found['latency_p50'] <= found['latency_p95']
    lines = capsys.readouterr().out.splitlines()
    assert 'locally 2 of 2 episodes succeed' in lines[-3]
    assert 'joints from the local run: 95 % of the steps within' in lines[-2]
    middle, most = 1e3 * found['latency_p50'], 1e3 * found['latency_p95']
    assert (f'from observation to command: median {middle:.1f} ms, 95 % within {most:.1f} ms; '
            f'{found["late_steps"]} of ') in lines[-1]


def test_what_cannot_be_set_over_ros_is_refused():
    """An episode with other gains, and a task that observes pictures, with what is possible."""
    env = gymnasium.make('armsim/Reach-v1', randomize={'gains': (0.5, 0.6)})
    with task_over_ros(env, 'sunday', lockstep=True) as running, pytest.raises(
            ConfigError, match="'gains' cannot be set over ROS"):
        running.reset(seed=0)
    env = gymnasium.make('armsim/Reach-v1', obs_type='pixels')
    with pytest.raises(ConfigError, match='environment_state_agent_pos'), task_over_ros(
            env, 'sunday', lockstep=True):
        pass


def test_a_simulation_that_does_not_start_says_why():
    """Its own message is that of the command."""
    env = gymnasium.make('armsim/Reach-v1')
    with pytest.raises(SimulationError, match="robot 'sundya' is not found"), task_over_ros(
            env, 'sundya', lockstep=True):
        pass
