# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The spawner's and unspawner's command line against the real simulation."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import GripperCommand, ParallelGripperCommand
from control_msgs.msg import GripperCommand as GripperCommandMessage
import pytest
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ControllerManagerClient, ParameterClient
from armsim_ros.testing.program import Program, start_program

MANAGER = '/sunday/controller_manager'
ARM = 'arm_joint_controller'
JOINTS = [f'joint_{i}' for i in range(1, 7)]
ROS2_FILE = """
/sunday/second_controller:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [joint_1, joint_2]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    constraints.goal_time: 2.5
"""
ROS1_FILE = """
sunday:
  second_controller:
    type: position_controllers/JointTrajectoryController
    joints: [joint_1, joint_2]
"""

Run = Callable[..., tuple[int, str]]


@pytest.fixture(scope='module')
def manager(simulation: Program, client: ClientNode) -> ControllerManagerClient:
    """Give a client of the manager."""
    return ControllerManagerClient(client, MANAGER)


@pytest.fixture
def run(simulation: Program, ros_domain: int) -> Run:
    """Give a function that runs a program to its end and returns status and output."""

    def run_program(program: str, *words: str) -> tuple[int, str]:
        with start_program(program, ros_domain, *words, '-c', MANAGER) as process:
            return process.wait(30.0), process.text

    return run_program


@pytest.fixture
def free_arm(manager: ControllerManagerClient) -> Iterator[None]:
    """Let the arm's own controller rest meanwhile."""
    assert manager.switch(deactivate=[ARM]).ok
    yield
    for name, state in manager.states().items():
        if name in ('second_controller', 'parallel_gripper'):
            if state == 'active':
                assert manager.switch(deactivate=[name]).ok
            assert manager.unload(name)
    assert manager.switch(activate=[ARM]).ok


@pytest.mark.usefixtures('free_arm')
def test_a_controller_from_a_ros2_file(
    run: Run, manager: ControllerManagerClient, client: ClientNode, tmp_path: Path
) -> None:
    """P11: loaded, configured and activated with the file's type and parameters; then gone."""
    file = tmp_path / 'controllers.yaml'
    file.write_text(ROS2_FILE)
    status, text = run('spawner', 'second_controller', '-p', str(file))
    assert status == 0, text
    assert manager.states()['second_controller'] == 'active'
    parameters = ParameterClient(client, '/sunday/second_controller')
    assert parameters.get('constraints.goal_time') == 2.5
    status, text = run('unspawner', 'second_controller')
    assert status == 0, text
    assert 'second_controller' not in manager.states()


@pytest.mark.usefixtures('free_arm')
def test_a_controller_from_a_ros1_file_left_inactive(
    run: Run, manager: ControllerManagerClient, tmp_path: Path
) -> None:
    """P11, P13: --inactive configures only; a second run says that it is loaded and goes on."""
    file = tmp_path / 'controllers.yaml'
    file.write_text(ROS1_FILE)
    status, text = run('spawner', 'second_controller', '--inactive', '-p', str(file))
    assert status == 0, text
    assert manager.states()['second_controller'] == 'inactive'
    status, text = run('spawner', 'second_controller')
    assert status == 0, text
    assert 'loaded already' in text
    assert manager.states()['second_controller'] == 'active'


GRIPPER_FILE = """
/**/{name}:
  ros__parameters:
    type: {kind}
    joint: joint_6
"""


def spawned_gripper(run: Run, folder: Path, name: str, kind: str) -> str:
    """Spawn a gripper's controller from a file of its own and return its action."""
    file = folder / 'gripper.yaml'
    file.write_text(GRIPPER_FILE.format(name=name, kind=kind))
    status, text = run('spawner', name, '-p', str(file))
    assert status == 0, text
    return f'/sunday/{name}/gripper_cmd'


