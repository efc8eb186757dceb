# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gripper controllers: GripperCommand and ParallelGripperCommand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from action_msgs.msg import GoalStatus
from control_msgs.action import GripperCommand, ParallelGripperCommand
from control_msgs.msg import GripperCommand as Command
from controller_bench import Bench
import pytest
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState

from armsim_ros.clients.controller_manager import ParameterClient

statement = pytest.mark.statement
upstream = pytest.mark.upstream
SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED


class Gripper:
    """A client of one gripper controller."""

    def __init__(self, bench: Bench, name: str, kind: type) -> None:
        bench.activate(name)
        self._client = bench.client
        self._kind = kind
        self._action = ActionClient(
            bench.client.node, kind, bench.name(f'{name}/gripper_cmd')
        )
        self.feedback: list[Any] = []
        assert self._action.wait_for_server(10.0)

    def send(self, position: float, effort: float = 0.0) -> Any:
        """Send a goal of one position; return its handle."""
        if self._kind is GripperCommand:
            return self.send_goal(
                GripperCommand.Goal(command=Command(position=position, max_effort=effort))
            )
        return self.send_goal(ParallelGripperCommand.Goal(command=JointState(position=[position])))

    def send_goal(self, goal: Any) -> Any:
        """Send a goal message; return its handle."""
        return self._client.result(self._client.in_executor(
            lambda: self._action.send_goal_async(goal, feedback_callback=self.feedback.append)
        ))

    def result(self, handle: Any) -> Any:
        """Wait for the end; the response has status and result."""
        assert handle.accepted
        return self._client.result(self._client.in_executor(handle.get_result_async), 15.0)

    def cancel(self, handle: Any) -> bool:
        """Ask for cancellation."""
        answer = self._client.result(self._client.in_executor(handle.cancel_goal_async))
        return bool(answer.goals_canceling)

    def close(self) -> None:
        """Take the client away."""
        self._client.in_executor(self._action.destroy)


@pytest.fixture
def gripper_of(bench: Bench) -> Iterator[Callable[..., Gripper]]:
    """Give a function that makes clients."""
    opened: list[Gripper] = []

    def make(name: str, kind: type = GripperCommand) -> Gripper:
        opened.append(Gripper(bench, name, kind))
        return opened[-1]

    yield make
    for one in opened:
        one.close()


@contextmanager
def patient(bench: Bench, name: str) -> Iterator[None]:
    """Let a gripper not stall for a while."""
    parameters = ParameterClient(bench.client, bench.name(name))
    before = parameters.get('stall_timeout')
    assert parameters.set('stall_timeout', 60.0) == ''
    yield
    assert parameters.set('stall_timeout', before) == ''


KINDS = pytest.mark.parametrize(
    ('name', 'kind'),
    [('gripper', GripperCommand), ('effort_gripper', GripperCommand),
     ('parallel_gripper', ParallelGripperCommand)],
    ids=['position', 'effort', 'parallel'],
)


def position_of(result: Any) -> float:
    """Return the position of a result of either kind."""
    return float(result.position if hasattr(result, 'position') else result.state.position[0])


@statement('N1', 'N2', 'N3', 'N6')
@upstream('ConfigureParamsSuccess', 'ActivateSuccess')
@KINDS
def test_a_gripper_reaches_its_goal(
    gripper_of: Callable[..., Gripper], name: str, kind: type
) -> None:
    """SUCCEEDED with reached_goal and not stalled; no feedback is published."""
    gripper = gripper_of(name, kind)
    for target in (0.03, 0.0):
        response = gripper.result(gripper.send(target))
        assert response.status == SUCCEEDED
        assert response.result.reached_goal
        assert not response.result.stalled
        assert position_of(response.result) == pytest.approx(target, abs=0.004)
    assert gripper.feedback == []


@statement('N3')
@pytest.mark.parametrize(
    ('name', 'status'), [('gripper', ABORTED), ('soft_gripper', SUCCEEDED)]
)
def test_a_gripper_that_stalls(
    gripper_of: Callable[..., Gripper], fault: Callable[..., None], name: str, status: int
) -> None:
    """Stalled is ABORTED, or SUCCEEDED with allow_stalling; reached_goal is false."""
    gripper = gripper_of(name)
    gripper.result(gripper.send(0.0))
    fault('finger', 'blocked', True)
    response = gripper.result(gripper.send(0.03))
    assert response.status == status
    assert response.result.stalled
    assert not response.result.reached_goal


@statement('N4')
@KINDS
def test_a_cancelled_gripper_holds(
    bench: Bench, gripper_of: Callable[..., Gripper], fault: Callable[..., None], name: str,
    kind: type,
) -> None:
    """CANCELED; the fingers stay where they are."""
    gripper = gripper_of(name, kind)
    gripper.result(gripper.send(0.0))
    fault('finger', 'blocked', True)
    with patient(bench, name):
        goal = gripper.send(0.03)
        assert gripper.cancel(goal)
    response = gripper.result(goal)
    assert response.status == CANCELED
    fault('finger', 'blocked', False)
    assert gripper.result(gripper.send(0.0)).result.reached_goal


@statement('N5')
def test_a_new_goal_cancels_the_old(
    bench: Bench, gripper_of: Callable[..., Gripper], fault: Callable[..., None]
) -> None:
    """The old goal is CANCELED, the new one goes on."""
    gripper = gripper_of('gripper')
    gripper.result(gripper.send(0.0))
    fault('finger', 'blocked', True)
    with patient(bench, 'gripper'):
        old = gripper.send(0.03)
        new = gripper.send(0.0)
    assert gripper.result(old).status == CANCELED
    assert gripper.result(new).status == SUCCEEDED


@statement('N2')
@pytest.mark.parametrize('count', [0, 2])
def test_exactly_one_position(gripper_of: Callable[..., Gripper], count: int) -> None:
    """A parallel gripper refuses commands of none or of two positions."""
    gripper = gripper_of('parallel_gripper', ParallelGripperCommand)
    goal = ParallelGripperCommand.Goal(command=JointState(position=[0.01] * count))
    assert not gripper.send_goal(goal).accepted


@statement('N1', 'N2')
@upstream('ParametersNotSet')
@pytest.mark.parametrize(
    ('controller', 'name', 'default'),
    [('gripper', 'allow_stalling', False), ('gripper', 'max_effort', 0.0),
     ('gripper', 'action_monitor_rate', 20.0), ('parallel_gripper', 'max_effort', 10.0),
     ('parallel_gripper', 'max_velocity', 0.1)],
)
def test_defaults(bench: Bench, controller: str, name: str, default: Any) -> None:
    """The parameters have Jazzy's defaults."""
    assert ParameterClient(bench.client, bench.name(controller)).get(name) == default


@statement('N1')
@upstream('JointParameterIsEmpty', 'ParametersNotSet')
@pytest.mark.parametrize('joint', [None, ''])
def test_a_gripper_needs_a_joint(load: Callable[..., bool], joint: str | None) -> None:
    """Without its joint it is not loaded."""
    none = {'joints': None, 'command_interfaces': None, 'state_interfaces': None}
    assert not load(
        'handless', 'position_controllers/GripperActionController', **none, joint=joint
    )
