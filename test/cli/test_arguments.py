# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments that all programs share."""

import pytest

from armsim_ros.cli.arguments import (
    argument_table,
    format_help,
    parse_arguments,
    ProgramArguments,
    split_ros_args,
    UsageError,
)


@pytest.mark.parametrize('words', [
    ['robot:=gantry', 'paused:=true'],
    ['--robot', 'gantry', '--paused'],
    ['--robot=gantry', '--paused=yes'],
    ['--robot:=gantry', '--paused', 'on'],
])
def test_launch_style_and_option_style_say_the_same(words):
    """Both ways to write an argument give the same value."""
    assert parse_arguments(words) == ProgramArguments(robot='gantry', paused=True)


def test_an_empty_command_line_gives_the_defaults():
    """Nothing has to be given."""
    assert parse_arguments([]) == ProgramArguments()


def test_the_last_of_several_values_wins():
    """A wrapper's value can be overruled by appending another one."""
    assert parse_arguments(['robot:=a', '--robot', 'b']).robot == 'b'


def test_a_value_may_contain_the_sign():
    """Only the first := parts name and value."""
    assert parse_arguments(['world:=a:=b']).world == 'a:=b'


def test_a_dash_in_an_option_stands_for_an_underscore():
    """--use-sim-time is --use_sim_time."""
    assert parse_arguments(['--use-sim-time', 'false']).use_sim_time is False


def test_a_flag_does_not_swallow_the_next_argument():
    """--paused robot:=x switches the flag on and leaves the next word alone."""
    assert parse_arguments(['--paused', 'robot:=x']) == ProgramArguments(robot='x', paused=True)


@pytest.mark.parametrize(('word', 'said'), [
    ('robt:=x', "'robot'"),
    ('--wrold=x', "'world'"),
    ('zzz:=1', 'known: robot, config'),
    ('sunday', 'name:=value'),
    ('paused:=perhaps', 'true, false'),
    ('--urdf', 'urdf:=FILE'),
])
def test_a_wrong_word_is_answered_with_the_right_ones(word, said):
    """One message names what was given and what is allowed."""
    with pytest.raises(UsageError) as caught:
        parse_arguments([word])
    assert said in str(caught.value)
    assert '\n' not in str(caught.value)


def test_ros_arguments_pass_through_in_sections():
    """Everything from --ros-args to -- is ROS's, as often as it comes."""
    own, ros = split_ros_args(
        ['a', '--ros-args', '-r', '__ns:=/x', '--', 'b', '--ros-args', '-p', 'c:=1'])
    assert own == ['a', 'b']
    assert ros == ('--ros-args', '-r', '__ns:=/x', '--', '--ros-args', '-p', 'c:=1', '--')


def test_arguments_survive_the_way_to_a_child():
    """What to_argv writes, parse_arguments reads back as it was."""
    given = parse_arguments(['robot:=/a b/c', 'paused:=1', 'namespace:=/left', 'world:=',
                             '--ros-args', '-p', 'x:=1'])
    assert parse_arguments(given.to_argv()) == given


def test_the_help_describes_every_argument():
    """--help lists each name with its description and default."""
    text = format_help('bringup', 'start all')
    for entry in argument_table():
        assert f'{entry.name}:=' in text
        assert entry.metadata['description'] in text
    assert '(default: sunday)' in text
