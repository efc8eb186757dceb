# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The door through which every program starts."""

from io import BytesIO, TextIOWrapper
import os
from pathlib import Path
import signal
import subprocess
import sys
from types import ModuleType

import pytest

from armsim_ros.cli import main as door
from armsim_ros.cli.environment import (
    add_own_prefix,
    announce_often,
    child_environment,
    ensure_log_folder,
    started_by_bringup,
)
from armsim_ros.cli.programs import PROGRAMS, ROBOT_PROGRAMS
from armsim_ros.errors import ResourceError


@pytest.fixture
def program(monkeypatch):
    """Put a program of our own in simulation's place and return its module."""
    module = ModuleType('armsim_ros.nodes.robot_program')
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setenv('AMENT_PREFIX_PATH', '/somewhere')
    usual = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield module
    for number, handler in usual.items():
        signal.signal(number, handler)


def test_the_command_without_a_program_lists_them(capsys):
    """Armsim alone shows what there is and is a usage error."""
    assert door.main([]) == 2
    assert door.main(['--help']) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in PROGRAMS)


def test_an_unknown_program_is_answered_with_the_nearest(capsys):
    """A slip of the finger is named."""
    assert door.main(['bringpu']) == 2
    assert "did you mean 'bringup'?" in capsys.readouterr().err


@pytest.mark.parametrize(('word', 'command'), [
    ('topics', 'ros2 topic list'), ('topic', 'ros2 topic'), ('echo', 'ros2 topic echo')])
def test_a_command_of_ros_is_named(word, command, capsys):
    """A word of ROS 2 leads to its own command, not to a motion of a similar name."""
    assert door.main([word]) == 2
    assert f"the command is '{command}'" in capsys.readouterr().err


@pytest.mark.parametrize('name', ROBOT_PROGRAMS)
def test_every_robot_program_explains_itself_without_being_imported(name, capsys):
    """Its --help needs neither ROS nor the program's libraries."""
    assert door.main([name, '--help']) == 0
    assert 'robot:=NAME|DIR' in capsys.readouterr().out


def test_help_for_ros_is_not_ours(program, capsys):
    """A --help behind --ros-args goes to rclpy."""
    program.simulation = len
    words = ['--ros-args', '--help']
    assert door.start_program('simulation', words) == len(words)
    assert capsys.readouterr().out == ''


def test_a_program_gets_its_words_and_gives_the_status(program):
    """What main returns is the exit status."""
    program.simulation = lambda argv: 7 if argv == ['paused:=true'] else 1
    assert door.main(['simulation', 'paused:=true']) == 7


def test_a_mistake_of_the_user_is_one_message_and_status_2(program, capsys):
    """Our own errors show their text, no traceback."""
    def fail(argv):
        raise ResourceError("robot 'x' does not exist")

    program.simulation = fail
    assert door.start_program('simulation', []) == 2
    assert capsys.readouterr().err == "simulation: robot 'x' does not exist\n"