@pytest.mark.usefixtures('free_arm')
def test_a_gripper_moves_its_joint(
    run: Run, manager: ControllerManagerClient, client: ClientNode, tmp_path: Path
) -> None:
    """N1, N3: GripperCommand moves the joint and reports that the goal was reached."""
    kind = 'position_controllers/GripperActionController'
    action = spawned_gripper(run, tmp_path, 'second_controller', kind)
    command = GripperCommand.Goal(command=GripperCommandMessage(position=0.05))
    response = act(client, action, GripperCommand, command)
    assert response.status == GoalStatus.STATUS_SUCCEEDED
    assert response.result.reached_goal
    assert response.result.position == pytest.approx(0.05, abs=0.01)


@pytest.mark.usefixtures('free_arm')
def test_a_parallel_gripper_moves_its_joint(
    run: Run, manager: ControllerManagerClient, client: ClientNode, tmp_path: Path
) -> None:
    """N2, N3: ParallelGripperCommand takes exactly one position."""
    kind = 'parallel_gripper_action_controller/GripperActionController'
    action = spawned_gripper(run, tmp_path, 'parallel_gripper', kind)
    command = ParallelGripperCommand.Goal(command=JointState(position=[0.0]))
    response = act(client, action, ParallelGripperCommand, command)
    assert response.status == GoalStatus.STATUS_SUCCEEDED
    assert list(response.result.state.name) == ['joint_6']
    two = ParallelGripperCommand.Goal(command=JointState(position=[0.0, 1.0]))
    assert act(client, action, ParallelGripperCommand, two) is None


def act(client: ClientNode, action: str, kind: type, goal: Any) -> Any:
    """Return the result of a goal, None where it is rejected."""
    sender = ActionClient(client.node, kind, action)
    assert sender.wait_for_server(10.0)
    handle = client.result(client.in_executor(lambda: sender.send_goal_async(goal)))
    if not handle.accepted:
        return None
    return client.result(client.in_executor(handle.get_result_async))


@pytest.fixture(scope='module')
def refused(simulation: Program, ros_domain: int,
            tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Program]]:
    """Run spawners at once, each of which has another mistake in its words."""
    file = tmp_path_factory.mktemp('bare') / 'controllers.yaml'
    file.write_text(ROS2_FILE.replace('/sunday/second', 'second'))
    words = {
        'unknown': ('nobody', '-c', MANAGER),
        'bare name': ('second_controller', '-p', str(file), '-c', MANAGER),
        'no manager': ('a', '-c', '/nowhere/controller_manager',
                       '--controller-manager-timeout', '0.3'),
    }
    with ExitStack() as stack:
        yield {name: stack.enter_context(start_program('spawner', ros_domain, *given))
               for name, given in words.items()}


def test_a_controller_that_nothing_describes(refused: dict[str, Program]) -> None:
    """P11: exit 1 at the first failure."""
    process = refused['unknown']
    assert process.wait(30.0) == 1
    assert "'nobody' could not be loaded" in process.text
    assert 'Traceback' not in process.text


def test_a_bare_name_in_a_namespace_is_an_error(refused: dict[str, Program]) -> None:
    """P11: with a namespace the key must be /ns/name, /**/name or lie under /**."""
    process = refused['bare name']
    assert process.wait(30.0) == 1
    assert '/**/second_controller' in process.text


def test_no_manager_in_time(refused: dict[str, Program]) -> None:
    """P11: a manager that does not appear in time is an error with status 1."""
    process = refused['no manager']
    assert process.wait(30.0) == 1
    assert '/nowhere/controller_manager' in process.text
    assert 'Traceback' not in process.text


def test_a_joint_that_is_claimed_already(run: Run, manager: ControllerManagerClient,
                                         tmp_path: Path) -> None:
    """P4: activation fails with the reason; the other controller stays active."""
    file = tmp_path / 'controllers.yaml'
    file.write_text(ROS2_FILE)
    status, text = run('spawner', 'second_controller', '-p', str(file))
    assert status == 1
    assert ARM in text
    assert manager.states()[ARM] == 'active'
    assert manager.unload('second_controller')
