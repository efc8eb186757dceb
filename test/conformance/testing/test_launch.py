# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A running arm in a launch description."""

import signal

import pytest

from armsim_ros.testing.program import DOMAINS, private_domain, start_program

statement = pytest.mark.statement

LAUNCH = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo

from armsim_ros.testing.launch import bringup


def generate_launch_description():
    look = ExecuteProcess(cmd=['sh', '-c', 'echo looks in $ROS_DOMAIN_ID'], output='screen')
    return LaunchDescription([
        bringup('robot:=sunday'{more}, on_ready=[LogInfo(msg='arm is ready'), look])])
"""


@pytest.fixture
def launched(tmp_path):
    """Return a function that launches a file with an arm, and ends all of it in the end."""
    with private_domain() as domain:
        programs = []

        def launch(more=''):
            path = tmp_path / 'arm.launch.py'
            path.write_text(LAUNCH.replace('{more}', more))
            programs.append(start_program('launch', domain, str(path)))
            return programs[-1], domain

        yield launch
        for program in programs:
            program.stop(20.0)


@statement('G9')
def test_what_waits_for_the_arm_runs_when_it_can_plan(launched):
    """on_ready is done after move_group says so, in a domain that is leased and told to all."""
    program, outer = launched()
    program.wait_for_line('arm is ready', 90.0)
    assert 'You can start planning now!' in program.text
    line = program.wait_for_line(r'looks in \d+', 20.0)
    inner = int(line.rpartition(' ')[2])
    assert inner in DOMAINS
    assert inner != outer
    program.signal(signal.SIGINT)
    assert program.wait(30.0) == 0


@statement('G9')
def test_an_arm_that_cannot_come_up_ends_the_launch(launched):
    """Where bringup refuses its arguments the launch ends instead of waiting for a ready arm."""
    program, _ = launched(", 'world:=nowhere'")
    program.wait(90.0)
    assert 'arm is ready' not in program.text
    assert "'nowhere'" in program.text
