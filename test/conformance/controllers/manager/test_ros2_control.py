# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The verbs of ``ros2 control``, as launch files execute them, by ros2controlcli's verbs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
import sys

from controller_bench import Bench
import pytest

from armsim_ros.testing.program import Program, ros_environment

YAML = """
/**/by_verb:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [axis_1]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
"""
SOURCES = Path(__file__).parents[4] / 'ros2'
Verb = Callable[..., tuple[int, str]]


@pytest.fixture
def verb(bench: Bench) -> Iterator[Verb]:
    """Give a function that runs a verb and returns status and output; what it loaded is gone."""
    before = bench.manager.states()

    def run(*words: str) -> tuple[int, str]:
        command = [sys.executable, '-m', 'armsim_ros2', 'control', *words,
                   '-c', bench.name('controller_manager')]
        environment = ros_environment(bench.domain) | {'PYTHONPATH': str(SOURCES)}
        with Program(command, environment=environment) as program:
            return program.wait(60.0), program.text

    yield run
    for name, state in bench.manager.states().items():
        if name not in before:
            if state == 'active':
                assert bench.manager.switch(deactivate=[name]).ok
            assert bench.manager.unload(name)


def test_load_controller_into_a_state(bench: Bench, verb: Verb, tmp_path: Path) -> None:
    """load_controller NAME FILE --set-state active loads, configures and activates (main)."""
    bench.activate()
    file = tmp_path / 'controllers.yaml'
    file.write_text(YAML)
    status, text = verb('load_controller', '--set-state', 'active', 'by_verb', str(file))
    assert status == 0, text
    assert 'Successfully loaded controller by_verb into state active' in text
    assert bench.manager.states()['by_verb'] == 'active'
    assert verb('set_controller_state', 'by_verb', 'inactive')[0] == 0
    assert bench.manager.states()['by_verb'] == 'inactive'
    assert verb('switch_controllers', '--activate', 'by_verb', '--strict')[0] == 0
    assert bench.manager.states()['by_verb'] == 'active'


def test_a_refusal_is_told(verb: Verb) -> None:
    """An unknown controller is named, and the status is 1."""
    status, text = verb('set_controller_state', 'nobody', 'active')
    assert status == 1
    assert 'controller nobody does not seem to be loaded' in text
