# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""pymoveit2 as it is on the package index, beside one running arm with a gripper."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
import shlex
import sys
import threading
from typing import Any

import pytest
import rclpy
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

moveit2 = pytest.importorskip('pymoveit2.moveit2', reason='pymoveit2 is not installed')
from arm_user import no_answer_lost, READY, until  # noqa: E402
from faster import FASTER_BUT_CALM  # noqa: E402
from pymoveit2 import MoveIt2, MoveIt2Gripper, RobotDescription  # noqa: E402

from armsim_ros.clients.node import destroy_node  # noqa: E402
from armsim_ros.testing.program import private_domain, Program, ros_environment  # noqa: E402

GRIPPER_ARM = (f'{shlex.quote(sys.executable)} -m armsim_ros bringup robot:=ROBOT '
               f'scene_from_world:=false {shlex.quote(FASTER_BUT_CALM)}')


@dataclass
class Robot:
    """One robot as pymoveit2 sees it."""

    node: Node
    group: ReentrantCallbackGroup
    description: RobotDescription
    remap: list[str]
    program: Program
    clients: dict[str, Any] = field(default_factory=dict)

    def arm(self, **options: Any) -> MoveIt2:
        """Return the client of the arm's planning group with these options."""
        client = self.made(MoveIt2, {**self.description.moveit2_kwargs(), **options})
        client.max_velocity = client.max_acceleration = 0.0
        client.allowed_planning_time = 0.5
        return client

    def gripper(self, kind: type = MoveIt2Gripper, **options: Any) -> Any:
        """Return the client of the gripper with these options."""
        return self.made(kind, {**self.description.moveit2_gripper_kwargs(), **options})

    def made(self, kind: type, options: dict[str, Any]) -> Any:
        """
        Return the client of a kind with these options, the same one every time.

        A client that is destroyed while the executor waits for it can end the executor.
        """
        key = f'{kind.__name__} {sorted(options.items())}'
        if key not in self.clients:
            self.clients[key] = kind(node=self.node, callback_group=self.group, **options)
        return self.clients[key]


@pytest.fixture
def robot(pytestconfig: pytest.Config, shared_in_folder: Callable[..., Robot]) -> Robot:
    """Give an arm with a gripper, or that of the server that the command line names."""
    return shared_in_folder(lambda: running_robot(pytestconfig), Path(__file__).parent)


@contextmanager
def running_robot(pytestconfig: pytest.Config) -> Iterator[Robot]:
    """Run a server and a node beside it."""
    command = pytestconfig.getoption('server_command', None) or GRIPPER_ARM
    if command.endswith('armsim_ros bringup'):
        command = GRIPPER_ARM
    ready = pytestconfig.getoption('server_ready', READY)
    with (
        no_answer_lost('pymoveit2.moveit2.ActionClient', 'pymoveit2.gripper_command.ActionClient',
                       'pymoveit2.gripper_interface.ActionClient'),
        private_domain() as domain,
        Program(shlex.split(command), environment=ros_environment(domain)) as program,
    ):
        program.wait_for_line(ready, 60.0)
        yield from beside(program, domain)


def beside(program: Program, domain: int) -> Iterator[Robot]:
    """Join the domain of a server with a node that an executor spins."""
    context = Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    remap = ['--ros-args', '-r', f'joint_states:={joint_states_topic(context)}']
    node = Node('pymoveit2_user', context=context, cli_args=remap)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    thread = threading.Thread(target=spin, args=(executor,), daemon=True)
    thread.start()
    group = ReentrantCallbackGroup()
    try:
        description = RobotDescription.from_node(node, callback_group=group)
        yield Robot(node, group, description, remap, program)
    finally:
        executor.shutdown(1.0)
        thread.join(5.0)
        destroy_node(node)
        context.try_shutdown()


def joint_states_topic(context: Context) -> str:
    """Return the name of the first topic with joint states."""
    node = Node('finder', context=context)
    try:
        found = until(
            lambda: [
                name
                for name, kinds in node.get_topic_names_and_types()
                if kinds == ['sensor_msgs/msg/JointState'] and node.count_publishers(name)
            ],
            'a topic with joint states',
        )
        return str(found[0])
    finally:
        node.destroy_node()


def spin(executor: MultiThreadedExecutor) -> None:
    """
    Spin until the context ends.

    rclpy raises in the executor where a client is destroyed just while it is being waited for,
    as the probes of pymoveit2's GripperInterface are; the next round works again.
    """
    while True:
        try:
            executor.spin()
            return
        except ExternalShutdownException:
            return
        except (RCLError, InvalidHandle):
            continue


@pytest.fixture
def user(robot: Robot) -> Robot:
    """Give the robot to one test, with an empty world."""
    cleaner = robot.arm()
    for _ in range(2):  # the first puts down what is carried, the second removes that too
        future = cleaner.clear_all_collision_objects(timeout_sec=5.0)
        until(future.done, 'the world is empty')
        assert cleaner.process_clear_all_collision_objects_future(future)
    return robot


@pytest.fixture(params=['service', 'action'])
def arm(request: pytest.FixtureRequest, user: Robot) -> MoveIt2:
    """Give the arm's client in both ways: planning service and executor, or move_action."""
    client = user.arm(use_move_group_action=request.param == 'action')
    assert client.wait_for_joint_state(10.0)
    return client


@pytest.fixture
def planner(user: Robot) -> MoveIt2:
    """Give a client that plans by the service."""
    client = user.arm()
    assert client.wait_for_joint_state(10.0)
    return client
