# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scripted runs of a client that knows rclpy and control_msgs and nothing of ours."""

from __future__ import annotations

from pathlib import Path
import sys

from controller_bench import Bench
from plain_client import SCENARIOS
import pytest

from armsim_ros.testing.program import Program, ros_environment

statement = pytest.mark.statement
STATEMENTS = {
    'success': ('A1', 'H9'),
    'cancel': ('I1',),
    'preempt_by_second_client': ('I3', 'I4'),
    'topic_against_action': ('I8',),
    'path_tolerance': ('H7', 'U4'),
    'goal_tolerance': ('H10', 'U4'),
    'partial_goals': ('B6', 'D13'),
    'deactivation_while_moving': ('C7', 'C8'),
    'burst': ('I10', 'I11', 'D8'),
}


@pytest.fixture(scope='module')
def printed(bench: Bench) -> dict[str, str]:
    """Run all scenarios in a process of their own; return what was printed of each."""
    bench.use('plain')
    script = str(Path(__file__).with_name('plain_client.py'))
    words = [bench.name('plain'), bench.name('controller_manager'), 'axis_1', 'axis_2']
    program = Program([sys.executable, script, *words], environment=ros_environment(bench.domain))
    with program:
        program.wait(300.0)
    return {line.split(' ', 1)[1].split(':')[0]: line for line in program.output if ' ' in line}


@pytest.mark.parametrize(
    'scenario', [pytest.param(name, marks=statement(*STATEMENTS[name])) for name in SCENARIOS]
)
def test_a_plain_client(printed: dict[str, str], scenario: str) -> None:
    """A client of rclpy alone runs its script."""
    assert printed.get(scenario) == f'ok {scenario}', '\n'.join(printed.values())
