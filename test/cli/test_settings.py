# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the arguments of a program change of a robot's settings."""

import pytest

from armsim_ros.cli.arguments import parse_arguments, UsageError
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


@pytest.mark.parametrize(('name', 'words'), [
    ('', 'is a folder'), ('there/run.mcap', "there' is a file; name a file in a folder"),
])
def test_a_recording_that_could_not_be_written_is_refused(tmp_path, name, words):
    """The run would be over before anyone noticed."""
    (tmp_path / 'there').touch()
    with pytest.raises(UsageError, match=words):
        cell_of(parse_arguments([f'record:={tmp_path}/{name}']))


def test_the_folder_of_a_recording_may_come_later(tmp_path):
    """It is made when the recording is written."""
    cell, _ = cell_of(parse_arguments([f'record:={tmp_path}/new/run.mcap']))
    assert cell.settings.simulation.recorder.file == f'{tmp_path}/new/run.mcap'
