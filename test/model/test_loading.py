"""Settings, URDF and SRDF together: one model, or the list of all mistakes."""

import math
from pathlib import Path
import shutil

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import ConfigError
from armsim_ros.model.loading import load_robot_model
from armsim_ros.resources import find_robot, PACKAGE, share_folder


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the sunday robot's files."""
    copy = tmp_path / 'sunday'
    shutil.copytree(find_robot('sunday'), copy)
    shutil.copy(share_folder(PACKAGE) / 'urdf' / 'sunday.urdf.xacro', copy)
    return copy


def change(file, old, new):
    """Replace a text that must be there."""
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def load(folder):
    """Return the model and the messages that are no mistakes."""
    problems = []
    model = load_robot_model(load_robot_settings(str(folder)), report=problems.append)
    return model, [str(one).replace(f'{folder}/', '') for one in problems]


def mistakes(folder):
    """Return the messages of the mistakes."""
    with pytest.raises(ConfigError) as caught:
        load(folder)
    return [str(one).replace(f'{folder}/', '') for one in caught.value.problems]


def test_joint_limits_leave_the_robot_as_the_urdf_has_it(folder):
    """
    The file bounds plans; drives, ranges and controllers have the URDF's limits.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure is the only
    reader.
    """
    expected = {name: joint.limits for name, joint in load(folder)[0].joints.items()}
    (folder / 'joint_limits.yaml').write_text("""
joint_limits:
  joint_1: {has_velocity_limits: true, max_velocity: 5, has_acceleration_limits: true,
            max_acceleration: 2, min_position: -1, max_position: 1}
  joint_2: {has_velocity_limits: false}
""")
    assert {name: joint.limits for name, joint in load(folder)[0].joints.items()} == expected
    assert expected['joint_1'].acceleration == math.inf


def test_limits_without_effect_are_reported(folder):
    """
    A value without its has_..., has_... without a value: a warning each, and the robot loads.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure.
    """
    (folder / 'joint_limits.yaml').write_text("""
joint_limits:
  joint_1: {max_velocity: 5}
  joint_2: {has_acceleration_limits: true}
  joint_3: {has_acceleration_limits: false, max_acceleration: 0, has_position_limits: true}
""")
    assert load(folder)[1] == [
        "joint_limits.yaml:3:13: joint limits: 'max_velocity' of joint 'joint_1' has no effect "
        'without has_velocity_limits: true',
        "joint_limits.yaml:4:13: joint limits: joint 'joint_2' has has_acceleration_limits: true "
        'and no max_acceleration; add it, or set has_... to false']


def test_a_range_of_a_joint_without_end_is_reported(folder):
    """A continuous joint has no position limits (robot_model_loader.cpp, canSpecifyPosition)."""
    text = load(folder)[0].urdf
    (folder / 'sunday.urdf.xacro').unlink()
    head = '<joint name="joint_6" type="revolute">'
    (folder / 'sunday.urdf').write_text(text.replace(head, head.replace('revolute', 'continuous')))
    (folder / 'joint_limits.yaml').write_text("""
joint_limits:
  joint_5: {min_position: -1, max_position: 1}
  joint_6: {max_position: 1}
""")
    assert load(folder)[1] == [
        "joint_limits.yaml:4:13: joint limits: 'max_position' of continuous joint 'joint_6' has "
        'no effect']


def test_a_joint_that_the_urdf_lacks(folder):
    """The controller's line is named, and the nearest joint."""
    change(folder / 'trajectory_control.yaml', '- joint_6', '- joint6')
    change(folder / 'trajectory_control.yaml', 'joint_6:   {', 'joint6:   {')
    assert mistakes(folder) == [
        "trajectory_control.yaml:10:9: controller 'arm_joint_controller': joint 'joint6' is not "
        "in the URDF of robot 'sunday'; did you mean 'joint_6'?"]


def test_a_joint_that_cannot_be_commanded(folder):
    """A fixed joint and a mimic joint are refused."""
    text = load(folder)[0].urdf
    (folder / 'sunday.urdf.xacro').unlink()
    head = '<joint name="joint_6" type="revolute">'
    (folder / 'sunday.urdf').write_text(text.replace(head, head + '<mimic joint="joint_5"/>'))
    assert mistakes(folder)[0] == (
        "trajectory_control.yaml:10:9: controller 'arm_joint_controller': joint 'joint_6' follows "
        "'joint_5' and cannot be commanded by itself; remove it from the controller, or its "
        '<mimic> from the URDF')


def test_joints_of_move_groups_controllers(folder):
    """EXE-1: the list that move_group reads is checked against the URDF too."""
    change(folder / 'controllers_gazebo.yaml', '- joint_6', '- joint_7')
    assert mistakes(folder) == [
        "controllers_gazebo.yaml:13:9: MoveIt controller 'sunday/arm_joint_controller': joint "
        "'joint_7' is not in the URDF of robot 'sunday'; did you mean 'joint_6'?"]


