# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation as a process: its start, its end, its refusals."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
import shutil
import signal

import pytest
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import GetSimulationState, SetSimulationState, StepSimulation

from armsim_ros.cli.environment import FASTDDS_PROFILES, FASTDDS_TRANSPORTS
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED, trajectory_message, TrajectoryClient
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.resources import find_robot
from armsim_ros.testing.program import private_domain, Program, ros_environment, start_program

CONTROLLERS = 'trajectory_control.yaml'


@pytest.fixture(scope='module')
def two(ros_domain: int) -> Iterator[dict[str, Program]]:
    """Run two simulations of one domain, each in its namespace, until a later test ends them."""
    with (
        start_program('simulation', ros_domain, 'namespace:=left') as left,
        start_program('simulation', ros_domain, 'namespace:=right') as right,
    ):
        for program in (left, right):
            program.wait_for_line('simulation of .* runs', 60.0)
        yield {'left': left, 'right': right}


@pytest.mark.usefixtures('two')
def test_a_namespace_of_its_own(client: ClientNode) -> None:
    """The controllers live where the argument says."""
    for namespace in ('left', 'right'):
        client.collect(f'/{namespace}/joint_states', JointState).wait(2, timeout=60.0)


@pytest.mark.usefixtures('two')
def test_managers_in_several_namespaces(client: ClientNode) -> None:
    """P8: two robots in one domain; each manager and controller serves its own namespace."""
    names = [f'joint_{i}' for i in range(1, 7)]
    arm = TrajectoryClient(client, '/left/arm_joint_controller')
    goal = arm.send(trajectory_message(names, [(1.0, [0.2] * 6)]))
    assert goal.accepted()
    other = ControllerManagerClient(client, '/right/controller_manager')
    assert other.switch(deactivate=['arm_joint_controller']).ok
    assert goal.result().status == SUCCEEDED
    one = ControllerManagerClient(client, '/left/controller_manager')
    assert one.states()['arm_joint_controller'] == 'active'
    assert other.states()['arm_joint_controller'] == 'inactive'


def test_a_second_one_under_the_same_name_is_refused(
    ros_domain: int, two: dict[str, Program]
) -> None:
    """The second ends with one message; the first goes on."""
    first = two['left']
    with start_program('simulation', ros_domain, 'namespace:=left') as second:
        assert second.wait(15.0) == 2
        assert f'another simulation (pid {first.process.pid})' in second.text
        assert 'ROS_DOMAIN_ID' in second.text
        assert 'Traceback' not in second.text
    assert first.process.poll() is None


def test_a_running_goal_ends_with_the_simulation(
    client: ClientNode, two: dict[str, Program]
) -> None:
    """
    SIGINT aborts the goal, and its client gets the reason before the program ends.

    It leaves within a second, with status 0 and without a traceback.
    """
    program = two['left']
    arm = TrajectoryClient(client, '/left/arm_joint_controller')
    names = [f'joint_{i}' for i in range(1, 7)]
    goal = arm.send(trajectory_message(names, [(20.0, [0.4] * 6)]))
    assert goal.accepted()
    with ThreadPoolExecutor(1) as pool:
        result = pool.submit(goal.result)
        goal.wait_for_feedback(5)
        program.signal(signal.SIGINT)
        assert program.wait(1.0) == 0
    assert 'Traceback' not in program.text
    assert result.result().status == ABORTED
    assert result.result().error_string == 'the simulation is shutting down'


