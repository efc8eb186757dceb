# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch files as files: what they import, what they raise, XML, YAML, ROS 1."""

import io
import subprocess
import sys
from xml.sax.saxutils import quoteattr

import pytest

from armsim_ros.launch.engine import watchdog
from armsim_ros.launch.main import main, parse_words


def test_a_file_that_raises_is_answered_with_its_own_line(dry):
    """A mistake in a launch file is said with its file and line, without a traceback."""
    said = dry("""
        def generate_launch_description():
            return 1 / 0
    """)
    assert said.status == 2
    assert 'it.launch.py:2: ZeroDivisionError: division by zero' in said.errors
    assert 'Traceback' not in said.errors


def test_a_syntax_error_is_answered_with_its_line(dry):
    """A file that is no Python is answered with file and line."""
    said = dry('def generate_launch_description(:\n    pass\n')
    assert 'it.launch.py:1' in said.errors
    assert 'SyntaxError' in said.errors


def test_what_fails_for_two_is_told_once(entities):
    """A description that cannot be made and that two nodes want is one mistake."""
    said = entities("""
        node('one', parameters=[{'robot_description': URDF}]),
        node('two', parameters=[{'robot_description': URDF}]),
    """, before='from launch.substitutions import Command\nURDF = Command("xacro /nowhere.xacro")')
    assert said.status == 2
    assert said.errors.count("'/nowhere.xacro' does not exist") == 1


def test_a_missing_module_is_named_with_its_line(dry):
    """P39: the module and the line that imports it; status 2."""
    said = dry('import not_a_module_of_anyone\n')
    assert said.plan[0].startswith('unknown: module not_a_module_of_anyone imported by ')
    assert said.plan[0].endswith('it.launch.py:1')
    assert said.status == 2


def test_a_name_that_the_api_lacks_is_named(dry):
    """P39: a name that a module of ours does not have is named with its module."""
    said = dry('from launch.actions import Teleport\n')
    assert said.plan[0].startswith('unknown: module launch.actions.Teleport imported by ')


def test_an_environment_variable_that_is_not_set_is_named(dry):
    """os.environ['X'] says which variable is not set."""
    said = dry("""
        import os
        def generate_launch_description():
            return os.environ['MODEL_OF_MY_ROBOT']
    """)
    assert 'it.launch.py:3: environment variable MODEL_OF_MY_ROBOT is not set' in said.errors


def test_a_module_in_the_sources_of_a_package_is_found(dry, workspace):
    """A launch file may import the Python package of a workspace's package."""
    (workspace / 'mine').mkdir()
    (workspace / 'mine' / '__init__.py').write_text('')
    (workspace / 'mine' / 'common.py').write_text('NAME = "shared"\n')
    said = dry("""
        from launch import LaunchDescription
        from launch_ros.actions import Node
        from mine.common import NAME

        def generate_launch_description():
            return LaunchDescription([Node(package='mine', executable='one', name=NAME)])
    """)
    assert list(said.processes()) == ['shared']
    assert 'mine.common' not in sys.modules


def test_the_names_are_there_only_while_a_file_is_evaluated(dry, workspace):
    """Nothing of ours can be imported afterwards, and nothing of the user's code is kept."""
    said = dry("""
        import launch, launch_ros, moveit_configs_utils, launch_param_builder
        import ament_index_python.packages
        assert launch.actions.DeclareLaunchArgument and launch_ros.actions.Node
        def generate_launch_description():
            return launch.LaunchDescription()
    """)
    assert said.plan == ['nothing to start']
    for name in ('launch', 'launch_ros', 'moveit_configs_utils'):
        assert name not in sys.modules
    assert not list(workspace.rglob('__pycache__'))


def test_a_missing_package_is_caught_by_upstreams_name(dry):
    """A launch file may import PackageNotFoundError from both of its modules and catch it."""
    said = dry("""
        import ament_index_python
        from ament_index_python.packages import (
            get_package_share_directory, PackageNotFoundError)
        from launch import LaunchDescription

        assert ament_index_python.PackageNotFoundError is PackageNotFoundError
        try:
            get_package_share_directory('nowhere')
        except PackageNotFoundError:
            def generate_launch_description():
                return LaunchDescription()
    """)
    assert (said.status, said.plan) == (0, ['nothing to start'])