def test_a_typo_in_a_namespace(folder):
    """Nobody would serve the action: the message names the one that is served."""
    change(folder / 'controllers_gazebo.yaml', 'sunday/arm', 'sundy/arm')
    assert any("controllers_gazebo.yaml:3:5: MoveIt controller 'sundy/arm_joint_controller': no "
               'controller of this name runs here' in one and
               "did you mean 'sunday/arm_joint_controller'?" in one for one in load(folder)[1])


def test_a_group_without_a_controller(folder):
    """SEED-9, complaint 1: the YAML to add is part of the warning."""
    change(folder / 'controllers_gazebo.yaml', '      - joint_6\n', '')
    (warning,) = load(folder)[1]
    assert warning.startswith(
        "sunday.srdf:5:3: planning group 'manipulator' cannot be executed: no controller moves "
        'joint_6; add to controller_list: - {name: sunday/arm_joint_controller, action_ns: ')


def test_a_passive_joint_needs_no_controller(folder):
    """Controllers leave passive joints out, so that none has to move them."""
    change(folder / 'controllers_gazebo.yaml', '      - joint_6\n', '')
    change(folder / 'sunday.srdf', '</robot>', '<passive_joint name="joint_6"/></robot>')
    assert load(folder)[1] == []


def test_names_in_the_other_files(folder):
    """Limits, solvers and planners of what is not there give a warning each."""
    change(folder / 'joint_limits.yaml', '  joint_6:', '  joint_66:')
    change(folder / 'kinematics.yaml', 'manipulator:', 'manipulatr:')
    change(folder / 'ompl_planning.yaml', '    - EST', '    - ETS')
    warnings = load(folder)[1]
    assert len(warnings) == 3
    assert 'joint_limits.yaml:29:3: joint limits: joint ' in warnings[0]
    assert "kinematics.yaml:1:1: kinematics: planning group 'manipulatr'" in warnings[1]
    assert "'ETS' is not in planner_configs" in warnings[2]


def test_a_mistake_in_a_xacro_file_has_the_line_of_the_source(folder):
    """After xacro the text has other lines; a name leads back to the right one."""
    change(folder / 'sunday.urdf.xacro', 'parent="link_5" child="camera_link"',
           'parent="link_55" child="camera_link"')
    found = mistakes(folder)
    lines = (folder / 'sunday.urdf.xacro').read_text().splitlines()
    line = next(n for n, text in enumerate(lines, 1) if 'link_5_to_camera_link' in text)
    assert found[0] == (f"sunday.urdf.xacro:{line}: parent of joint 'link_5_to_camera_link': link "
                        "'link_55' is not in the URDF; did you mean 'link_5'?")


@pytest.mark.parametrize(('old', 'new', 'message'), [
    ('${-reach}', '${-rech}', "sunday.urdf.xacro:47: xacro: name 'rech' is not defined"),
    ('</robot>', '', 'sunday.urdf.xacro:'),
    ('<link name="world"/>', '<xacro:include filename="$(find nowhere)/a.xacro"/>',
     "sunday.urdf.xacro: package 'nowhere' is not found"),
    ('<link name="world"/>', '<xacro:include filename="gone.xacro"/>',
     'sunday.urdf.xacro: xacro: No such file or directory'),
    ('<link name="world"/>', '<xacro:nothing/>',
     'sunday.urdf.xacro:22: xacro: unknown macro name'),
])
def test_mistakes_that_xacro_finds(folder, old, new, message):
    """One message with the file, no traceback."""
    change(folder / 'sunday.urdf.xacro', old, new)
    (found,) = mistakes(folder)
    assert message in found


def test_find_looks_near_the_robots_files(folder):
    """$(find pkg) finds a package whose folder lies beside the robot's."""
    package = folder.parent / 'my_description'
    package.mkdir()
    (package / 'part.xacro').write_text('<robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
                                        '<link name="world"/></robot>')
    change(folder / 'sunday.urdf.xacro', '<link name="world"/>',
           '<xacro:include filename="$(find my_description)/part.xacro"/>')
    assert load(folder)[0].root_link == 'world'


def test_a_mesh_that_cannot_be_read(folder):
    """The link goes without it, with the line of the URDF; --strict refuses the robot."""
    (folder / 'hand.dae').write_text('<COLLADA/>')
    change(folder / 'sunday.urdf.xacro', '<link name="camera_color_optical_frame"/>',
           '<link name="camera_color_optical_frame"><collision><geometry>'
           '<mesh filename="hand.dae"/></geometry></collision></link>')
    _, warnings = load(folder)
    (found,) = [one for one in warnings if 'hand.dae' in one]
    assert "link 'camera_color_optical_frame' has no collision geometry: mesh 'hand.dae'" in found
    assert 'sunday.urdf.xacro:' in found


def test_a_robot_without_an_srdf(folder):
    """It runs, and cannot be planned for."""
    (folder / 'sunday.srdf').unlink()
    model, warnings = load(folder)
    assert model.semantic.groups == {}
    assert any("planning group 'manipulator' is not in the SRDF" in one for one in warnings)


def test_the_urdf_text_is_kept(folder):
    """Robot descriptions are published as xacro made them."""
    model, _ = load(folder)
    assert '<joint name="joint_1" type="revolute">' in model.urdf
    assert 'xacro:macro' not in model.urdf
    assert model.srdf == Path(folder / 'sunday.srdf').read_text()
