# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A running arm in a launch description."""

import signal

import pytest

from armsim_ros.launch.lookup import make_lookup
from armsim_ros.launch.names import importable
from armsim_ros.testing.launch import bringup
from armsim_ros.testing.program import DOMAINS, private_domain, start_program

statement = pytest.mark.statement

DOMAIN = 75

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


@pytest.fixture
def launch_modules():
    """Make the modules of launch files importable."""
    with importable(make_lookup([], [])):
        yield


def sub_entities(entities):
    """Yield entities and those inside them, as the search for ReadyToTest goes through them."""
    for entity in entities:
        yield entity
        yield from sub_entities(entity.describe_sub_entities())
        for _, inside in entity.describe_conditional_sub_entities():
            yield from sub_entities(inside)


@statement('G9')
@pytest.mark.usefixtures('launch_modules')
def test_actions_that_wait_for_the_arm_are_found():
    """launch_testing/loader.py, _normalize_ld; launch_pytest/plugin.py: exactly once."""
    from launch import LaunchDescription
    from launch.actions import LogInfo

    ready = LogInfo(msg='arm is ready')
    description = LaunchDescription([bringup(on_ready=[ready], domain=DOMAIN)])
    assert [each for each in sub_entities(description.entities) if each is ready] == [ready]


@statement('G9')
@pytest.mark.usefixtures('launch_modules')
def test_an_arm_is_ready_when_the_whole_line_is_printed():
    """A line may come in two events; only the bringup's own output counts."""
    from launch.actions import ExecuteProcess, RegisterEventHandler
    from launch.events.process import ProcessIO

    entities = bringup(domain=DOMAIN).entities
    program = next(each for each in entities if isinstance(each, ExecuteProcess))
    ready = next(each for each in entities if isinstance(each, RegisterEventHandler)).event_handler

    def is_ready(text, action=program):
        return ready.matches(ProcessIO(
            action=action, name='it', cmd=[], cwd=None, env=None, pid=1, text=text))

    line = b'You can start planning now!'
    assert not is_ready(line, action=ExecuteProcess(cmd=['true']))
    assert not is_ready(b'something else')
    assert not is_ready(line[:9])
    assert is_ready(line[9:])
