"""Sunday: the default robot, started with the arguments of its published launch file."""

import pytest

from armsim_ros.testing.move_group_client import SUCCESS
from armsim_ros.testing.robot_user import running_robot
from armsim_ros.testing.trajectory_client import SUCCEEDED

JOINTS = [f'joint_{number}' for number in range(1, 7)]


@pytest.fixture(scope='module')
def sunday():
    """Run the stack."""
    with running_robot('robot:=sunday', 'paused:=false', 'use_sim_time:=true', 'gui:=false',
                       'headless:=true', 'debug:=false', namespace='/sunday') as user:
        yield user


def test_a_trajectory_is_followed(sunday):
    """A client of the controller's action moves the arm."""
    target = dict(zip(JOINTS, [0.1, 0.2, 0.3, -0.2, 0.4, 0.1], strict=True))
    outcome = sunday.send('arm_joint_controller', JOINTS, [(0.8, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert sunday.distance(target) < 0.01


def test_a_plan_is_executed_by_itself_later(sunday):
    """A plan of move_action, given to execute_trajectory."""
    target = sunday.move_group.named_states()['manipulator', 'scan_food']
    planned = sunday.move_group.plan('manipulator', target)
    assert planned.error_code.val == SUCCESS
    executed = sunday.move_group.execute(planned.planned_trajectory)
    assert executed.error_code.val == SUCCESS
    assert sunday.distance(target) < 0.01
