"""Elfin: an arm with a spherical wrist; one of the published spawners bears its name."""

from faster import FASTER
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

JOINTS = [f'elfin_joint{number}' for number in range(1, 7)]


@pytest.fixture(scope='module')
def elfin():
    """Run the stack."""
    with running_robot('robot:=elfin', FASTER) as user:
        yield user


def test_a_trajectory_is_followed(elfin):
    """A client of the controller's action moves the arm."""
    target = dict(zip(JOINTS, [0.2, 0.3, -0.4, 0.1, -0.3, 0.2], strict=True))
    outcome = elfin.send('elfin_arm_controller', JOINTS, [(1.0, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert elfin.distance(target) < 0.01


def test_a_motion_is_planned_and_executed(elfin):
    """move_group moves the arm to a named state."""
    target = elfin.move_group.named_states()['elfin_arm', 'ready']
    assert elfin.move_group.move('elfin_arm', target).error_code.val == SUCCESS
    assert elfin.distance(target) < 0.01
