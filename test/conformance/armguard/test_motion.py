# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The ROS 2 backend of armguard-mcp as it is on the package index, beside the default arm.

It plans by services of move_group, sends the trajectory to the controller itself, and checks
controllers and joint states by its own rules.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Sequence
import time
from typing import Any, TypeVar

import pytest

ros2 = pytest.importorskip('armguard_mcp.backends.ros2', reason='armguard-mcp is not installed')
from arm_user import default_arm, no_answer_lost  # noqa: E402
from armguard_mcp.backends.base import BackendFailed  # noqa: E402

JOINTS = [f'joint_{number}' for number in range(1, 7)]
ARM = '/sunday/arm_joint_controller'
#: A bent state from which the tip can go in every direction.
BENT = [0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0]
Value = TypeVar('Value')


class Agent:
    """The backend and the event loop that it lives in."""

    def __init__(self, domain: int) -> None:
        self.loop = asyncio.new_event_loop()
        self.backend = ros2.Ros2Backend(
            ros2.Ros2BackendConfig(
                domain_id=domain, joint_states_topic='/sunday/joint_states',
                trajectory_action=f'{ARM}/follow_joint_trajectory',
                controller_manager='/sunday/controller_manager', wrench_topic=None,
                gripper_interface='none', startup_timeout_s=30.0, execution_timeout_margin_s=20.0,
                service_timeout_s=20.0, collision_behavior_service=None,
                error_recovery_action=None),
            joint_names=JOINTS, base_frame='base_link', ee_frame='link_6',
            planning_group='manipulator')

    def run(self, work: Awaitable[Value]) -> Value:
        """Run one of the backend's methods to its end."""
        return self.loop.run_until_complete(work)

    def comes_to(self, value: Callable[[], Sequence[float]], wanted: Sequence[float]) -> bool:
        """
        Wait until a value is the wanted one.

        Joint states and transforms reach the client on their own ways, some after the result.
        """
        end = time.monotonic() + 10.0
        while value() != pytest.approx(wanted, abs=5e-3):
            if time.monotonic() > end:
                return False
        return True

    @property
    def positions(self) -> list[float]:
        """The joints' positions now [rad]."""
        return list(self.run(self.backend.get_joint_state()).positions)

    @property
    def tip(self) -> tuple[float, ...]:
        """Where compute_fk has the tip of the joint states [m]."""
        pose = self.run(self.backend.forward_kinematics(self.positions))
        return tuple(pose.position.as_tuple())

    def execute(self, plan: Any, abort: Callable[[], bool] = lambda: False) -> Any:
        """Execute a plan; return the backend's result."""
        async def progress(share: float, text: str) -> None:
            self.share = share

        return self.run(self.backend.execute(plan, progress, abort))


@pytest.fixture(scope='module')
def agent(pytestconfig: pytest.Config) -> Iterator[Agent]:
    """Give the backend beside a running arm."""
    with default_arm(pytestconfig) as domain, no_answer_lost('rclpy.action.ActionClient'):
        agent = Agent(domain)
        agent.run(agent.backend.start())
        yield agent
        agent.run(agent.backend.shutdown())
        agent.loop.close()


def test_all_that_it_needs_is_there(agent: Agent) -> None:
    """Services, actions, joint states and controllers are found, by the names that it is given."""
    assert agent.backend.availability
    assert all(agent.backend.availability.values()), agent.backend.availability
    states = {one.name: one.state for one in agent.run(agent.backend.list_controllers())}
    assert states['arm_joint_controller'] == 'active'


def test_a_joint_goal_is_planned_and_executed(agent: Agent) -> None:
    """The plan is what the arm does; the controller reports success, and the arm is there."""
    plan = agent.run(agent.backend.plan_to_joints(BENT, 0.5, 0.5))
    result = agent.execute(plan)
    assert result.success, result.message
    assert agent.share == 1.0
    assert agent.comes_to(lambda: agent.positions, BENT)


def test_a_pose_goal_is_planned_and_executed(agent: Agent) -> None:
    """A pose that forward kinematics gave is reached."""
    wanted = agent.run(agent.backend.forward_kinematics([value + 0.15 for value in BENT]))
    plan = agent.run(agent.backend.plan_to_pose(wanted, 0.5, 0.5))
    assert agent.execute(plan).success
    position = wanted.position.as_tuple()
    assert agent.comes_to(lambda: agent.tip, position)
    by_transforms = agent.backend.get_ee_pose
    assert agent.comes_to(lambda: agent.run(by_transforms()).position.as_tuple(), position)


def test_a_straight_line_is_planned_and_executed(agent: Agent) -> None:
    """A Cartesian path is complete, and keeps its speed scaling."""
    assert agent.execute(agent.run(agent.backend.plan_to_joints(BENT, 0.5, 0.5))).success
    assert agent.comes_to(lambda: agent.positions, BENT)
    start = agent.run(agent.backend.forward_kinematics(agent.positions))
    position = start.position.model_copy(update={'z': start.position.z - 0.03})
    target = start.model_copy(update={'position': position})
    slow, fast = (agent.run(agent.backend.plan_cartesian([target], 0.01, scale, scale))
                  for scale in (0.1, 1.0))
    assert slow.duration_s > 1.5 * fast.duration_s
    assert agent.execute(fast).success
    assert agent.comes_to(lambda: agent.tip, position.as_tuple())


def test_an_execution_is_aborted(agent: Agent) -> None:
    """The goal is cancelled, and the arm stands before its target."""
    target = [value + 0.4 for value in agent.positions]
    plan = agent.run(agent.backend.plan_to_joints(target, 0.02, 0.02))
    asked = iter(range(100))
    result = agent.execute(plan, lambda: next(asked) > 5)
    assert result.aborted, result.message
    assert 'CANCELED' in result.message
    assert max(abs(a - b) for a, b in zip(agent.positions, target, strict=True)) > 0.1


def test_a_goal_that_cannot_be_is_refused(agent: Agent) -> None:
    """What MoveIt refuses is refused, and the agent goes on."""
    with pytest.raises(BackendFailed, match='planning failed'):
        agent.run(agent.backend.plan_to_pose(agent.run(agent.backend.forward_kinematics(
            agent.positions)).model_copy(update={'position': ros2.Vector3(x=9.0, y=0.0, z=0.0)}),
            0.5, 0.5))
    agent.run(agent.backend.get_joint_state())


def test_controllers_are_switched(agent: Agent) -> None:
    """A switch there and back; a refused one has its reason."""
    states = agent.run(agent.backend.switch_controllers([], ['arm_joint_controller']))
    assert {one.name: one.state for one in states}['arm_joint_controller'] == 'inactive'
    with pytest.raises(BackendFailed, match='nobody'):
        agent.run(agent.backend.switch_controllers(['nobody'], []))
    states = agent.run(agent.backend.switch_controllers(['arm_joint_controller'], []))
    assert {one.name: one.state for one in states}['arm_joint_controller'] == 'active'
