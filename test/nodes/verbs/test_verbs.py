# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The small commands, beside a stack that is not ours."""

from concurrent.futures import Future
import json
import subprocess
import sys

from moveit_msgs.action import MoveGroup
import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.verbs import go, plot, state, stop
from armsim_ros.nodes.verbs.terminal import wait

pytestmark = pytest.mark.usefixtures('fake_stack')
JSON = ['--json', '--timeout', '20']


def output_of(program, capsys, *words):
    """Return the exit status and what was printed as JSON."""
    status = program.main([*words, *JSON])
    return status, json.loads(capsys.readouterr().out)


def test_go_moves_to_a_named_state(fake_stack, capsys):
    """Planned and executed by move_action; the error is that of the joint states."""
    status, told = output_of(go, capsys, 'up', '--speed', '0.5')
    assert (status, told['success'], told['group']) == (0, True, 'arm')
    assert fake_stack.positions == {'turn': 1.0, 'bend': 0.5}
    assert told['largest_error'] < 1e-9


def test_go_takes_joint_positions_and_can_leave_it_at_the_plan(fake_stack, capsys):
    """In degrees where they say so."""
    before = dict(fake_stack.positions)
    status, told = output_of(go, capsys, 'turn=-30deg', 'bend=0.25', '--plan-only')
    assert (status, told['duration']) == (0, 2.0)
    assert fake_stack.positions == before


@pytest.mark.parametrize(('words', 'text'), [
    (['upp'], "did you mean 'up'?"),
    (['trun=1'], "did you mean 'turn'?"),
    (['turn=9'], 'allowed: -2 to 2 rad, -114.6deg to 114.6deg'),
    ([], 'known states: up'),
    (['away'], "there is no state 'away'; known: up"),
    (['turn=fast'], 'or of degrees: 30deg'),
    (['up', '--group', 'leg'], 'allowed: arm'),
    (['up', '--speed', '2'], "--speed: '2' is not a share; allowed: above 0, up to 1"),
])
def test_go_answers_a_wrong_word_with_the_right_one(words, text):
    """Nothing moves."""
    with pytest.raises(UsageError) as error:
        go.main([*words, '--timeout', '20'])
    assert text in str(error.value)


def test_go_lists_the_named_states(fake_stack, capsys):
    """With their groups and joints; nothing moves."""
    before = dict(fake_stack.positions)
    status, listed = output_of(go, capsys, '--list')
    assert (status, listed) == (0, {'arm': {'up': {'turn': 1.0, 'bend': 0.5}}})
    assert go.main(['--list', '--timeout', '20']) == 0
    assert capsys.readouterr().out.split() == [
        'group', 'state', 'joints', 'arm', 'up', 'turn=1', 'bend=0.5']
    assert fake_stack.positions == before


def test_time_that_does_not_pass_is_reported(fake_stack, capsys):
    """State and go print why nothing happens; joint states are fetched from the simulation."""
    fake_stack.pause()
    status, value = output_of(state, capsys)
    assert (status, value['paused']) == (0, True)
    assert {each['name'] for each in value['joints']} == {'turn', 'bend'}
    assert go.main(['turn=0.5', '--plan-only', '--timeout', '20']) == 0
    assert 'simulated time does not pass' in capsys.readouterr().err


def test_state_prints_joints_controllers_and_named_states(capsys):
    """As a table for people, as JSON for scripts."""
    status, told = output_of(state, capsys)
    assert status == 0
    assert {each['name'] for each in told['joints']} == {'turn', 'bend'}
    assert told['controllers'][0] == {
        'name': '/arm/arm', 'state': 'active',
        'type': 'joint_trajectory_controller/JointTrajectoryController'}
    assert told['states'] == {'arm': ['up']}
    assert state.main(['--timeout', '20']) == 0
    printed = capsys.readouterr().out
    assert 'turn' in printed
    assert "named states of 'arm': up" in printed


@pytest.mark.parametrize('words', [['armsim_ros', 'state'], ['armsim_ros2', 'topic', 'list']])
def test_a_command_loads_no_generator_of_messages(words):
    """Nor the parser that it needs, which would be an eighth of the command's time."""
    done = subprocess.run([sys.executable, '-X', 'importtime', '-m', *words], capture_output=True,
                          text=True, timeout=60, check=True)
    assert 'rosidl_generator_py.import_type_support_impl' in done.stderr  # or it would be in vain
    assert 'lark' not in done.stderr


def test_stop_asks_every_action(capsys):
    """There is nothing to stop, and that is said."""
    status, told = output_of(stop, capsys)
    assert (status, told) == (0, {'stopped': 0, 'silent': []})


def test_stop_waits_for_no_action_without_a_server(capsys):
    """A client of an action that nothing serves delays and fails nothing."""
    with RosClient('test_stop') as client:
        client.prepare(MoveGroup, '/unserved/move_action', action=True)
        assert output_of(stop, capsys) == (0, {'stopped': 0, 'silent': []})


def test_an_answer_that_does_not_come_is_said_in_a_sentence():
    """What did not answer, and how long the command waited for it."""
    with pytest.raises(ArmsimError, match=r'/compute_ik did not answer within 0\.01 s'):
        wait(Future(), 0.01, '/compute_ik')


def test_a_robot_that_is_not_there_is_said_in_a_sentence():
    """With what to look at."""
    with pytest.raises(ArmsimError, match='armsim bringup'):
        plot.main(['/nowhere', '--timeout', '0.5'])