def test_a_running_process_is_matched_by_the_end_of_its_first_word(entities):
    """launch.events.process has matches_executable; a process that has not started is none."""
    said = entities("""
        found := ExecuteProcess(cmd=['/usr/bin/ls', '.'], name='found'),
        OpaqueFunction(function=lambda context: [LogInfo(msg=str([
            matches_executable('ls')(found), setattr(found, 'process_details', {
                'cmd': ['/usr/bin/ls', '.']}), matches_executable('ls')(found),
            matches_executable('.')(found)]))]),
    """, before='from launch.events.process import matches_executable')
    assert '[False, None, True, False]' in said.errors


def test_a_real_module_is_not_shadowed(write, tmp_path):
    """Where a real module of the name can be imported, it is the one that is used."""
    (tmp_path / 'real' / 'nav2_common').mkdir(parents=True)
    (tmp_path / 'real' / 'nav2_common' / '__init__.py').write_text('REAL = True\n')
    path = write("""
        import nav2_common
        from launch import LaunchDescription
        from launch.actions import LogInfo

        def generate_launch_description():
            return LaunchDescription([LogInfo(msg=str(nav2_common.REAL))])
    """)
    done = subprocess.run(
        [sys.executable, '-c', 'import sys; from armsim_ros.launch.main import main; '
         f'sys.path.insert(0, {str(tmp_path / "real")!r}); sys.exit(main(["-n", {str(path)!r}]))'],
        capture_output=True, text=True, check=False)
    assert '[launch.user]: True' in done.stderr, done.stderr
    assert done.returncode == 0


def test_a_file_that_asks_says_that_nobody_answers(dry, monkeypatch):
    """A question of the file's own, input(), without a terminal is answered with its line."""
    monkeypatch.setattr('sys.stdin', io.StringIO())
    said = dry("""
        def generate_launch_description():
            return input('Which robot? ')
    """)
    assert said.status == 2
    assert '\nlaunch: ' in said.errors
    assert 'it.launch.py:2: the launch file asks for an answer' in said.errors


def test_a_file_that_includes_itself_is_stopped(entities):
    """A launch file that includes itself ends with a message that shows the circle."""
    said = entities('IncludeLaunchDescription(ThisLaunchFile()),')
    assert said.status == 2
    assert 'the launch file includes itself again and again' in said.errors


def test_a_file_that_loops_is_stopped(dry, monkeypatch):
    """A launch file that does not end is stopped, with the line where it loops."""
    monkeypatch.setattr(watchdog.__wrapped__, '__defaults__', (0.2,))
    said = dry("""
        def generate_launch_description():
            while True:
                pass
    """)
    assert said.status == 2
    assert 'the launch file does not come to an end' in said.errors
    assert 'it.launch.py' in said.errors


XML = """
    <launch>
      <arg name="who" default="anna" description="a name"/>
      <arg name="go" default="true"/>
      <let name="both" value="$(var who)_x"/>
      <group if="$(var go)">
        <push-ros-namespace namespace="cell"/>
        <node pkg="mine" exec="one" name="$(var both)" args="-a '$(var who) b'">
          <param name="n" value="3"/>
          <param name="block"><param name="x" value="1.5"/></param>
          <param from="$(find-pkg-share mine)/config/p.yaml"/>
          <remap from="a" to="b"/>
        </node>
      </group>
      <node pkg="mine" exec="two" unless="$(eval '&quot;$(var who)&quot; == &quot;anna&quot;')"/>
      <executable cmd="sh -c 'true'" name="say"/>
    </launch>
"""


def test_an_xml_file(dry, workspace):
    """P35: launch.xml with arguments, groups, conditions, parameters and substitutions."""
    (workspace / 'config' / 'p.yaml').touch()
    said = dry(XML, name='it.launch.xml')
    assert said.plan == [
        'process: mine/one name=anna_x ns=/cell parameters=n,block,p.yaml',
        'process: -/sh name=say ns=/ parameters=']


