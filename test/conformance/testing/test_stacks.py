# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What programs are started for a test."""

import json

from armsim_ros.testing.stacks import ArmRequest


def test_programs_get_what_the_marker_gives():
    """Robot, world, seed and settings are arguments of bringup; faults need their injection."""
    robot, world, seed, settings = ArmRequest(
        robot='bot', world='empty', seed=5, faults={'joint1': {'lag': 0.1}},
        overrides={'simulation.paused': True}).arguments
    assert (robot, world, seed) == ('robot:=bot', 'world:=empty', 'seed:=5')
    assert json.loads(settings.removeprefix('overrides:=')) == {
        'simulation.fault_injection': True, 'simulation.paused': True}


def test_a_negative_seed_is_left_to_the_files():
    """As in the planner's parameters; bringup takes no negative seed."""
    assert ArmRequest(seed=-1).arguments == ('robot:=sunday',)
