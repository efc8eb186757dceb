# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments and parameters of static_transform_publisher."""

import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.upstream.main import main
from armsim_ros.nodes.upstream.static_transform_publisher import (
    DEFAULTS,
    read_words,
    transform_of,
    unique_name,
)

FRAMES = ['--frame-id', 'map', '--child-frame-id', 'odom']


@pytest.mark.parametrize(('words', 'text'), [
    (['--roll', '1', '--qz', '1', *FRAMES], 'Cannot specify both quaternion and Euler'),
    (['--frame-id', 'map', '--child-frame-id', 'map'], 'child_frame_id cannot equal frame_id'),
    (['1', '2', '3', '0', '0', '0', 'map', 'map'], 'child_frame_id cannot equal frame_id'),
    (['--yaw', 'x', *FRAMES], "'x' is not a number"),
    (['--yaw', '1', '--frame-id', 'map'], 'the two frames are needed'),
    ([], 'cannot read 0 words')])
def test_what_describes_no_transform_is_refused(capsys, words, text):
    """Re-enacts static_transform_broadcaster_program.cpp, parse_args and main: status 1."""
    assert main(['static_transform_publisher', *words]) == 1
    assert text in capsys.readouterr().err


@pytest.mark.parametrize('words', [['--yaw', '3.141592653589793', *FRAMES],
                                   ['--qz', '1', '--qw', '0', *FRAMES],
                                   ['0', '0', '0', '0', '0', '1', '0', 'map', 'odom']])
def test_a_rotation_has_one_of_two_forms(words):
    """Re-enacts static_transform_broadcaster_program.cpp, parse_args."""
    rotation = transform_of(read_words(words)).transform.rotation
    assert (abs(rotation.z), rotation.w) == (pytest.approx(1.0), pytest.approx(0.0, abs=1e-9))


def test_the_parameters_of_the_component_have_defaults():
    """static_transform_broadcaster_node.cpp, StaticTransformBroadcasterNode: the identity."""
    made = transform_of({**DEFAULTS, 'translation.y': 2.0, 'child_frame_id': '/panda_link0'})
    assert (made.header.frame_id, made.child_frame_id) == ('/frame', '/panda_link0')
    assert (made.transform.translation.y, made.transform.rotation.w) == (2.0, 1.0)


def test_a_quaternion_is_normalized_and_not_zero():
    """A rotation that tf2 would refuse at each receiver is not published."""
    assert transform_of({**DEFAULTS, 'rotation.w': 2.0}).transform.rotation.w == 1.0
    with pytest.raises(UsageError, match='the quaternion is zero'):
        transform_of({**DEFAULTS, 'rotation.w': 0.0})


@pytest.mark.parametrize(('rule', 'text'), [
    ('translation.x:=1', 'translation.x'), ('frame_id:=/child', 'child_frame_id cannot equal')])
def test_a_wrong_parameter_of_the_component_is_refused(capsys, rule, text):
    """Re-enacts StaticTransformBroadcasterNode: upstream throws, here with the status 1."""
    assert main(['static_transform_broadcaster_node', '--ros-args', '-p', rule]) == 1
    assert text in capsys.readouterr().err


def test_each_publisher_has_a_name_of_its_own():
    """static_transform_broadcaster_node.cpp, get_unique_node_name: 16 random characters."""
    names = {unique_name() for _ in range(100)}
    assert len(names) == 100
    assert {len(name.removeprefix('static_transform_publisher_')) for name in names} == {16}
