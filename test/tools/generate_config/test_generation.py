"""A complete set of files from a URDF alone, and what it is worth."""

import re
import shutil
from xml.etree import ElementTree

from public_robots import public_srdf, public_urdf
import pytest

from armsim_ros.errors import ConfigError, Severity
from armsim_ros.resources import find_robot, PACKAGE, share_folder
from armsim_ros.stack import ArmSim
from armsim_ros.tools.check_config.robot_check import check_robot
from armsim_ros.tools.generate_config.main import generate_config, main, read_urdf

OWN = share_folder(PACKAGE) / 'urdf'
FILES = {'joint_limits.yaml', 'kinematics.yaml', 'moveit_controllers.yaml',
         'ros2_controllers.yaml', 'simulation.yaml'}
STATES = 2000


def pairs_of(srdf):
    """Return the disabled pairs of an SRDF file."""
    return {tuple(sorted((one.get('link1'), one.get('link2')))): one.get('reason')
            for one in ElementTree.parse(srdf).getroot().iter('disable_collisions')}


def problems_of(folder):
    """Return what check_config says of a folder, but for remarks and the URDF's masses."""
    return [str(one) for one in check_robot(str(folder)).problems
            if one.severity in (Severity.ERROR, Severity.WARNING)
            and 'correct its <inertial>' not in str(one)]


def assert_moves(folder, group='arm'):
    """Plan to a state away from the start and execute it, without ROS."""
    arm = ArmSim(folder)
    arm.step(100)
    goal = dict(arm.model.semantic.named_states[group]['ready'])
    goal[next(iter(goal))] += 0.3  # about the upright axis: no nearer to the floor
    arm.execute(arm.plan(goal, group, velocity=0.5))
    assert max(abs(arm.joint_positions[name] - value) for name, value in goal.items()) < 0.01


@pytest.mark.parametrize('robot', ['bot', 'ROBOT', 'leg', 'magician', 'elfin'])
def test_the_files_of_a_urdf_are_complete_and_the_arm_moves(robot, tmp_path):
    """check_config has nothing to say; a plan is found and executed."""
    target = tmp_path / robot
    generate_config(OWN / f'{robot}.urdf.xacro', target, states=STATES)
    assert {file.name for file in target.iterdir()} == {
        *FILES, f'{robot}.srdf', f'{robot}.urdf.xacro'}
    assert problems_of(target) == []
    assert_moves(target)


@pytest.mark.parametrize('robot', ['ur5', 'panda', 'xarm7', 'so101'])
def test_public_robots(robot, tmp_path):
    """Descriptions of others, with their meshes."""
    target = tmp_path / robot
    generate_config(public_urdf(robot), target, states=STATES)
    assert problems_of(target) == []
    assert_moves(target)


@pytest.mark.parametrize(('robot', 'missing', 'more'), [
    ('panda', 0, 0),
    # A frame that has no shape in this URDF.
    ('xarm7', 1, 0),
    # Pairs that come nearer than 5 mm stay checked; the tool's box is not in their list.
    ('ur5', 3, 3),
])
def test_pairs_are_those_of_the_published_srdf(robot, missing, more, tmp_path):
    """What the makers' own SRDF leaves unchecked is nearly what is found."""
    generate_config(public_urdf(robot), tmp_path / 'x', states=10_000)
    found, published = pairs_of(tmp_path / 'x' / 'x.srdf'), pairs_of(public_srdf(robot))
    assert len(published.keys() - found.keys()) == missing
    assert len(found.keys() - published.keys()) == more


@pytest.mark.parametrize('robot', ['magician', 'leg'])
def test_pairs_are_those_that_were_chosen_by_hand(robot, tmp_path):
    """Pairs and reasons of the SRDF that this package brings."""
    generate_config(OWN / f'{robot}.urdf.xacro', tmp_path / 'x', states=10_000)
    assert pairs_of(tmp_path / 'x' / 'x.srdf') == pairs_of(find_robot(robot) / f'{robot}.srdf')


def test_the_same_seed_gives_the_same_files(tmp_path):
    """Files can be made again."""
    for name in ('one', 'two'):
        generate_config(OWN / 'bot.urdf.xacro', tmp_path / name / 'bot', states=500, seed=7)
    for file in FILES | {'bot.srdf'}:
        assert (tmp_path / 'one' / 'bot' / file).read_text() == (
            tmp_path / 'two' / 'bot' / file).read_text()


def test_files_that_are_there_are_not_overwritten(tmp_path):
    """Nothing is written over what a user has changed."""
    target = tmp_path / 'bot'
    target.mkdir()
    (target / 'kinematics.yaml').write_text('mine: {}\n')
    with pytest.raises(ConfigError, match=r'kinematics\.yaml exist already; name another'):
        generate_config(OWN / 'bot.urdf.xacro', target, states=300)
    assert [file.name for file in target.iterdir()] == ['kinematics.yaml']


def test_a_urdf_in_the_folder_itself(tmp_path):
    """The user's folder with one file becomes complete."""
    target = tmp_path / 'bot'
    target.mkdir()
    shutil.copy(OWN / 'bot.urdf.xacro', target)
    generate_config(target / 'bot.urdf.xacro', target, states=300)
    assert len(list(target.iterdir())) == len(FILES) + 2
    assert problems_of(target) == []


@pytest.mark.parametrize(('text', 'said'), [
    ('<robot name="x"><link name="a"/></robot>', "robot 'x' has no movable joint"),
    ('<robot name="x"><link name="a">', 'this is not XML'),
])
def test_a_urdf_that_is_wrong(text, said, tmp_path):
    """One message with the place; nothing is written."""
    (tmp_path / 'x.urdf').write_text(text)
    with pytest.raises(ConfigError, match=re.escape(said)):
        generate_config(tmp_path / 'x.urdf', tmp_path / 'out')
    assert not (tmp_path / 'out').exists()


def test_the_program_ends_as_check_config_does(tmp_path, capsys):
    """It prints groups, pairs, files, and the command that comes next."""
    target = tmp_path / 'leg'
    assert main([str(OWN / 'leg.urdf.xacro'), f'--to={target}', '--states=300']) == 0
    text = capsys.readouterr().out
    assert "group 'arm' (frame -> sole): hip, knee, foot; moved by 'arm_controller'" in text
    assert f'start it with: armsim bringup robot:={target}' in text


def test_a_xacro_with_arguments(small_package, tmp_path):
    """They decide what the robot is; the packages that it includes are found."""
    file = small_package.write('../description_folder/urdf/full.urdf.xacro', (
        small_package.XACRO.format('<xacro:arg name="tip" default="none"/>'
                                   '<xacro:include filename="arm.urdf"/><link name="$(arg tip)"/>'
                                   '<joint name="j" type="fixed"><parent link="lower"/>'
                                   '<child link="$(arg tip)"/></joint>')))
    assert generate_config(file, tmp_path / 'made', states=50, arguments={'tip': 'laser'})
    assert 'laser' in read_urdf(file, {'tip': 'laser'}).links
