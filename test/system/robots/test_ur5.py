"""UR5: the arm that a published launch file names."""

from faster import FASTER
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

JOINTS = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint',
          'wrist_1_joint', 'wrist_2_joint', 'wrist_3_joint']


@pytest.fixture(scope='module')
def ur5():
    """Run the stack."""
    with running_robot('robot:=ur5', FASTER) as user:
        yield user


def test_a_trajectory_is_followed(ur5):
    """A client of the controller's action moves the arm within the constraints of its file."""
    target = dict(zip(JOINTS, [0.3, -1.4, 0.4, -1.4, -0.3, 0.2], strict=True))
    outcome = ur5.send('arm_controller', JOINTS, [(1.0, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert ur5.distance(target) < 0.01


def test_a_motion_is_planned_and_executed(ur5):
    """move_group moves the arm to a named state."""
    target = ur5.move_group.named_states()['manipulator', 'ready']
    assert ur5.move_group.move('manipulator', target).error_code.val == SUCCESS
    assert ur5.distance(target) < 0.01