@pytest.mark.parametrize(('text', 'name'), [
    ('$(if $(var go) yes no)', 'yes'), ('$(if false yes no)', 'no'),
    ('a$(if false yes)', 'a'), ('$(not $(var go))', 'false'),
    ('$(and $(var go) false)', 'false'), ('$(or $(var go) false)', 'true'),
    ('$(any false false)', 'false'), ('$(all true false)', 'false'),
    ('$(equals $(var who) anna)', 'true'), ('$(not-equals $(var who) anna)', 'false'),
    ('$(param speed)', '2'), ('$(file-content name.txt)', 'content'),
    ('$(env NOT_SET_AT_ALL bert)', 'bert'), ('$(eval 1 + 2)', '3'),
    ('$(command "echo said")', 'said'), ('$(filename)', 'it.launch.xml'),
    ('$(exec-in-pkg one mine)', 'scripts/one'),
    ('$(param absent bert)', 'bert'), ('$(log_dir)', 'logs'),
    ("$(eval 'string.digits' 'math, string')", '0123456789'),
    ('$(xacro r.xacro)', '<robot name="r"/>'), ('$(dirname)', 'mine/launch'),
])
def test_a_word_of_a_file_gives_its_text(dry, tmp_path, text, name, monkeypatch):
    """Substitutions by their names (launch: substitutions, expose_substitution)."""
    (tmp_path / 'name.txt').write_text('content')
    (tmp_path / 'r.xacro').write_text('<robot name="r"/>')
    monkeypatch.setenv('ROS_LOG_DIR', 'logs')
    said = dry(f"""
        <launch>
          <arg name="who" default="anna"/>
          <arg name="go" default="true"/>
          <set_parameter name="speed" value="2"/>
          <log message={quoteattr(text)}/>
        </launch>
    """, name='it.launch.xml')
    assert said.status == 0
    assert said.errors.rstrip().endswith(name)


def test_a_yaml_file(dry, workspace):
    """P35: launch.yaml says the same as XML."""
    (workspace / 'config' / 'p.yaml').touch()
    said = dry("""
        launch:
        - arg: {name: who, default: anna}
        - group:
            - push_ros_namespace: {namespace: cell}
            - node:
                pkg: mine
                exec: one
                name: $(var who)
                param:
                - {name: n, value: 3}
                - {from: $(find-pkg-share mine)/config/p.yaml}
        - let: {name: who, value: bert}
        - node: {pkg: mine, exec: two, name: $(var who), if: 'false'}
        - executable: {cmd: sh -c true, name: say}
    """, name='it.launch.yaml')
    assert said.plan == ['process: mine/one name=anna ns=/cell parameters=n,p.yaml',
                         'process: -/sh name=say ns=/ parameters=']


def test_a_wrong_element_is_answered_with_its_line(dry):
    """An element that is not known is named with its line and the nearest one."""
    said = dry('<launch>\n  <nodes pkg="a" exec="b"/>\n</launch>\n', name='it.launch.xml')
    assert 'it.launch.xml:2' in said.errors
    assert "<nodes> is not an element of a launch file; did you mean 'node'?" in said.errors


def test_a_ros_1_file(dry, workspace):
    """ROS 1: types, parameters outside of nodes, rosparam files, $(arg) and $(find)."""
    (workspace / 'config' / 'c.yaml').write_text('a: 1\n')
    said = dry("""
        <launch>
          <arg name="name" default="arm" doc="its name"/>
          <param name="rate" value="50"/>
          <rosparam file="$(find mine)/config/c.yaml" command="load"/>
          <node pkg="mine" type="one" name="$(arg name)" required="true" ns="cell"/>
          <node pkg="controller_manager" type="spawner" name="s" args="arm_controller"/>
        </launch>
    """, name='it.launch')
    assert said.plan == [
        'process: mine/one name=arm ns=/cell parameters=rate,c.yaml',
        'process: controller_manager/spawner name=s ns=/ parameters=rate,c.yaml']


def test_show_args(write, capsys):
    """P35 -s: arguments with description and default."""
    path = write(XML, 'it.launch.xml')
    assert main(['-s', str(path)]) == 0
    text = capsys.readouterr().out
    assert "'who':\n        a name\n        (default: 'anna')" in text


