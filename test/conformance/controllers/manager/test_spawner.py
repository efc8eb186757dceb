# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The spawner's command line: flags, exit codes, files of ROS 2 and of ROS 1."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import shlex
import signal

from controller_bench import Bench, BROADCASTER
import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.testing.program import Program, ros_environment

statement = pytest.mark.statement
upstream = pytest.mark.upstream

ROS_2 = """
{key}:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [{joint}]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints: {{goal_time: 2.5}}
"""
ROS_1 = """
bench:
  {key}:
    type: position_controllers/JointTrajectoryController
    joints: [{joint}]
    constraints: {{goal_time: 2.5}}
"""
Start = Callable[..., Program]
#: How long a spawner may take [s].
TIMEOUT = 60.0


@dataclass(frozen=True)
class Spawned:
    """
    What a spawner has left behind.

    :param states: controller -> state when it and those beside it had ended.
    :param goal_time: of the first of its controllers, None where it was not loaded [s].
    """

    status: int
    text: str
    states: dict[str, str]
    goal_time: float | None


@contextmanager
def spawners(bench: Bench, command: str) -> Iterator[Start]:
    """Give a function that starts the spawner; what it loaded is gone afterwards."""
    bench.activate()
    before = bench.manager.states()
    programs: list[Program] = []

    manager = ('-c', bench.name('controller_manager'))

    def start_spawner(*words: str) -> Program:
        programs.append(Program(
            [*shlex.split(command), *words, *(() if '-c' in words else manager)],
            environment=ros_environment(bench.domain),
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


def side_by_side(bench: Bench, start: Start, *calls: tuple[str, ...]) -> list[Spawned]:
    """Run spawners at the same time; return what each of them has left behind."""
    programs = [start(*words) for words in calls]
    statuses = [program.wait(TIMEOUT) for program in programs]
    states = bench.manager.states()
    goal_times = [
        ParameterClient(bench.client, bench.name(words[0])).get('constraints.goal_time')
        if words[0] in states else None
        for words in calls
    ]
    return [
        Spawned(status, program.text, states, goal_time)
        for status, program, goal_time in zip(statuses, programs, goal_times, strict=True)
    ]


@pytest.fixture(scope='module')
def command(pytestconfig: pytest.Config) -> str:
    """Return the words that start the spawner."""
    return str(pytestconfig.getoption('spawner_command'))


@pytest.fixture
def start(bench: Bench, command: str) -> Iterator[Start]:
    """Give a function that starts the spawner; what it loaded is gone after the test."""
    with spawners(bench, command) as start_spawner:
        yield start_spawner


@pytest.fixture(scope='module')
def file(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], str]:
    """Give a function that writes a parameter file and returns its path."""

    def write(text: str) -> str:
        path = tmp_path_factory.mktemp('spawner') / 'controllers.yaml'
        path.write_text(text, encoding='utf-8')
        return str(path)

    return write


@pytest.fixture(scope='module')
def of_files(bench: Bench, command: str, file: Callable[[str], str]) -> dict[str, Spawned]:
    """Spawn one controller of each kind of file."""
    texts = {
        'spawned_full': ROS_2.format(key='/bench/spawned_full', joint='axis_1'),
        'spawned_wild': ROS_2.format(key='/**/spawned_wild', joint='axis_2'),
        'spawned_ros_1': ROS_1.format(key='spawned_ros_1', joint='wheel_1'),
        'spawned_ros_args': ROS_2.format(key='/**', joint='wheel_2'),
    }
    with spawners(bench, command) as start:
        calls = [(name, '--ros-args', '--params-file', file(text), '--')
                 if name == 'spawned_ros_args' else (name, '-p', file(text))
                 for name, text in texts.items()]
        return dict(zip(texts, side_by_side(bench, start, *calls), strict=True))


@statement('P11', 'P2', 'C14')
@upstream('spawner_test_type_in_params_file', 'spawner_test_with_wildcard_entries',
          'spawner_forwards_ros_params_file_along_with_param_file',
          'spawner_test_with_wildcard_entries_with_no_ctrl_name')
@pytest.mark.parametrize(
    'name', ['spawned_full', 'spawned_wild', 'spawned_ros_1', 'spawned_ros_args'])
def test_a_controller_of_a_file(of_files: dict[str, Spawned], name: str) -> None:
    """Type and parameters come from the file; the controller is active, the status 0."""
    spawned = of_files[name]
    assert spawned.status == 0, spawned.text
    assert spawned.states[name] == 'active'
    assert spawned.goal_time == 2.5


@pytest.fixture(scope='module')
def in_two_steps(
    bench: Bench, command: str, file: Callable[[str], str]
) -> dict[str, tuple[Spawned, Spawned]]:
    """Spawn controllers half, then with a second call as a whole."""
    flags = {'spawned_unconfigured': '--load-only', 'spawned_inactive': '--inactive'}
    joints = dict(zip(flags, ('axis_1', 'axis_2'), strict=True))
    paths = {name: file(ROS_2.format(key=f'/**/{name}', joint=joints[name])) for name in flags}
    with spawners(bench, command) as start:
        first = side_by_side(
            bench, start, *((name, flag, '-p', paths[name]) for name, flag in flags.items()))
        again = side_by_side(bench, start, *((name, '-p', paths[name]) for name in flags))
    return dict(zip(flags, zip(first, again, strict=True), strict=True))


@statement('P11')
@pytest.mark.parametrize(
    ('flag', 'state'), [('--load-only', 'unconfigured'), ('--inactive', 'inactive')]
)
def test_less_than_active(
    in_two_steps: dict[str, tuple[Spawned, Spawned]], flag: str, state: str
) -> None:
    """--load-only and --inactive stop earlier; a second call warns and goes on from there."""
    name = f'spawned_{state}'
    first, again = in_two_steps[name]
    assert first.status == 0, (flag, first.text)
    assert first.states[name] == state
    assert again.status == 0, again.text
    assert again.states[name] == 'active'
    assert 'loaded already' in again.text or 'already loaded' in again.text


@pytest.fixture(scope='module')
def failures(bench: Bench, command: str, file: Callable[[str], str]) -> dict[str, Spawned]:
    """Run spawners that cannot do what they are asked for."""
    bare = file(ROS_2.format(key='spawned_bare', joint='axis_1'))
    calls = {
        'unknown': ('nobody',),
        'no_file': ('arm', '-p', '/does/not/exist.yaml'),
        'second_unknown': ('arm', 'nobody'),
        'bare': ('spawned_bare', '-p', bare),
        'active': ('--inactive', BROADCASTER),
        'no_manager': (
            'arm', '--controller-manager-timeout', '1.0', '-c', '/nowhere/controller_manager'
        ),
    }
    with spawners(bench, command) as start:
        return dict(zip(calls, side_by_side(bench, start, *calls.values()), strict=True))


@statement('P11')
@upstream('spawner_test_with_params_file_unknown_namespace')
def test_a_bare_name_is_no_key_in_a_namespace(failures: dict[str, Spawned]) -> None:
    """With a namespace the key of the file needs it, or a wildcard: status 1."""
    assert failures['bare'].status == 1, failures['bare'].text
    assert 'spawned_bare' not in failures['bare'].states


@statement('P11')
@pytest.mark.parametrize(
    ('case', 'word'),
    [('unknown', 'nobody'), ('no_file', '/does/not/exist.yaml'), ('second_unknown', 'nobody')],
    ids=['unknown', 'no_file', 'second_unknown'],
)
def test_failures_have_status_1(failures: dict[str, Spawned], case: str, word: str) -> None:
    """A controller that nobody describes, a file that is not there: status 1, and a word on it."""
    assert failures[case].status == 1, failures[case].text
    assert word in failures[case].text


@statement('C15')
def test_an_active_controller_cannot_be_configured(failures: dict[str, Spawned]) -> None:
    """A controller that is active already is an error, as any that cannot be configured."""
    assert failures['active'].status == 1, failures['active'].text
    assert failures['active'].states[BROADCASTER] == 'active'


BROADCASTER_FILE = """
/**/{name}:
  ros__parameters:
    type: joint_state_broadcaster/JointStateBroadcaster
"""


@statement('C11', 'C13')
@upstream('advanced_spawner_multiple_controllers', 'advanced_spawner_parsed_controller_ros_args',
          'test_spawner_parsed_controller_ros_args', 'advanced_spawner_multiple_param_files')
def test_blocks_of_controllers(
    bench: Bench, start: Start, file: Callable[[str], str]
) -> None:
    """
    Each --controller has options of its own; remappings and parameters reach its node.

    spawner.py, parse_args_advanced; controller_manager.cpp, determine_controller_node_options.
    """
    words: list[str] = []
    options = {
        'block_loaded': ('--load-only',), 'block_inactive': ('--inactive',),
        'block_active': ('--controller-ros-args', '-r joint_states:=/elsewhere/joint_states',
                         '--controller-ros-args', '-p frame_id:=elsewhere'),
    }
    for name, own in options.items():
        words += ['--controller', name, '-p', file(BROADCASTER_FILE.format(name=name)), *own]
    program = start(*words)
    assert program.wait(TIMEOUT) == 0, program.text
    states = bench.manager.states()
    assert [states[name] for name in options] == ['unconfigured', 'inactive', 'active']
    elsewhere = bench.client.collect('/elsewhere/joint_states', JointState)
    assert elsewhere.wait(1)[0].header.frame_id == 'elsewhere'
    elsewhere.close()


@statement('C16')
@upstream('spawner_non_exising_hardware_component',
          'set_component_to_configured_state_and_back_to_activated',
          'set_component_to_configured_state_cm_namespace')
def test_hardware_spawner(bench: Bench, command: str) -> None:
    """It goes on after an unknown component; --configure and --activate change the state."""
    bench.activate()
    (component,) = bench.manager.hardware_components().component
    before, _, after = command.rpartition('spawner')
    with spawners(bench, f'{before}hardware_spawner{after}') as start:
        for flag, state in (('--configure', 'inactive'), ('--activate', 'active')):
            program = start('nobody', component.name, flag)
            assert program.wait(TIMEOUT) == 0, program.text
            assert "'nobody'" in program.text
            (found,) = bench.manager.hardware_components().component
            assert found.state.label == state


@statement('P11')
@upstream('spawner_with_no_manager')
def test_without_a_manager(failures: dict[str, Spawned]) -> None:
    """Without a manager it gives up after its timeout with status 1."""
    assert failures['no_manager'].status == 1, failures['no_manager'].text


@statement('P11')
@upstream('spawn_multiple_controllers_as_group')
def test_several_as_a_group(bench: Bench, start: Start) -> None:
    """--activate-as-group activates all in one switch."""
    program = start('arm', 'velocity_drives', '--activate-as-group', '--switch-timeout', '5')
    assert program.wait(TIMEOUT) == 0, program.text
    states = bench.manager.states()
    assert states['arm'] == states['velocity_drives'] == 'active'


@statement('P11', 'P13', 'C15')
@upstream('unload_on_kill', 'unload_on_kill_activate_as_group', 'unload_on_kill_with_sigterm',
          'advanced_spawner_unload_on_kill_only_active')
def test_unload_on_kill(
    bench: Bench, start: Start, file: Callable[[str], str]
) -> None:
    """With -u it stays; at its end what was not spawned inactive is deactivated and unloaded."""
    path = file(ROS_2.format(key='/**', joint='axis_1'))
    program = start('-u', '--controller', 'spawned_lent', '-p', path,
                    '--controller', 'spawned_kept', '-p', path, '--inactive')
    program.wait_for_line('(?i)waiting (for a signal|until interrupt)', TIMEOUT)
    states = bench.manager.states()
    assert (states['spawned_lent'], states['spawned_kept']) == ('active', 'inactive')
    program.signal(signal.SIGINT)
    assert program.wait(TIMEOUT) == 0
    states = bench.manager.states()
    assert 'spawned_lent' not in states
    assert states['spawned_kept'] == 'inactive'


@statement('C15')
def test_a_signal_before_the_manager_is_there(start: Start) -> None:
    """
    Without -u a signal ends it with status 0; before that it names what it waits for.

    Upstream: spawner.py, main; controller_manager_services.py, service_caller.
    """
    program = start('arm', '-c', '/nowhere/controller_manager')
    program.wait_for_line('(?i)waiting for .*/nowhere/controller_manager', TIMEOUT)
    program.signal(signal.SIGINT)
    assert program.wait(TIMEOUT) == 0, program.text
