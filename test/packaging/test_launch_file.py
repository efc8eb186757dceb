# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The structure of the launch file, against stand-ins for launch, which pip cannot install."""

from pathlib import Path
from runpy import run_path
import sys
from types import ModuleType

import pytest

from armsim_ros.cli.arguments import argument_table, parse_arguments, ProgramArguments

LAUNCH_FILE = Path(__file__).parent.parent.parent / 'launch' / 'bringup.launch.py'
NAMES = {
    'launch': ['LaunchDescription'],
    'launch.actions': ['DeclareLaunchArgument', 'EmitEvent', 'ExecuteProcess',
                       'RegisterEventHandler'],
    'launch.event_handlers': ['OnProcessExit'],
    'launch.events': ['Shutdown'],
    'launch.substitutions': ['LaunchConfiguration', 'PathJoinSubstitution'],
    'launch_ros': [],
    'launch_ros.substitutions': ['FindPackagePrefix'],
}


class Recorded:
    """Keeps what it was made with."""

    def __init__(self, *words, **options):
        self.words = words
        self.options = options


@pytest.fixture
def description(monkeypatch):
    """Return the launch description."""
    for name, classes in NAMES.items():
        module = ModuleType(name)
        for entry in classes:
            setattr(module, entry, type(entry, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    return run_path(str(LAUNCH_FILE))['generate_launch_description']().words[0]


def of_kind(description, kind):
    """Return the actions of one class."""
    return [action for action in description if type(action).__name__ == kind]


def test_every_argument_is_declared_and_described(description):
    """``ros2 launch -s`` shows what --help shows."""
    declared = {action.words[0]: action.options['description']
                for action in of_kind(description, 'DeclareLaunchArgument')}
    assert declared == {entry.name: entry.metadata['description'] for entry in argument_table()}


def test_the_defaults_reach_the_program_as_they_are(description):
    """Launched without arguments, bringup gets its own defaults."""
    defaults = {action.words[0]: action.options['default_value']
                for action in of_kind(description, 'DeclareLaunchArgument')}
    (process,) = of_kind(description, 'ExecuteProcess')
    words = [prefix + defaults[value.words[0]] for prefix, value in process.options['cmd'][1:]]
    assert parse_arguments(words) == ProgramArguments()


def test_the_end_of_bringup_is_the_end_of_the_launch(description):
    """No empty launch stays behind."""
    (handler,) = of_kind(description, 'RegisterEventHandler')
    (process,) = of_kind(description, 'ExecuteProcess')
    assert handler.words[0].options['target_action'] is process
