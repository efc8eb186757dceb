# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One running stack for all tests of this folder, and what they ask it for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree

from action_msgs.msg import GoalStatus
from faster import FASTER
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    JointConstraint,
    PlanningScene,
    RobotState,
)
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain, Program, ros_environment

GROUP = 'manipulator'
READY = 'You can start planning now!'
SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED,
    GoalStatus.STATUS_CANCELED,
    GoalStatus.STATUS_ABORTED,
)


@dataclass
class Stack:
    """The running programs and a client's view of them."""

    client: ClientNode
    program: Program

    def __post_init__(self) -> None:
        node = self.client.node
        self.move_action = PatientActionClient(node, MoveGroup, '/move_action')
        self.execute_action = PatientActionClient(node, ExecuteTrajectory, '/execute_trajectory')
        self.joint_states = self.client.collect('/sunday/joint_states', JointState)
        srdf = self.client.latched('/robot_description_semantic', String).data
        self.states = {
            state.get('name'): {
                joint.get('name'): float(joint.get('value')) for joint in state.findall('joint')
            }
            for state in ElementTree.fromstring(srdf).findall('group_state')
        }

    def positions(self) -> dict[str, float]:
        """Return the joint positions of a message that comes from now on [rad]."""
        self.joint_states.clear()
        message = self.joint_states.wait(1)[-1]
        return dict(zip(message.name, message.position, strict=True))

    def move(self, state: str | dict[str, float], **options: Any) -> Any:
        """Send a goal to /move_action and return status and result."""
        return self.wait(self.send_move(state, **options))

    def send_move(self, state: str | dict[str, float], **options: Any) -> Any:
        """Send a goal to /move_action and return its handle."""
        goal = MoveGroup.Goal(request=self.request(state))
        goal.planning_options.plan_only = options.pop('plan_only', False)
        goal.planning_options.planning_scene_diff.is_diff = True
        for key, value in options.items():
            setattr(goal.request, key, value)
        assert self.move_action.wait_for_server(10.0)
        return self.client.result(self.move_action.send_goal_async(goal), 10.0, 'goal answer')

    def request(self, state: str | dict[str, float]) -> Any:
        """Return a planning request for a joint goal."""
        return plan_request(self.target(state))

    def execute(self, trajectory: Any, names: tuple[str, ...] = ()) -> Any:
        """Send a goal to /execute_trajectory and return its handle."""
        goal = ExecuteTrajectory.Goal(trajectory=trajectory, controller_names=list(names))
        assert self.execute_action.wait_for_server(10.0)
        return self.client.result(self.execute_action.send_goal_async(goal), 10.0, 'goal answer')

    def wait(self, handle: Any, timeout: float = 30.0) -> Any:
        """Return the result of a goal, with its status."""
        assert handle.accepted
        return self.client.result(handle.get_result_async(), timeout, 'result')

    def target(self, state: str | dict[str, float]) -> dict[str, float]:
        return self.states[state] if isinstance(state, str) else state

    def apply(self, scene: PlanningScene) -> bool:
        """Apply a scene message and return whether all of it was taken."""
        request = ApplyPlanningScene.Request(scene=scene)
        return bool(self.client.call('/apply_planning_scene', ApplyPlanningScene, request).success)

    def scene(self, components: int = 0) -> PlanningScene:
        """Return the planning scene with the components asked for."""
        request = GetPlanningScene.Request()
        request.components.components = components
        return self.client.call('/get_planning_scene', GetPlanningScene, request).scene


def plan_request(target: dict[str, float], tolerance: float = 1e-4) -> Any:
    """Return a request for a joint goal, as RViz makes it."""
    request = MoveGroup.Goal().request
    request.group_name = GROUP
    request.num_planning_attempts = 1
    request.allowed_planning_time = 5.0
    request.max_velocity_scaling_factor = 1.0
    request.max_acceleration_scaling_factor = 1.0
    request.start_state = RobotState(is_diff=True)
    request.goal_constraints = [
        Constraints(
            joint_constraints=[
                JointConstraint(
                    joint_name=joint,
                    position=value,
                    tolerance_above=tolerance,
                    tolerance_below=tolerance,
                    weight=1.0,
                )
                for joint, value in target.items()
            ]
        )
    ]
    return request


@pytest.fixture(scope='module')
def running(shared_in_folder: Callable[..., Stack]) -> Stack:
    """Give the stack that all tests of the folder share."""
    return shared_in_folder(running_stack, Path(__file__).parent)


@contextmanager
def running_stack() -> Iterator[Stack]:
    """Run a stack and a node beside it."""
    with (
        private_domain() as domain,
        ClientNode(domain, 'move_group_tests') as client,
        Program.module(
            'armsim_ros', 'bringup', 'scene_from_world:=false', FASTER,
            environment=ros_environment(domain)) as program,
    ):
        program.wait_for_line(re.escape(READY), 60.0)
        yield Stack(client, program)


@pytest.fixture
def stack(running: Stack) -> Stack:
    """Return the stack with an empty world."""
    scene = PlanningScene(is_diff=False)
    scene.robot_state.is_diff = True
    scene.robot_state.attached_collision_objects = [AttachedCollisionObject(
        object=CollisionObject(operation=CollisionObject.REMOVE))]
    empty = running.scene()
    scene.allowed_collision_matrix = empty.allowed_collision_matrix
    scene.link_padding, scene.link_scale = empty.link_padding, empty.link_scale
    assert running.apply(scene)
    return running
