"""
Every YAML and XML block of five published tutorials: read as it is, or answered exactly.

The blocks lie in ``seeds/<number>/`` as published, damaged where the text is damaged; what
check_config says of each stands in ``expected.txt`` beside them.
"""

from pathlib import Path

import pytest

from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import Severity
from armsim_ros.resources import find_robot
from armsim_ros.tools.check_config.robot_check import check_file

SEEDS = Path(__file__).parent / 'seeds'
BLOCKS = sorted(path.relative_to(SEEDS).as_posix() for path in SEEDS.glob('*/*')
                if path.name != 'expected.txt')
DAMAGED = {
    '003/controller_group_robot.yaml', '003/controllers.yaml', '003/joint_state_controller.yaml',
    '003/robot.launch', '003/robot_fragment.urdf', '003/robot_gazerbo_part.launch',
    '004/move_group.launch', '004/moveit_rviz.launch', '004/ros_controllers.launch',
    '004/ros_controllers.yaml',
}
#: Block -> the file of a robot of this package that is the block as published.
TAKEN_OVER = {
    '000/sunday_trajectory_control.yaml': 'sunday/trajectory_control.yaml',
    '000/sunday_gazebo_joint_states.yaml': 'sunday/joint_states.yaml',
    '000/controllers_gazebo.yaml': 'sunday/controllers_gazebo.yaml',
    '001/trajectory_control.yaml': 'bot/trajectory_control.yaml',
    '001/bot_gazebo_joint_states.yaml': 'bot/bot_gazebo_joint_states.yaml',
    '001/controllers_gazebo.yaml': 'bot/controllers_gazebo.yaml',
    '002/trajectory_control.yaml': 'ROBOT/trajectory_control.yaml',
    '002/ROBOT_gazebo_joint_states.yaml': 'ROBOT/ROBOT_gazebo_joint_states.yaml',
    '002/controllers_gazebo.yaml': 'ROBOT/controllers_gazebo.yaml',
}


def said(block):
    """Return what is said of a block, one line a problem, without the folders' path."""
    found = check_file(SEEDS / block).problems
    return [f'{one.severity.value}: {one}'.replace(f'{SEEDS}/', '') for one in found]


@pytest.mark.parametrize('block', BLOCKS)
def test_a_block_is_answered_exactly(block):
    """SEED-2, SEED-3, SEED-5, Q8, CFG-11: nothing but the expected lines."""
    lines = (SEEDS / block).with_name('expected.txt').read_text(encoding='utf-8').splitlines()
    assert said(block) == [line for line in lines if line.split(': ', 1)[1].startswith(
        (f'{block}:', f'{block} '))]


@pytest.mark.parametrize('block', BLOCKS)
def test_only_damaged_blocks_have_mistakes(block):
    """A damaged text gives one mistake that names its line; every other block gives none."""
    mistakes = [one for one in check_file(SEEDS / block).problems
                if one.severity is Severity.ERROR]
    assert len(mistakes) == (block in DAMAGED)
    assert all(one.where.line for one in mistakes)


@pytest.mark.parametrize('block', TAKEN_OVER)
def test_the_robots_of_this_package_run_the_blocks_as_published(block):
    """The file that runs has the text of the block."""
    file = find_robot(TAKEN_OVER[block].split('/')[0]) / TAKEN_OVER[block].split('/')[1]
    assert file.read_text(encoding='utf-8').split() == (SEEDS / block).read_text(
        encoding='utf-8').split()


@pytest.mark.parametrize(('block', 'file'), [
    ('003/controller_group_robot.yaml', 'leg/controller_group_robot.yaml'),
    ('003/joint_state_controller.yaml', 'leg/joint_state_controller.yaml'),
    ('004/ros_controllers.yaml', 'magician/ros_controllers.yaml'),
])
def test_a_damaged_block_has_a_cleaned_file_that_says_so(block, file):
    """Q8: the cleaned file begins with the remark that the published text is damaged."""
    robot, name = file.split('/')
    path = find_robot(robot) / name
    assert path.read_text(encoding='utf-8').startswith('# The published text has lost')
    assert read_yaml_file(path).entries
