# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the arguments of a program change of a robot's settings."""

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.settings import cell_of


def test_flags_are_off_unless_given():
    """The files decide where nothing is said."""
    settings = cell_of(parse_arguments([]))[0].settings
    assert not settings.simulation.paused
    assert settings.planning_parameters.scene_from_world == 'live'


def test_flags():
    """They reach the settings of the simulation and of planning."""
    words = ['paused:=true', 'scene_from_world:=true']
    settings = cell_of(parse_arguments(words))[0].settings
    assert settings.simulation.paused
    assert settings.planning_parameters.scene_from_world == 'fixed'
