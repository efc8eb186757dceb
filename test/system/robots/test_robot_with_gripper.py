"""ROBOT: an arm and a gripper, each with a controller, planned apart and together."""

from faster import FASTER
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

FINGERS = ['finger_j1', 'finger_j2']


@pytest.fixture(scope='module')
def robot():
    """Run the stack."""
    with running_robot('robot:=ROBOT', FASTER, namespace='/ROBOT') as user:
        yield user


def test_each_controller_follows_a_trajectory(robot):
    """The fingers by their own action, then the arm by its."""
    assert robot.send('ROBOT_gripper_controller', FINGERS, [(0.5, [0.02, 0.02])]
                      ).status == SUCCEEDED
    joints = [f'j{number}' for number in range(1, 7)]
    target = [0.1, -0.2, 0.9, 0.1, 0.3, 0.1]
    assert robot.send('ROBOT_joint_controller', joints, [(0.8, target)]).status == SUCCEEDED
    wanted = dict(zip(joints, target, strict=True)) | dict.fromkeys(FINGERS, 0.02)
    assert robot.distance(wanted) < 0.005


def test_the_gripper_is_planned_and_executed_alone(robot):
    """Its group is moved to a named state."""
    target = robot.move_group.named_states()['gripper', 'closed']
    assert robot.move_group.move('gripper', target).error_code.val == SUCCESS
    assert robot.distance(target) < 0.002


def test_one_plan_is_split_over_both_controllers(robot):
    """A group of both is planned at once; each controller gets its joints."""
    states = robot.move_group.named_states()
    target = states['arm', 'ready'] | states['gripper', 'open']
    result = robot.move_group.move('arm_and_gripper', target)
    assert result.error_code.val == SUCCESS
    assert set(result.planned_trajectory.joint_trajectory.joint_names) == set(target)
    assert robot.distance(target) < 0.005
