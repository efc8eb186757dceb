# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The spawner's command line: flags, exit codes, files of ROS 2 and of ROS 1."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
import shlex
import signal

from controller_bench import Bench
import pytest

from armsim_ros.testing.clients.parameter_client import ParameterClient
from armsim_ros.testing.programs.domain import ros_environment
from armsim_ros.testing.programs.program import Program

statement = pytest.mark.statement
upstream = pytest.mark.upstream

ROS_2 = """
{key}:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [axis_1, axis_2]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints: {{goal_time: 2.5}}
"""
ROS_1 = """
bench:
  {key}:
    type: position_controllers/JointTrajectoryController
    joints: [axis_1, axis_2]
    constraints: {{goal_time: 2.5}}
"""
Start = Callable[..., Program]


@pytest.fixture
def start(bench: Bench, pytestconfig: pytest.Config) -> Iterator[Start]:
    """Give a function that starts the spawner; what it loaded is gone after the test."""
    bench.activate()
    before = bench.manager.states()
    command = shlex.split(pytestconfig.getoption('spawner_command'))
    programs: list[Program] = []

    def start_spawner(*words: str, manager: str = bench.name('controller_manager')) -> Program:
        programs.append(Program(
            [*command, *words, '-c', manager], environment=ros_environment(bench.domain)
        ))
        return programs[-1]

    yield start_spawner
    for program in programs:
        program.stop()
    for name, state in bench.manager.states().items():
        if name not in before:
            if state == 'active':
                assert bench.manager.switch(deactivate=[name]).ok
            assert bench.manager.unload(name)


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str], str]:
    """Give a function that writes a parameter file and returns its path."""

    def write(text: str) -> str:
        path = tmp_path / 'controllers.yaml'
        path.write_text(text, encoding='utf-8')
        return str(path)

    return write


@statement('P11', 'P2')
@upstream('spawner_test_type_in_params_file', 'spawner_test_with_wildcard_entries')
@pytest.mark.parametrize(
    ('name', 'text'),
    [('spawned_full', ROS_2.format(key='/bench/spawned_full')),
     ('spawned_wild', ROS_2.format(key='/**/spawned_wild')),
     ('spawned_ros_1', ROS_1.format(key='spawned_ros_1'))],
)
def test_a_controller_of_a_file(
    bench: Bench, start: Start, file: Callable[[str], str], name: str, text: str
) -> None:
    """Type and parameters come from the file; the controller is active, the status 0."""
    program = start(name, '-p', file(text))
    assert program.wait(30.0) == 0, program.text
    assert bench.manager.states()[name] == 'active'
    assert ParameterClient(bench.client, bench.name(name)).get('constraints.goal_time') == 2.5


@statement('P11')
@pytest.mark.parametrize(
    ('flag', 'state'), [('--load-only', 'unconfigured'), ('--inactive', 'inactive')]
)
def test_less_than_active(
    bench: Bench, start: Start, file: Callable[[str], str], flag: str, state: str
) -> None:
    """--load-only and --inactive stop earlier; a second call warns and goes on from there."""
    name = f'spawned_{state}'
    path = file(ROS_2.format(key=f'/**/{name}'))
    program = start(name, flag, '-p', path)
    assert program.wait(30.0) == 0, program.text
    assert bench.manager.states()[name] == state
    again = start(name, '-p', path)
    assert again.wait(30.0) == 0, again.text
    assert bench.manager.states()[name] == 'active'
    assert 'loaded already' in again.text or 'already loaded' in again.text


@statement('P11')
@upstream('spawner_test_with_params_file_unknown_namespace')
def test_a_bare_name_is_no_key_in_a_namespace(
    bench: Bench, start: Start, file: Callable[[str], str]
) -> None:
    """With a namespace the key of the file needs it, or a wildcard: status 1."""
    program = start('spawned_bare', '-p', file(ROS_2.format(key='spawned_bare')))
    assert program.wait(30.0) == 1, program.text
    assert 'spawned_bare' not in bench.manager.states()


@statement('P11')
@pytest.mark.parametrize(
    'words',
    [('nobody',), ('arm', '-p', '/does/not/exist.yaml'), ('arm', 'nobody')],
    ids=['unknown', 'no_file', 'second_unknown'],
)
def test_failures_have_status_1(bench: Bench, start: Start, words: tuple[str, ...]) -> None:
    """A controller that nobody describes, a file that is not there: status 1, and a word on it."""
    program = start(*words)
    assert program.wait(30.0) == 1, program.text
    assert words[-1] in program.text


@statement('P11')
@upstream('spawner_with_no_manager')
def test_without_a_manager(start: Start) -> None:
    """Without a manager it gives up after its timeout with status 1."""
    program = start(
        'arm', '--controller-manager-timeout', '1.0', manager='/nowhere/controller_manager'
    )
    assert program.wait(30.0) == 1, program.text


@statement('P11')
@upstream('spawn_multiple_controllers_as_group')
def test_several_as_a_group(bench: Bench, start: Start) -> None:
    """--activate-as-group activates all in one switch."""
    program = start('arm', 'velocity_drives', '--activate-as-group', '--switch-timeout', '5')
    assert program.wait(30.0) == 0, program.text
    states = bench.manager.states()
    assert states['arm'] == states['velocity_drives'] == 'active'


@statement('P11', 'P13')
@upstream('unload_on_kill', 'unload_on_kill_activate_as_group')
def test_unload_on_kill(
    bench: Bench, start: Start, file: Callable[[str], str]
) -> None:
    """With -u it stays; at its end the controller is deactivated and unloaded."""
    program = start('spawned_lent', '-u', '-p', file(ROS_2.format(key='/**/spawned_lent')))
    program.wait_for_line('(?i)wait', 30.0)
    assert bench.manager.states()['spawned_lent'] == 'active'
    program.signal(signal.SIGINT)
    program.wait(15.0)
    assert 'spawned_lent' not in bench.manager.states()
