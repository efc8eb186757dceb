# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments of static_transform_publisher."""

import pytest

from armsim_ros.nodes.upstream.main import main
from armsim_ros.nodes.upstream.static_transform_publisher import read_transform

FRAMES = ['--frame-id', 'map', '--child-frame-id', 'odom']


@pytest.mark.parametrize(('words', 'text'), [
    (['--roll', '1', '--qz', '1', *FRAMES], 'Cannot specify both quaternion and Euler'),
    (['--frame-id', 'map', '--child-frame-id', 'map'], 'child_frame_id cannot equal frame_id'),
    (['1', '2', '3', '0', '0', '0', 'map', 'map'], 'child_frame_id cannot equal frame_id'),
    (['--yaw', 'x', *FRAMES], "'x' is not a number"),
    (['--yaw', '1', '--frame-id', 'map'], 'the two frames are needed')])
def test_what_describes_no_transform_is_refused(capsys, words, text):
    """Re-enacts static_transform_broadcaster_program.cpp, parse_args and main: status 1."""
    assert main(['static_transform_publisher', *words]) == 1
    assert text in capsys.readouterr().err


@pytest.mark.parametrize('words', [['--yaw', '3.141592653589793', *FRAMES],
                                   ['--qz', '1', '--qw', '0', *FRAMES],
                                   ['0', '0', '0', '0', '0', '1', '0', 'map', 'odom']])
def test_a_rotation_has_one_of_two_forms(words):
    """Re-enacts static_transform_broadcaster_program.cpp, parse_args."""
    rotation = read_transform(words).transform.rotation
    assert (abs(rotation.z), rotation.w) == (pytest.approx(1.0), pytest.approx(0.0, abs=1e-9))
