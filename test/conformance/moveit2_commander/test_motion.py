# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""moveit2-commander as it is on the package index, beside the default arm."""

from __future__ import annotations

from collections.abc import Iterator
import threading
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive

commander = pytest.importorskip(
    'moveit2_commander', reason='moveit2-commander is not installed')
from arm_user import default_arm, no_answer_lost, until  # noqa: E402
from geometry_msgs.msg import Pose  # noqa: E402
from moveit_msgs.msg import CollisionObject  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

from armsim_ros.clients.node import destroy_node  # noqa: E402

GROUP, TIP, BASE = 'manipulator', 'link_6', 'base_link'
BENT = [0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0]


class User:
    """A node that an executor spins, and what it hears of the arm."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self._heard: list[JointState] = []
        node.create_subscription(JointState, '/sunday/joint_states', self._heard.append, 1)
        self.plan = commander.KinematicPath_ServiceManager(node, planning_group=GROUP)
        self.line = commander.CartesianPath_ServiceManager(node, planning_group=GROUP)
        self.execute = commander.ExecuteTrajectory_ServiceManager(node)
        self.fk = commander.FK_ServiceManager(node)
        self.get_scene = commander.GetPlanningScene_ServiceManager(node)
        self.apply_scene = commander.ApplyPlanningScene_ServiceManager(node)

    @property
    def state(self) -> JointState:
        """A joint state from now on."""
        self._heard.clear()
        return until(lambda: self._heard[:1], 'a joint state')[0]

    def planned(self, positions: list[float]) -> Any:
        """Return the trajectory to joint positions [rad]."""
        state = self.state
        names = [f'joint_{number}' for number in range(1, 7)]
        goal = self.plan.get_goal_constraint(
            JointState(name=names, position=positions), tolerance=0.001)
        return self.plan.run([goal], None, state, 1, 2.0)

    def go(self, positions: list[float]) -> int:
        """Plan and execute a motion, scaled by the client as it does it; return the code."""
        trajectory = self.execute.scale_trajectory(self.planned(positions), 0.8)
        code: int = self.execute.run(trajectory).result.error_code.val
        return code

    def error(self, positions: list[float]) -> float:
        """Return how far the joint that is farthest is from positions [rad]."""
        now = dict(zip(self.state.name, self.state.position, strict=True))
        return max(abs(now[f'joint_{k}'] - value) for k, value in enumerate(positions, 1))


@pytest.fixture(scope='module')
def user(pytestconfig: pytest.Config) -> Iterator[User]:
    """Give the client beside a running arm."""
    client = 'moveit2_commander.core.execute_trajectory_service_manager.ActionClient'
    with default_arm(pytestconfig) as domain, no_answer_lost(client):
        context = Context()
        rclpy.init(
            context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        node = Node('commander', context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        end = Future()
        thread = threading.Thread(
            target=executor.spin_until_future_complete, args=(end,), daemon=True)
        thread.start()
        try:
            yield User(node)
        finally:
            executor.create_task(end.set_result, None)
            thread.join(5.0)
            destroy_node(node)
            context.try_shutdown()


def test_a_joint_goal_is_planned_and_executed(user: User) -> None:
    """The arm is where it was to go."""
    assert user.go(BENT) == 1
    assert user.error(BENT) < 5e-3


def test_a_straight_line_is_planned_and_executed(user: User) -> None:
    """A Cartesian path from where the arm is, to a pose of compute_fk that is moved."""
    if user.error(BENT) > 5e-3:
        user.go(BENT)
    pose = user.fk.run(user.state, TIP).pose
    pose.position.z -= 0.05
    trajectory = user.line.run(Header(frame_id=BASE), [pose], user.state, TIP)
    assert user.execute.run(trajectory).result.error_code.val == 1
    assert user.fk.run(user.state, TIP).pose.position.z == pytest.approx(
        pose.position.z, abs=2e-3)


def test_a_scene_is_read_and_sent_back_with_objects(user: User) -> None:
    """The whole scene with another list of objects replaces them; planning knows of them."""
    around = CollisionObject(id='around', operation=CollisionObject.ADD)
    around.header.frame_id = BASE
    around.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[3.0, 3.0, 3.0])]
    around.primitive_poses = [Pose()]
    assert user.apply_scene.run([around], user.get_scene.run())
    assert user.planned([0.0] * 6) is None
    assert user.apply_scene.run([], user.get_scene.run())
    assert user.planned([0.0] * 6) is not None