def test_a_reader_that_has_seen_enough_ends_the_program():
    """Output to a closed pipe is no error: nothing is printed, and the status is a shell's."""
    with subprocess.Popen([sys.executable, '-m', 'armsim_ros', 'list'], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.wait(30.0) == 128 + signal.SIGPIPE
        assert process.stderr.read() == b''


def test_a_missing_package_is_named_with_the_remedy(program, capsys):
    """Without rclpy the user reads how to get it."""
    def fail(argv):
        raise ModuleNotFoundError("No module named 'rclpy'", name='rclpy')

    program.simulation = fail
    assert door.start_program('simulation', []) == 1
    message = capsys.readouterr().err
    assert "'rclpy'" in message
    assert 'make env' in message
    assert "'armsim_ros[ros]'" in message


@pytest.mark.parametrize(('name', 'value'), [('platform', 'darwin'), ('version_info', (3, 14, 1))])
def test_a_platform_without_wheels_is_named(program, capsys, monkeypatch, name, value):
    """Where pip cannot install ROS, no pip command is suggested."""
    def fail(argv):
        raise ModuleNotFoundError("No module named 'rclpy'", name='rclpy')

    program.simulation = fail
    monkeypatch.setattr(sys, name, value)
    assert door.start_program('simulation', []) == 1
    message = capsys.readouterr().err
    assert 'only for Linux on x86_64 with Python 3.10 to 3.13; use such a machine' in message
    assert 'pip install' not in message


def test_a_missing_system_library_is_named_with_the_package(program, capsys):
    """Pinocchio's wheel needs OpenMP's library, which small systems lack."""
    def fail(argv):
        raise ImportError('libgomp.so.1: cannot open shared object file: No such file')

    program.simulation = fail
    assert door.start_program('simulation', []) == 1
    assert capsys.readouterr().err == (
        "simulation: the system library 'libgomp.so.1' is missing; install it (Debian, Ubuntu: "
        'apt install libgomp1)\n')


def test_a_log_that_cannot_be_written_is_told_with_the_remedy(program, capsys):
    """Where ROS can make no folder for its log, as in a container without a home."""
    def fail(argv):
        raise RuntimeError("failed: Failed to create log directory '/x/log': 2, at a.cpp:154")

    program.simulation = fail
    assert door.start_program('simulation', []) == 2
    message = capsys.readouterr().err
    assert "'/x/log'" in message
    assert 'ROS_LOG_DIR' in message
    assert 'cpp' not in message


def test_a_locale_without_a_character_stops_no_output(program, monkeypatch):
    """What the terminal cannot show is a question mark."""
    shown = BytesIO()
    monkeypatch.setattr(sys, 'stdout', TextIOWrapper(shown, encoding='ascii'))

    def degrees(argv):
        print('30°', flush=True)
        return 0

    program.simulation = degrees
    assert door.start_program('simulation', []) == 0
    assert shown.getvalue() == b'30?\n'


def test_a_missing_module_of_ours_is_no_mistake_of_the_user(program):
    """A fault in this package keeps its traceback."""
    def fail(argv):
        raise ModuleNotFoundError('no', name='armsim_ros.lost')

    program.simulation = fail
    with pytest.raises(ModuleNotFoundError):
        door.start_program('simulation', [])


def test_an_interrupted_program_leaves_no_traceback(program, capsys):
    """Ctrl-C in a program that does not handle it ends with the shell's status for that."""
    def fail(argv):
        raise KeyboardInterrupt

    program.simulation = fail
    assert door.start_program('simulation', []) == 130
    assert capsys.readouterr().err == ''


def test_the_module_runs_as_the_command():
    """``python -m armsim_ros`` is the command."""
    done = subprocess.run([sys.executable, '-m', 'armsim_ros', 'bringup', 'robt:=x'],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "bringup: unknown argument 'robt:=x'; did you mean 'robot'?\n"


def test_the_working_folder_hides_no_package(tmp_path):
    """A user's own ``numpy.py`` is not what the program imports."""
    (tmp_path / 'numpy.py').write_text("raise SystemExit('the wrong numpy')")
    done = subprocess.run([sys.executable, '-m', 'armsim_ros', 'check_config', 'sunday'],
                          capture_output=True, text=True, check=False, cwd=tmp_path,
                          env=child_environment())
    assert 'the wrong numpy' not in done.stderr
    assert (done.returncode, done.stderr) == (0, '')


def test_the_own_prefix_is_the_last_to_be_searched(tmp_path, monkeypatch):
    """What the user sourced is found first, what pip installed is found too."""
    (tmp_path / 'share/ament_index/resource_index/packages').mkdir(parents=True)
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    environment = {'AMENT_PREFIX_PATH': '/opt/ros/jazzy'}
    add_own_prefix(environment)
    add_own_prefix(environment)
    assert environment['AMENT_PREFIX_PATH'].split(os.pathsep) == ['/opt/ros/jazzy', str(tmp_path)]


def test_a_prefix_without_packages_is_not_searched(monkeypatch):
    """The system's Python beside a sourced ROS has nothing to add."""
    monkeypatch.setattr(sys, 'prefix', str(Path('/nowhere')))
    environment = {'AMENT_PREFIX_PATH': '/opt/ros/jazzy'}
    add_own_prefix(environment)
    assert environment == {'AMENT_PREFIX_PATH': '/opt/ros/jazzy'}


def test_nodes_announce_themselves_often():
    """Fast DDS reads our settings, which lie in the package."""
    environment = {}
    announce_often(environment)
    text = Path(environment['FASTRTPS_DEFAULT_PROFILES_FILE']).read_text(encoding='utf-8')
    assert '<leaseAnnouncement>' in text
    assert environment['FASTDDS_BUILTIN_TRANSPORTS'] == 'UDPv4'


def test_transports_of_the_user_stay():
    """Who chooses how Fast DDS sends still gets our settings."""
    environment = {'FASTDDS_BUILTIN_TRANSPORTS': 'LARGE_DATA'}
    announce_often(environment)
    assert environment['FASTDDS_BUILTIN_TRANSPORTS'] == 'LARGE_DATA'
    assert environment['FASTRTPS_DEFAULT_PROFILES_FILE']


@pytest.mark.parametrize('name', [
    'FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'])
def test_settings_of_the_user_stay_alone(name):
    """A user's own profiles are not replaced."""
    environment = {name: '/own.xml'}
    announce_often(environment)
    assert environment == {name: '/own.xml'}


def test_settings_in_the_working_folder_stay_alone(tmp_path, monkeypatch):
    """A file that Fast DDS finds by itself is not overruled."""
    (tmp_path / 'DEFAULT_FASTRTPS_PROFILES.xml').write_text('<dds/>')
    monkeypatch.chdir(tmp_path)
    environment = {}
    announce_often(environment)
    assert environment == {}


def test_a_program_knows_whether_a_bringup_started_it():
    """Only the variable of its own parent counts; one that was inherited says nothing."""
    assert started_by_bringup({'ARMSIM_BRINGUP_PID': str(os.getppid())})
    assert not started_by_bringup({'ARMSIM_BRINGUP_PID': '1'})
    assert not started_by_bringup({})


def test_logs_go_to_a_temporary_folder_without_a_home(tmp_path, monkeypatch):
    """Where ~/.ros/log cannot be made, and only there, ROS_LOG_DIR is set and reported."""
    monkeypatch.setattr('armsim_ros.cli.environment.gettempdir', lambda: str(tmp_path))
    (tmp_path / 'file').touch()
    environment = {'HOME': str(tmp_path / 'file')}
    report = ensure_log_folder(environment)
    folder = Path(environment['ROS_LOG_DIR'])
    assert folder.is_dir()
    assert folder.is_relative_to(tmp_path)
    assert str(folder) in report
    assert ensure_log_folder(environment) == ''
    assert ensure_log_folder({'HOME': str(tmp_path)}) == ''
    assert ensure_log_folder({'HOME': '/proc/none', 'ROS_LOG_DIR': '/proc/none'}) == ''
