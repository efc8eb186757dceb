# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint velocities of a twist, and what they make of it."""

import pytest
from servo_streams import twist


def test_progress_is_the_share_of_the_twist_and_the_speed_along_its_way(streamer):
    """A turn beside the way does not count as length of the way."""
    made = streamer(command_in_type='speed_units')
    target, parameters = made.stream.target, made.parameters
    command = twist((0.03, 0.0, 0.04), (0.1, 0.0, 0.0), frame=target.base)
    velocity = target.wanted(command, made.q, parameters).velocity
    assert target.progress(command, made.q, velocity, parameters) == pytest.approx(
        (1.0, 0.05), rel=0.01)
    assert target.progress(command, made.q, 0.5 * velocity, parameters) == pytest.approx(
        (0.5, 0.025), rel=0.01)
