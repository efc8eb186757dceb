"""Files of ROS 1 written for ROS 2: the same values, every comment, doubles as doubles."""

from pathlib import Path
import re
import shutil

import pytest
import yaml

from armsim_ros.config.controllers.controller_settings import PARAMETERS
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError
from armsim_ros.resources import find_robot, PACKAGE, robot_names, share_folder
from armsim_ros.tools.migrate import main, migrate, REPORT, settings_values
from armsim_ros.tools.migrate_text import real_number_edits


def comments(folder):
    """Return the comments of all YAML files of a folder."""
    text = '\n'.join(file.read_text(encoding='utf-8') for file in folder.glob('*.yaml'))
    return sorted(match.strip() for match in re.findall(r'(?:^|\s)(#.*)$', text, re.MULTILINE))


@pytest.fixture
def user(tmp_path):
    """Return a folder with the files of a user, with comments in every place."""
    folder = tmp_path / 'sunday'
    shutil.copytree(find_robot('sunday'), folder)
    shutil.copy(share_folder(PACKAGE) / 'urdf' / 'sunday.urdf.xacro', folder)
    (folder / 'trajectory_control.yaml').write_text("""# head of the file
sunday:  # the namespace
  # above the controller
  arm_joint_controller:  # beside its name
    type: "position_controllers/JointTrajectoryController"  # its type
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    # above the gains
    gains:
      joint_1:   {p: 1000, i: 0, d: 0.1, i_clamp: 0}  # '#' is not a comment here
    constraints: {goal_time: 1}
# further left
    stop_trajectory_duration: 1
# at the end
""")
    return folder


def test_every_robot_says_the_same_in_both_layouts(tmp_path):
    """Values are compared after loading; nothing of ROS 1 is left."""
    for name in robot_names():
        out = tmp_path / name
        migrate(name, out)
        before, after = load_robot_settings(name), load_robot_settings(str(out))
        assert settings_values(after) == settings_values(before)
        assert all(one.type == one.source_type for one in after.controllers)
        assert 'controller_list' not in ''.join(file.read_text() for file in after.files)


def test_every_comment_is_kept(user, tmp_path):
    """Also those of lines that go elsewhere."""
    migrate(str(user), tmp_path / 'out')
    before, after = comments(user), comments(tmp_path / 'out')
    assert [one for one in before if one not in after] == []


def test_a_block_keeps_its_form(user, tmp_path):
    """Flow style, order and comments are those of the author."""
    migrate(str(user), tmp_path / 'out')
    text = (tmp_path / 'out' / 'ros2_controllers.yaml').read_text()
    assert text.startswith('# head of the file\n')
    assert """
    # above the gains
    gains:
      joint_1:   {p: 1000.0, i: 0.0, d: 0.1, i_clamp: 0.0}  # '#' is not a comment here
    constraints: {goal_time: 1.0}
    # further left
    stop_trajectory_duration: 1.0
""" in text


def test_whole_numbers_that_ros2_refuses_have_a_point(user, tmp_path):
    """No double of a controller is written as a whole number."""
    migrate(str(user), tmp_path / 'out')
    root = read_yaml_file(tmp_path / 'out' / 'ros2_controllers.yaml')
    types = {name: one['type'] for name, one in root.plain()['/sunday/controller_manager'][
        'ros__parameters'].items()}
    assert types
    for name, kind in types.items():
        node = root.find([f'/sunday/{name}', 'ros__parameters'])[0]
        assert real_number_edits(PARAMETERS[kind], node) == {}


def test_aliases_are_written_out(user, tmp_path):
    """A block that stands for lines elsewhere cannot be moved as text."""
    (user / 'trajectory_control.yaml').write_text("""
sunday:
  arm_joint_controller:
    type: position_controllers/JointTrajectoryController
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    gains:
      joint_1: &same {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_2: *same
""")
    migrate(str(user), tmp_path / 'out')
    assert settings_values(load_robot_settings(str(tmp_path / 'out'))) == settings_values(
        load_robot_settings(str(user)))


def test_the_old_files_stay_and_the_report_is_in_the_folder(user, tmp_path, capsys):
    """The program prints what MIGRATION.txt holds."""
    before = {file: file.read_bytes() for file in user.iterdir()}
    out = tmp_path / 'out'
    assert main([str(user), f'--to:={out}']) == 0
    assert {file: file.read_bytes() for file in user.iterdir()} == before
    assert (out / REPORT).read_text() in capsys.readouterr().out
    assert 'trajectory_control.yaml:4 -> ros2_controllers.yaml' in (out / REPORT).read_text()


@pytest.mark.parametrize('given', [
    '', 'planning_plugin: ompl_interface/OMPLPlanner\n',
    'planning_plugins:\n  - ompl_interface/OMPLPlanner\n'])
def test_planners_are_those_of_ompl_unless_the_file_names_a_plugin(user, tmp_path, given):
    """A file of ROS 1 left the plugin to a launch file; in ROS 2 the file has it."""
    file = user / 'ompl_planning.yaml'
    lines = [line for line in file.read_text().splitlines() if 'planning_plugin' not in line]
    file.write_text(given + '\n'.join(lines) + '\n')
    migrate(str(user), tmp_path / 'out')
    written = (tmp_path / 'out/ompl_planning.yaml').read_text()
    assert written.count('planning_plugin') == 1
    assert written.count('ompl_interface/OMPLPlanner') == 1


def test_settings_of_a_pipeline_in_several_places(user, tmp_path):
    """They come together in its block, with their comments."""
    (user / 'more.yaml').write_text(
        '# repeatable\nplanning_seed: 7\n# far\njiggle_fraction: 0.1\n')
    migrate(str(user), tmp_path / 'out')
    found = load_robot_settings(str(tmp_path / 'out')).pipelines['ompl']
    assert (found.planning_seed, found.jiggle_fraction) == (7, 0.1)
    assert {'# repeatable', '# far'} <= set(comments(tmp_path / 'out'))


def test_ros2_files_are_taken_as_they_are(user, tmp_path):
    """A second migration changes nothing."""
    first, second = tmp_path / 'first', tmp_path / 'second'
    migrate(str(user), first)
    migrate(str(first), second)
    before, after = ({file.name: yaml.safe_load(file.read_text()) for file in out.glob('*.yaml')}
                     for out in (first, second))
    assert 'ros2_controllers.yaml' in before
    assert after == before


def test_a_folder_with_content_is_not_written_to(user, tmp_path):
    """Nothing of the user's is overwritten."""
    with pytest.raises(ConfigError, match='is not empty'):
        migrate(str(user), user)


def test_files_with_mistakes_are_not_written_on(user, tmp_path):
    """All mistakes are told and nothing is written."""
    (user / 'joint_limits.yaml').write_text('joint_limits: 5\n')
    out: Path = tmp_path / 'out'
    with pytest.raises(ConfigError, match=r'joint_limits\.yaml:1'):
        migrate(str(user), out)
    assert not out.exists()
