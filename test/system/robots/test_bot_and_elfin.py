"""Two different arms in one world, neither with a prefix, one of them in the root namespace."""

from faster import FASTER
import pytest

from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot


@pytest.fixture(scope='module')
def bot():
    """Run the stack, seen by a user of bot."""
    with running_robot('robot:=bot_and_elfin', FASTER, namespace='/bot') as user:
        yield user


@pytest.fixture(scope='module')
def elfin(bot):
    """Return the same stack, seen by a user of elfin."""
    return type(bot)(bot.client, bot.program, '')


def test_each_is_where_its_own_programs_look_for_it(bot, elfin):
    """Actions and joint states have the names that they have without the other arm."""
    target = {f'joint{number}': 0.2 for number in range(1, 6)}
    assert bot.send('bot_joint_controller', list(target), [(0.8, list(target.values()))]
                    ).status == SUCCEEDED
    other = {f'elfin_joint{number}': 0.1 for number in range(1, 7)}
    assert elfin.send('elfin_arm_controller', list(other), [(0.8, list(other.values()))]
                      ).status == SUCCEEDED
    assert bot.distance(target) < 0.01
    assert elfin.distance(other) < 0.01
    assert set(elfin.positions()) == set(other)


def test_each_group_is_planned_and_executed(bot, elfin):
    """One planner for both, with the groups of their own files."""
    states = bot.move_group.named_states()
    for user, group in ((bot, 'arm'), (elfin, 'elfin_arm')):
        target = states[group, 'ready']
        assert user.move_group.move(group, target).error_code.val == SUCCESS
        assert user.distance(target) < 0.01


def test_each_manager_has_its_controllers(bot):
    """In the namespaces /bot and /."""
    for manager, arm in (('/bot/controller_manager', 'bot_joint_controller'),
                         ('/controller_manager', 'elfin_arm_controller')):
        states = ControllerManagerClient(bot.client, manager).states()
        assert states == {'joint_state_controller': 'active', arm: 'active'}