def test_messages_go_through_sockets() -> None:
    """
    No memory is shared; the way to find others decides that too, in rmw_fastrtps.

    Upstream: participant.cpp, create_participant, which adds shared memory for LOCALHOST.
    """
    with private_domain() as domain:
        environment = {
            name: value for name, value in ros_environment(domain).items()
            if name not in (*FASTDDS_PROFILES, FASTDDS_TRANSPORTS[0])}
        environment['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'OFF'
        with Program.module('armsim_ros', 'simulation', environment=environment) as program:
            program.wait_for_line('simulation of .* runs', 60.0)
            maps = Path(f'/proc/{program.process.pid}/maps').read_text()
    assert '/dev/shm/fastrtps' not in maps
    assert 'librmw_fastrtps_cpp' in maps


@pytest.mark.alone  # its second is a promise, which a loaded machine cannot keep
def test_a_signal_ends_it_with_status_0(two: dict[str, Program]) -> None:
    """After SIGTERM a simulation at rest leaves within a second, without a traceback."""
    program = two['right']
    assert program.process.poll() is None
    program.signal(signal.SIGTERM)
    assert program.wait(1.0) == 0
    assert 'Traceback' not in program.text


def test_a_manager_of_that_name_on_the_domain_is_found(
    ros_domain: int, client: ClientNode
) -> None:
    """A stack that no lock shows, such as that of another machine, is seen in the graph."""
    other = Node('controller_manager', namespace='/sunday', context=client.context)
    try:
        with start_program('simulation', ros_domain) as program:
            assert program.wait(15.0) == 2
            assert 'already runs as /sunday/controller_manager' in program.text
            assert 'Traceback' not in program.text
    finally:
        other.destroy_node()


def test_a_paused_start_serves_until_it_is_unpaused() -> None:
    """P5: switches and goals are answered while paused; steps and playing move time."""
    with (
        private_domain() as domain,  # the simulations of other tests publish /clock, too
        start_program('simulation', domain, 'paused:=true') as program,
        ClientNode(domain) as client,
    ):
        program.wait_for_line('simulation of .* runs')
        manager = ControllerManagerClient(client, '/sunday/controller_manager')
        assert manager.switch(deactivate=['arm_joint_controller']).ok
        assert manager.switch(activate=['arm_joint_controller']).ok
        clock = client.collect('/clock', Clock, 10)
        before = ns_from_time(clock.wait(2)[-1].clock)
        assert ns_from_time(clock.wait(4)[-1].clock) == before
        step = StepSimulation.Request(steps=20)
        assert client.call('/step_simulation', StepSimulation, step).result.result == 1
        clock.wait_for(lambda message: ns_from_time(message.clock) == before + 20_000_000)
        names = [f'joint_{i}' for i in range(1, 7)]
        arm = TrajectoryClient(client, '/sunday/arm_joint_controller')
        goal = arm.send(trajectory_message(names, [(0.2, [0.1] * 6)]))
        assert goal.accepted()
        play = SetSimulationState.Request(state=SimulationState(state=1))
        assert client.call('/set_simulation_state', SetSimulationState, play).result.result == 1
        assert goal.result().status == SUCCEEDED
        state = client.call('/get_simulation_state', GetSimulationState)
        assert state.state.state == SimulationState.STATE_PLAYING


@pytest.fixture(scope='module')
def mistaken(
    ros_domain: int, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[dict[str, Program]]:
    """Start simulations at once, each with another mistake in a user's files or words."""
    text = (find_robot('sunday') / CONTROLLERS).read_text()
    texts = {
        'broken': 'sunday:\n  arm: [1, 2\n',
        'type': text.replace('position_controllers/Joint', 'pos_controllers/Joint'),
        'joint': text.replace('- joint_3', '- joint_33').replace(
            'joint_3:   {', 'joint_33:   {'),
    }
    words = {'argument': 'robt:=sunday'}
    for name, changed in texts.items():
        folder = tmp_path_factory.mktemp(name) / 'robot'
        shutil.copytree(find_robot('sunday'), folder)
        (folder / CONTROLLERS).write_text(changed)
        words[name] = f'config:={folder}'
    with ExitStack() as stack:
        yield {name: stack.enter_context(start_program('simulation', ros_domain, word))
               for name, word in words.items()}


def refusal(program: Program) -> str:
    """Expect exit 2 and one message, and return the output."""
    assert program.wait(30.0) == 2, program.text
    assert 'Traceback' not in program.text
    return program.text


def test_broken_yaml(mistaken: dict[str, Program]) -> None:
    """The message names file and line."""
    assert f'{CONTROLLERS}:' in refusal(mistaken['broken'])


def test_an_unknown_controller_type(mistaken: dict[str, Program]) -> None:
    """The robot starts without the controller; a warning names type and place."""
    program = mistaken['type']
    line = program.wait_for_line('pos_controllers/JointTrajectoryController')
    assert f'{CONTROLLERS}:3' in line
    program.wait_for_line('runs; controllers:')
    assert program.stop() == 0


def test_a_joint_that_the_urdf_lacks(mistaken: dict[str, Program]) -> None:
    """The message names the joint, its place, and the nearest joint."""
    text = refusal(mistaken['joint'])
    assert 'joint_33' in text
    assert f'{CONTROLLERS}:7' in text


def test_an_unknown_argument(mistaken: dict[str, Program]) -> None:
    """The message names the right word."""
    assert "did you mean 'robot'?" in refusal(mistaken['argument'])
