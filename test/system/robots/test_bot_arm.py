"""Bot: an arm of five joints; its launch file spawns a controller that no file describes."""

from faster import FASTER
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

JOINTS = [f'joint{number}' for number in range(1, 6)]


@pytest.fixture(scope='module')
def bot():
    """Run the stack."""
    with running_robot('robot:=bot', FASTER, namespace='/bot') as user:
        yield user


def test_the_controller_that_no_file_describes_is_told_once(bot):
    """One line, from one program, and the arm's controller runs."""
    bot.program.wait_for_line(r'bot_joint_controller \[active\]', 60.0)
    bot.program.wait_for_line('bot_gripper_controller', 60.0)
    lines = [line for line in bot.program.output if 'bot_gripper_controller' in line]
    assert len(lines) == 1
    assert "controller 'bot_gripper_controller' is to be spawned, but no file" in lines[0]


def test_a_trajectory_is_followed(bot):
    """A client of the controller's action moves the arm."""
    target = dict(zip(JOINTS, [0.2, -0.2, 0.4, 0.2, 0.1], strict=True))
    outcome = bot.send('bot_joint_controller', JOINTS, [(0.8, list(target.values()))])
    assert outcome.status == SUCCEEDED
    assert bot.distance(target) < 0.01


def test_a_motion_is_planned_and_executed(bot):
    """move_group moves five joints to a named state."""
    target = bot.move_group.named_states()['arm', 'ready']
    assert bot.move_group.move('arm', target).error_code.val == SUCCESS
    assert bot.distance(target) < 0.01
