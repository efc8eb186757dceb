"""Magician: a parallelogram whose joints follow others; spawned paused, with joints given."""

from faster import FASTER
import pytest
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import SetSimulationState

from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

JOINTS = ['magician_joint1', 'magician_joint2', 'magician_joint3']
FOLLOWERS = {'magician_fake_joint1': 'magician_joint2', 'magician_fake_joint2': 'magician_joint3',
             'magician_fake_joint3': 'magician_joint1'}


@pytest.fixture(scope='module')
def magician():
    """Start it as its launch file does: paused, with initial joint positions, then unpause."""
    with running_robot('robot:=magician', FASTER, 'paused:=true', 'gui:=false',
                       'initial_positions:=magician_joint2=0.785,magician_joint3=0.9') as user:
        request = SetSimulationState.Request(
            state=SimulationState(state=SimulationState.STATE_PLAYING))
        answer = user.client.call('/set_simulation_state', SetSimulationState, request)
        assert answer.result.result == Result.RESULT_OK
        yield user


def test_it_begins_where_the_command_line_says(magician):
    """Joints stay where they were put while paused, and after."""
    wanted = {'magician_joint1': 0.0, 'magician_joint2': 0.785, 'magician_joint3': 0.9}
    assert magician.distance(wanted) < 0.01


def test_a_trajectory_is_followed_and_the_others_follow(magician):
    """Three joints are commanded; the three of the parallelogram go with them."""
    target = dict(zip(JOINTS, [0.3, 0.9, 1.0], strict=True))
    outcome = magician.send('magician_arm_controller', JOINTS, [(1.0, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert magician.distance(target) < 0.01
    now = magician.positions()
    for follower, leader in FOLLOWERS.items():
        assert now[follower] == pytest.approx(-now[leader], abs=0.02)


def test_a_motion_is_planned_and_executed(magician):
    """A group over joints that follow others has three joints to plan for."""
    target = magician.move_group.named_states()['manipulator', 'left']
    result = magician.move_group.move('manipulator', target)
    assert result.error_code.val == SUCCESS
    assert set(result.planned_trajectory.joint_trajectory.joint_names) == set(JOINTS)
    assert magician.distance(target) < 0.01


def test_the_published_rate_of_the_control_loop_is_kept(magician):
    """generic_hw_control_loop: 300 Hz, as a whole number of physics steps."""
    assert ParameterClient(magician.client, '/controller_manager').get('update_rate') == 300
    assert 'cannot run at' not in magician.program.text


def test_its_values_of_trajectory_execution_are_in_force(magician):
    """trajectory_execution.launch.xml: scaling 2, margin 0.5, start tolerance 0.01."""
    parameters = ParameterClient(magician.client, '/move_group')
    prefix = 'trajectory_execution.'
    assert parameters.get(f'{prefix}allowed_execution_duration_scaling') == 2.0
    assert parameters.get(f'{prefix}allowed_goal_duration_margin') == 0.5
    assert parameters.get(f'{prefix}allowed_start_tolerance') == 0.01
