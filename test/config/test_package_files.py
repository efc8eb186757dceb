# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which files of a MoveIt configuration package count; each convention has one test."""

import pytest

from armsim_ros.config.robot_folder import find_files
from armsim_ros.errors import ConfigError, Severity


def found(package, **words):
    """Return the files of a package."""
    return find_files(str(package.folder), **words)


def said(files, severity):
    """Return what was said in choosing the files."""
    return [str(one) for one in files.remarks if one.severity is severity]


def test_a_package_is_named_by_folder_or_by_name(small_package):
    """A folder with package.xml is a package, and its name leads to it."""
    assert found(small_package).urdf_file.name == 'small.urdf.xacro'
    by_name = find_files('small_moveit_config', packages_path=[small_package.src])
    assert by_name.folder == small_package.folder


@pytest.mark.parametrize('noise', ['small.ros2_control.xacro', 'small_macro.urdf.xacro',
                                   'hand.xacro'])
def test_a_macro_is_never_the_robot(small_package, noise):
    """Files that others include are not taken for the URDF, whatever the folder is called."""
    small_package.write(f'config/{noise}', '<robot/>')
    (small_package.folder / 'config/small.urdf.xacro').rename(
        small_package.folder / 'config/other.urdf.xacro')
    files = found(small_package)
    assert files.urdf_file.name == 'other.urdf.xacro'
    assert files.name == 'other'


def test_the_setup_assistant_names_urdf_and_srdf(small_package):
    """Where config/ has no URDF of the robot's name, .setup_assistant says which one it is."""
    small_package.remove('config/small.urdf.xacro')
    small_package.write('.setup_assistant', (
        'moveit_setup_assistant_config:\n'
        '  urdf: {package: small_description, relative_path: urdf/arm.urdf,\n'
        '         xacro_args: "a:=1 b:=two"}\n'
        '  srdf: {relative_path: config/arm_with_hand.srdf}\n  CONFIG: {author_name: x}\n'))
    small_package.write('config/arm_with_hand.srdf.xacro', small_package.SRDF)
    files = found(small_package)
    assert files.urdf_file == small_package.description / 'urdf/arm.urdf'
    assert files.srdf_file.name == 'arm_with_hand.srdf.xacro'
    assert files.arguments == {'a': '1', 'b': 'two'}
    assert found(small_package, arguments={'a': '3'}).arguments == {'a': '3', 'b': 'two'}


def test_what_the_setup_assistant_names_and_is_missing_is_a_warning(small_package):
    """The next rule finds the files."""
    small_package.write('.setup_assistant', (
        'moveit_setup_assistant_config:\n  URDF: {package: lost, relative_path: urdf/x.urdf}\n'
        '  SRDF: {relative_path: config/lost.srdf}\n'))
    (small_package.folder / 'config/small.urdf.xacro').rename(
        small_package.folder / 'config/small.urdf')
    files = found(small_package)
    assert files.urdf_file.name == 'small.urdf'
    assert files.srdf_file.name == 'small.srdf'
    warnings = said(files, Severity.WARNING)
    assert any("package 'lost' is not found" in text for text in warnings)
    assert any("the SRDF 'config/lost.srdf' does not exist" in text for text in warnings)
    assert all('.setup_assistant:2' in text or '.setup_assistant:3' in text for text in warnings)


def test_the_users_words_win(small_package, tmp_path):
    """urdf:= and srdf:= are taken before any rule."""
    urdf, srdf = tmp_path / 'mine.urdf', tmp_path / 'mine.srdf'
    urdf.write_text('<robot/>')
    srdf.write_text('<robot/>')
    files = found(small_package, urdf=urdf, srdf=srdf)
    assert (files.urdf_file, files.srdf_file) == (urdf, srdf)


def test_a_package_without_a_urdf_says_what_to_do(small_package):
    """The message names the package and the word that helps."""
    small_package.remove('config/small.urdf.xacro')
    with pytest.raises(ConfigError, match=r'has no URDF .*urdf:=FILE'):
        found(small_package)


def test_a_package_without_a_urdf_names_what_could_be_meant(small_package):
    """The message has the URDFs of the workspace that fit the SRDF, and the launch files."""
    small_package.remove('config/small.urdf.xacro')
    small_package.write('launch/demo.launch.py', '')
    small_package.write('../other/package.xml', '<package><name>other</name></package>')
    small_package.write('../other/urdf/other.urdf', '<robot name="small"><link name="x"/></robot>')
    macro = small_package.XACRO.format('<xacro:macro name="arm" params="p">' + (
        small_package.ARM.replace('name="', 'name="${p}')) + '</xacro:macro>')
    top = ('<xacro:arg name="p" default=""/><xacro:include filename="arm_macro.xacro"/>'
           '<xacro:arm p="$(arg p)"/>')
    small_package.write('../other/urdf/arm_macro.xacro', macro)
    small_package.write('../other/urdf/top.urdf.xacro', small_package.XACRO.format(top))
    with pytest.raises(ConfigError) as caught:
        found(small_package)
    text = str(caught.value)
    src = small_package.src / 'repository'
    assert f"urdf:={src / 'description_folder/urdf/arm.urdf'}" in text
    assert f"urdf:={src / 'other/urdf/top.urdf.xacro'}" in text
    assert 'other.urdf' not in text
    assert 'arm_macro' not in text
    assert 'armsim launch small_moveit_config demo.launch.py' in text


