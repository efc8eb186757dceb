# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Texts of launch files that are known only when they run."""

import pytest

CASES = {
    "LaunchConfiguration('a')": 'left',
    "LaunchConfiguration('none', default='x')": 'x',
    "PathJoinSubstitution(['p', LaunchConfiguration('a'), ['q', 'r']])": 'p/left/qr',
    "PathSubstitution('p') / LaunchConfiguration('a') / 'z'": 'p/left/z',
    "PythonExpression(['1 + ', '2'])": '3',
    """PythonExpression(["'", LaunchConfiguration('a'), "' == 'left' and 5 > 3"])""": 'True',
    "TextSubstitution(text='t')": 't',
    "Command(['echo ', LaunchConfiguration('a')])": 'left',
    "EnvironmentVariable('NOT_SET_AT_ALL', default_value='d')": 'd',
    "EqualsSubstitution(LaunchConfiguration('a'), 'left')": 'true',
    "NotEqualsSubstitution('1.0', '1')": 'false',
    "EqualsSubstitution('1', True)": 'true',
    "EqualsSubstitution('yes', 'true')": 'false',
    "EqualsSubstitution('0.001', '1e-3')": 'true',
    "AndSubstitution('true', 'false')": 'false',
    "OrSubstitution('true', 'false')": 'true',
    "NotSubstitution('true')": 'false',
    "IfElseSubstitution('true', 'yes', 'no')": 'yes',
    "[FindPackageShare('mine'), '/launch']": 'src/mine/launch',
    "FindPackageShare('mine') / 'launch'": 'src/mine/launch',
    'ThisLaunchFileDir()': 'src/mine/launch',
    "Parameter('speed')": '2',
    "Parameter('none', default=['d', 'e'])": 'de',
    "FileContent(PathJoinSubstitution([FindPackageShare('mine'), 'package.xml']))":
        '<package><name>mine</name></package>',
}


@pytest.mark.parametrize('text', CASES)
def test_a_substitution_gives_its_text(entities, text):
    """P36: each substitution gives the text that it names."""
    said = entities(f"""
        SetLaunchConfiguration('a', 'left'),
        SetParameter('speed', 2),
        LogInfo(msg={text}),
    """)
    line = next(line for line in said.errors.splitlines() if line.startswith('[INFO]'))
    assert line.removeprefix('[INFO] [launch.user]: ').strip().endswith(CASES[text])
    assert said.status == 0


def test_a_substitution_of_the_users_own(entities):
    """P36: a subclass of Substitution is performed like any other."""
    said = entities('node(Mine()),', before="""
from launch import Substitution


class Mine(Substitution):
    def perform(self, context):
        return 'own'
""")
    assert list(said.processes()) == ['own']


def test_a_configuration_that_does_not_exist_is_named_with_its_line(entities):
    """What a substitution lacks is said with file, line and the nearest name."""
    said = entities("""
        SetLaunchConfiguration('robot_name', 'x'),
        node(LaunchConfiguration('robot_nam')),
    """)
    assert "launch configuration 'robot_nam' does not exist; did you mean 'robot_name'?" \
        in said.errors
    assert 'it.launch.py:' in said.errors
    assert said.status == 2


def test_a_parameter_that_is_not_set_is_named(entities):
    """launch_ros/substitutions/parameter.py, perform: without a default it fails."""
    said = entities("LogInfo(msg=Parameter('speed')),")
    assert "parameter 'speed' is not set" in said.errors
    assert said.status == 2


def test_command_runs_xacro_inside(entities, workspace):
    """P37 Command: xacro runs without a process; its file may find packages of the workspace."""
    (workspace / 'config' / 'r.urdf.xacro').write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="n" '
        'default="a"/><link name="$(arg n)_$(find mine)"/></robot>')
    said = entities("""
        LogInfo(msg=Command([FindExecutable(name='xacro'), ' ', PathJoinSubstitution(
            [FindPackageShare('mine'), 'config', 'r.urdf.xacro']), ' n:=b'])),
    """)
    assert f'<link name="b_{workspace}"/>' in said.errors


def test_an_argument_of_xacro_without_a_value_leaves_the_default(entities, workspace):
    """xacro/cli.py, load_mappings: names and values are stripped, empty ones are skipped."""
    (workspace / 'config' / 'r.xacro').write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="p" default="arm_"/><xacro:arg name="n" default="x"/>'
        '<link name="$(arg p)$(arg n)"/></robot>')
    said = entities("""
        LogInfo(msg=Command(['xacro ', FindPackageShare('mine'), '/config/r.xacro',
                             ' p:=""', ' "n:= a "'])),
    """)
    assert '<link name="arm_a"/>' in said.errors


def test_xacro_sees_the_environment_of_the_launch(entities, workspace):
    """``$(optenv)`` of a robot description is what SetEnvironmentVariable has set."""
    (workspace / 'config' / 'r.xacro').write_text(
        '<robot name="r"><link name="$(optenv ARM_KIND none)"/></robot>')
    said = entities("""
        SetEnvironmentVariable('ARM_KIND', 'left'),
        LogInfo(msg=Command(['xacro ', FindPackageShare('mine'), '/config/r.xacro'])),
    """)
    assert '<link name="left"/>' in said.errors


def test_a_missing_package_is_named(entities):
    """P41: a package that is nowhere is named, and the rest of the file is looked at."""
    said = entities("""
        IncludeLaunchDescription([FindPackageShare('nowhere_at_all'), '/launch/x.launch.py']),
        node('goes_on'),
    """)
    assert said.plan == ['missing package: nowhere_at_all',
                         'process: mine/one name=goes_on ns=/ parameters=']
    assert "package 'nowhere_at_all' is not found; searched: " in said.errors
    assert 'clone it into src/' in said.errors
    assert said.status == 2


def test_a_path_of_a_missing_package_that_nobody_opens_is_no_failure(entities):
    """P41: the package is named, and what only hands a path of it on is started."""
    said = entities("""
        node('goes_on', arguments=[[FindPackageShare('nowhere_at_all'), '/script']]),
        node('twice', arguments=[[FindPackageShare('nowhere_at_all'), '/script']]),
    """)
    assert said.plan == ['missing package: nowhere_at_all',
                         'process: mine/one name=goes_on ns=/ parameters=',
                         'process: mine/one name=twice ns=/ parameters=']
    assert said.status == 0