def test_print_description(write, capsys):
    """P35 -p: the file as a tree."""
    path = write(XML, 'it.launch.xml')
    assert main(['-p', str(path)]) == 0
    assert "DeclareLaunchArgument('who')" in capsys.readouterr().out


@pytest.mark.parametrize(('words', 'text'), [
    (['mine', 'other.launch.py'], "has no launch file 'other.launch.py'; did you mean "
                                  "'it.launch.py'?"),
    (['no_such_package', 'x.launch.py'], "package 'no_such_package' is not found"),
    (['nowhere.launch.py'], "launch file 'nowhere.launch.py' does not exist"),
    (['x', '--launch-prefix'], "'--launch-prefix' needs a value"),
    (['--dry', 'x'], "unknown option '--dry'; did you mean '--dry-run'?"),
])
def test_wrong_words_are_answered(write, capsys, words, text):
    """P40: a mistake before the start is one message and status 2."""
    write('', 'it.launch.py')
    assert main(words) == 2
    assert text in capsys.readouterr().err


def test_options_set_the_prefix_of_the_processes(write):
    """ros2launch has these options, with a value that follows or is in the same word."""
    found = parse_words([str(write('')), '--launch-prefix', 'nice -n 5',
                         '--launch-prefix-filter=move.*'])
    assert found.arguments == {'launch-prefix': 'nice -n 5', 'launch-prefix-filter': 'move.*'}


def test_a_file_by_package_and_name(write, capsys):
    """P35: a file by the name of its package."""
    write(XML, 'it.launch.xml')
    assert main(['mine', 'it.launch.xml', 'go:=false', '-n']) == 0
    assert capsys.readouterr().out.splitlines() == ['process: -/sh name=say ns=/ parameters=']


def test_a_file_in_a_linked_folder(write, capsys, tmp_path):
    """The folder of a package may be one of links, and links may form a loop."""
    file = write(XML, 'it.launch.xml')
    away = tmp_path / 'away'
    away.mkdir()
    file.rename(away / file.name)
    (file.parent / 'launch').symlink_to(away)
    (away / 'again').symlink_to(away)
    (file.parent / 'installed').mkdir()
    (file.parent / 'installed' / file.name).symlink_to(away / file.name)
    assert main(['mine', 'it.launch.xml', 'go:=false', '-n']) == 0
    assert capsys.readouterr().out


def test_an_environment_in_a_checkout_is_not_part_of_it(write, capsys):
    """Its copy of a launch file does not compete with the file of the checkout."""
    file = write(XML, 'it.launch.xml')
    for name, mark in (('.venv', ''), ('environment', 'pyvenv.cfg')):
        copy = file.parent / name / 'share' / file.name
        copy.parent.mkdir(parents=True)
        copy.write_text('<nonsense/>')
        if mark:
            (file.parent / name / mark).touch()
    assert main(['mine', 'it.launch.xml', 'go:=false', '-n']) == 0
    assert 'process: ' in capsys.readouterr().out


def test_a_path_that_only_an_installation_has(dry, workspace, monkeypatch, tmp_path):
    """Launch files, parameters and programs are found where the rules of CMake install them."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    (workspace / 'CMakeLists.txt').write_text("""
        project(mine)
        install(DIRECTORY src/launch DESTINATION share/${PROJECT_NAME}/bringup)
        install(FILES config/real.yaml DESTINATION share/${PROJECT_NAME}/config RENAME arm.yaml)
        install(PROGRAMS src/deep/program.py DESTINATION lib/${PROJECT_NAME} RENAME renamed)
    """)
    for path, text in (('src/launch/inner.launch.xml', '<launch><node pkg="mine" exec="renamed">'
                        '<param from="$(find-pkg-share mine)/config/arm.yaml"/></node></launch>'),
                       ('config/real.yaml', '/**: {ros__parameters: {a: 1}}'),
                       ('src/deep/program.py', '')):
        (workspace / path).parent.mkdir(parents=True, exist_ok=True)
        (workspace / path).write_text(text)
    result = dry('<launch><include file="$(find-pkg-share mine)/bringup/launch/inner.launch.xml"/>'
                 '</launch>', name='it.launch.xml')
    assert result.status == 0, result.errors
    assert result.plan == ['process: mine/renamed name=renamed ns=/ parameters=arm.yaml']
