# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands, verbs and usage errors of ros2, found without ROS."""

import ast
from pathlib import Path
import subprocess
import sys

import pytest

from armsim_ros2.main import COMMANDS, run

SOURCES = Path(__file__).parent.parent.parent / 'ros2'


@pytest.fixture
def ros2(capsys, monkeypatch):
    """Return a function that runs a command and gives status, output and errors."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)

    def call(line):
        try:
            status = run(line.split())
        except SystemExit as end:  # argparse after help
            status = end.code
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return call


@pytest.mark.parametrize(('line', 'text'), [
    ('topc', "unknown command 'topc'; did you mean 'topic'? (choose from: action, "),
    ('topic lst', "unknown verb 'lst'; did you mean 'list'? (choose from: bw, "),
    ('topic list --nope', 'unrecognized arguments: --nope'),
    ('topic echo', 'the following arguments are required: topic_name'),
    ('topic echo /a --no 1', 'ambiguous option: --no could match --no-arr, --no-str, '),
    ('topic pub /a std_msgs/msg/String -r 0', "'0' is not above 0"),
    ('control set_controller_state arm on', "invalid choice: 'on'"),
    ('interface show --all-comments --no-comments a/msg/B', 'not allowed with argument'),
    ('component list', 'C++ programs of rclcpp_components'),
    ('multicast receive', 'it is part of ros2multicast'),
    ('security list_keys', 'it is part of sros2'),
    ('trace', 'it is part of ros2_tracing'),
    ('test x', 'it is part of ros_testing'),
])
def test_a_usage_error_is_explained(line, text, ros2):
    """The message names what is wrong and what is allowed; the status is argparse's 2."""
    status, out, err = ros2(line)
    assert (status, out) == (2, '')
    assert text in err


@pytest.mark.parametrize(('line', 'text'), [
    ('pkg prefix nope', "Package not found: 'nope'"),
    ('pkg prefix rclyp', "; did you mean 'rclpy'?"),
    ('pkg executables nope', "Package 'nope' not found"),
    ('pkg xml std_msgs -t verion', "XML tag not found: 'verion'; did you mean 'version'?"),
    ('interface show std_msgs/String', "Invalid name 'std_msgs/String'. Expected three parts"),
    ('interface show std_mgs/msg/String', "Unknown package 'std_mgs'; did you mean 'std_msgs'?"),
    ('interface show std_msgs/msg/Strin', 'Could not find the interface'),
    ('interface package nope', "Unknown package 'nope'"),
])
def test_what_does_not_exist_is_named(line, text, ros2):
    """Words and status of ros2pkg and ros2interface."""
    status, out, err = ros2(line)
    assert (status, out) == (1, '')
    assert text in err
    assert err.count('\n') == 1


def test_an_option_may_be_abbreviated(ros2):
    """As upstream, whose parsers are argparse's own (ros2cli/cli.py, main)."""
    whole = ros2('interface show std_srvs/srv/SetBool --no-comments')
    assert ros2('interface show std_srvs/srv/SetBool --no-com') == whole


@pytest.mark.parametrize('command', sorted(COMMANDS))
def test_every_command_has_help(command, ros2):
    """-h of a command and of its verbs prints to standard output, with status 0."""
    from importlib import import_module

    verbs = getattr(import_module(f'armsim_ros2.commands.{command}'), 'VERBS', {})
    if command == 'launch':
        return
    for line in (f'{command} -h', *(f'{command} {verb} -h' for verb in verbs)):
        status, out, err = ros2(line)
        assert (status, err) == (0, ''), line
        assert 'usage: ros2' in out, line


def test_help_and_files_need_no_ros():
    """No command or verb imports rclpy before it runs (spec of the start-up time)."""
    code = ('import sys; from armsim_ros2.main import run\n'
            'for line in "", "-h", "topic -h", "pkg list", "interface list", "topc", '
            '"interface show geometry_msgs/msg/Pose", "topic list --nope":\n'
            '    run(line.split())\n'
            'sys.exit("rclpy" in sys.modules or "numpy" in sys.modules)')
    done = subprocess.run([sys.executable, '-c', code], cwd=SOURCES, capture_output=True,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_packages_are_listed_with_their_files(ros2):
    """Pkg reads the ament index (ros2pkg/verb)."""
    names = ros2('pkg list')[1].split()
    assert names == sorted(names)
    assert {'rclpy', 'std_msgs'} <= set(names)
    assert ros2('pkg prefix std_msgs')[1] == f'{sys.prefix}\n'
    assert ros2('pkg prefix --share std_msgs')[1] == f'{sys.prefix}/share/std_msgs\n'
    assert ros2('pkg xml std_msgs -t name')[1] == 'std_msgs\n'
    assert ros2('pkg xml std_msgs')[1].startswith('<package format=')


def test_a_definition_is_shown_with_its_nested_types(ros2):
    """Tabs, comments and empty lines as ros2interface/verb/show.py prints them."""
    assert ros2('interface show geometry_msgs/msg/PoseStamped')[1] == (
        '# A Pose with reference coordinate frame and timestamp\n\n'
        'std_msgs/Header header\n\tbuiltin_interfaces/Time stamp\n\t\tint32 sec\n'
        '\t\tuint32 nanosec\n\tstring frame_id\nPose pose\n\tPoint position\n\t\tfloat64 x\n'
        '\t\tfloat64 y\n\t\tfloat64 z\n\tQuaternion orientation\n\t\tfloat64 x 0\n'
        '\t\tfloat64 y 0\n\t\tfloat64 z 0\n\t\tfloat64 w 1\n')
    assert ros2('interface show std_srvs/srv/SetBool --no-comments')[1] == (
        'bool data\n---\nbool success\nstring message\n')
    assert '\t# The seconds' in ros2('interface show std_msgs/msg/Header --all-comments')[1]


def test_interfaces_are_listed_by_kind(ros2):
    """Headings and indentation of ros2interface/verb/list.py."""
    out = ros2('interface list')[1]
    titles = [line for line in out.splitlines() if not line.startswith(' ')]
    assert titles == ['Messages:', 'Services:', 'Actions:']
    assert '    std_msgs/msg/String\n' in out
    assert ros2('interface package std_srvs')[1] == (
        'std_srvs/srv/Empty\nstd_srvs/srv/SetBool\nstd_srvs/srv/Trigger\n')
    assert 'std_srvs\n' not in ros2('interface packages -m')[1]
    assert 'std_srvs\n' in ros2('interface packages -s')[1]


def test_no_daemon_is_needed(ros2):
    """Daemon status is upstream's sentence; all three succeed."""
    assert ros2('daemon status') == (0, 'The daemon is not running\n', '')
    assert ros2('daemon start')[0] == ros2('daemon stop')[0] == 0


def test_the_distribution_stands_alone():
    """It imports nothing of armsim_ros; builds copy its settings of Fast DDS from there."""
    for file in SOURCES.rglob('*.py'):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names = [node.module or '']
            assert 'armsim_ros' not in {name.split('.')[0] for name in names}, file
    ours = SOURCES / 'armsim_ros2/fastdds_profiles.xml'
    theirs = SOURCES.parent / 'armsim_ros/cli/fastdds_profiles.xml'
    assert ours.resolve() == theirs