def test_an_srdf_is_never_the_robot(small_package):
    """A package whose URDF a launch file names asks for it, though its SRDF is a xacro."""
    small_package.remove('config/small.urdf.xacro', 'config/small.srdf')
    small_package.write('config/small.srdf.xacro', small_package.SRDF)
    with pytest.raises(ConfigError, match=r'has no URDF that its files name; name it: urdf:=FILE'):
        found(small_package)


def test_alternatives_are_named_and_not_read(small_package):
    """Files that are not called as the stack reads them get a line each and are left alone."""
    for name in ('hard_joint_limits.yaml', 'bio_ik_kinematics.yaml', 'small_servo.yaml',
                 'cameras.yaml'):
        small_package.write(f'config/{name}', 'a: {b: 1}\n')
    files = found(small_package)
    assert {file.name for file in files.yaml_files} == {
        'moveit_controllers.yaml', 'ros2_controllers.yaml'}
    assert len(said(files, Severity.INFO)) == 4
    assert not said(files, Severity.WARNING)


@pytest.mark.parametrize(('names', 'expected'), [
    (['moveit_controllers.yaml', 'arm_controllers.yaml'], 'moveit_controllers.yaml'),
    (['moveit2_controllers.yaml', 'arm_controllers.yaml'], 'moveit2_controllers.yaml'),
    (['small_controllers.yaml', 'arm_controllers.yaml'], 'small_controllers.yaml'),
    (['arm_controllers.yaml'], 'arm_controllers.yaml'),
    (['arm_controllers.yaml', 'fake_controllers.yaml'], 'arm_controllers.yaml'),
    (['controllers.yaml'], 'controllers.yaml'),
])
def test_the_controllers_of_move_group(small_package, names, expected):
    """The only file counts; of several the one with the usual name; else the content tells."""
    small_package.remove('config/moveit_controllers.yaml')
    for name in names:
        small_package.write(f'config/{name}', small_package.MOVEIT)
    files = found(small_package)
    chosen = [file.name for file, role in files.package.roles.items()
              if role.name == 'MOVEIT_CONTROLLERS']
    assert chosen == [expected]


def test_the_controllers_of_ros2_control_by_content(small_package):
    """Without ros2_controllers.yaml the file with a controller_manager node counts."""
    (small_package.folder / 'config/ros2_controllers.yaml').rename(
        small_package.folder / 'config/hardware.yaml')
    files = found(small_package)
    assert [file.name for file in files.package.ros2_controllers] == ['hardware.yaml']


def test_a_folder_of_settings_is_looked_at_first(small_package, tmp_path):
    """config:=DIR has its own version of some files; the others come from config/."""
    small_package.write('config/kinematics.yaml', 'arm: {kinematics_solver: a/B}\n')
    small_package.write('config/variant/kinematics.yaml', 'arm: {kinematics_solver: c/D}\n')
    files = found(small_package, config=small_package.folder / 'config/variant')
    names = {file.name: file.parent.name for file in files.yaml_files}
    assert names['kinematics.yaml'] == 'variant'
    assert names['moveit_controllers.yaml'] == 'config'


def test_the_deprecated_name_of_the_cartesian_limits(small_package):
    """It is read with a warning, and not where the new name is there too."""
    old = small_package.write('config/cartesian_limits.yaml', 'cartesian_limits: {}\n')
    files = found(small_package)
    assert old in files.yaml_files
    assert 'deprecated' in said(files, Severity.WARNING)[0]
    new = small_package.write('config/pilz_cartesian_limits.yaml', 'cartesian_limits: {}\n')
    files = found(small_package)
    assert new in files.yaml_files
    assert old not in files.yaml_files


def test_a_description_package_stands_for_the_moveit_package_that_needs_it(small_package):
    """Where several need it, they are named."""
    manifest = ('<package><name>{0}_moveit_config</name>'
                '<exec_depend>small_description</exec_depend></package>')
    small_package.write('package.xml', manifest.format('small'))
    assert find_files(str(small_package.description)).folder == small_package.folder
    small_package.write('../other/package.xml', manifest.format('other'))
    small_package.write('../other/config/x.srdf', small_package.SRDF)
    with pytest.raises(ConfigError, match=r'allowed: other_moveit_config, small_moveit_config'):
        find_files(str(small_package.description))


def test_a_workspace_stands_for_its_only_moveit_package(small_package):
    """robot:=ws/src is enough."""
    assert find_files(str(small_package.src)).folder == small_package.folder


def test_a_description_package_alone(small_package):
    """Its URDF runs without planning groups."""
    files = find_files(str(small_package.description))
    assert files.urdf_file.name == 'arm.urdf'
    assert files.srdf_file is None
