# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stacks whose programs are killed, ended or stopped, and a client that is at work meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
from dataclasses import dataclass
import os
from pathlib import Path
import re
import signal
import threading
import time
from typing import Any

from geometry_msgs.msg import Pose
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import (
    CollisionObject,
    Constraints,
    JointConstraint,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.srv import GetPositionFK
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import trajectory_message
from armsim_ros.testing.program import Program, start_program

PROGRAMS = ('bringup', 'simulation', 'move_group')
READY = 'You can start planning now!'
JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
#: A client knows within this time what became of its goal [s].
KNOWN = 3.0
#: A program that is stopped counts as gone after its lease of 2.5 s. Where it goes on while others
#: still forget its endpoints, Fast DDS may not find it again (docs/errors.md). After this time all
#: have forgotten it [s].
FORGOTTEN = 5.0
#: What is said while the motion before goes on.
STILL_MOVING = ('another trajectory is being executed', 'start point deviates')


class Arm:
    """
    A client of both programs.

    :param client: in the stack's domain.
    """

    def __init__(self, client: ClientNode) -> None:
        self.client = client
        self.plans = PatientActionClient(client.node, MoveGroup, '/move_action')
        self.motions = PatientActionClient(client.node, ExecuteTrajectory, '/execute_trajectory')
        self.states = client.collect('/sunday/joint_states', JointState)

    def position(self) -> dict[str, float]:
        """Return the joint positions of a message that comes from now on [rad]."""
        self.states.clear()
        message = self.states.wait(1)[-1]
        return dict(zip(message.name, message.position, strict=True))

    def plan(self, offset: float, seconds: float, *, only: bool = True) -> Any:
        """Ask for a plan and, unless it is all, for the motion, too; return the goal."""
        return self._accepted(self.plans, self._plan_goal(offset, seconds, only))

    def long_plan(self, seconds: float) -> Any:
        """Ask a planner that uses up its time [s] for a plan past a box; return the goal."""
        goal = self._plan_goal(0.4, seconds, only=True)
        goal.request.planner_id = 'RRTstar'
        middle = self.position()
        state = RobotState()
        state.joint_state.name = list(JOINTS)
        state.joint_state.position = [middle[joint] + 0.2 for joint in JOINTS]
        pose = self.client.call('/compute_fk', GetPositionFK, GetPositionFK.Request(
            fk_link_names=['link_6'], robot_state=state)).pose_stamped[0]
        box = CollisionObject(id='box', header=pose.header, pose=pose.pose)
        box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.05] * 3)]
        box.primitive_poses = [Pose()]
        goal.planning_options.planning_scene_diff.world.collision_objects = [box]
        return self._accepted(self.plans, goal)

    def _plan_goal(self, offset: float, seconds: float, only: bool) -> MoveGroup.Goal:
        goal = MoveGroup.Goal()
        goal.planning_options.plan_only = only
        diff = goal.planning_options.planning_scene_diff
        diff.is_diff = diff.robot_state.is_diff = True
        request = goal.request
        request.group_name = 'manipulator'
        request.allowed_planning_time, request.num_planning_attempts = seconds, 1
        request.max_velocity_scaling_factor = request.max_acceleration_scaling_factor = 1.0
        request.start_state = RobotState(is_diff=True)
        here = self.position()
        request.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(joint_name=joint, position=here[joint] + offset, tolerance_above=1e-3,
                            tolerance_below=1e-3, weight=1.0) for joint in JOINTS])]
        return goal

    def move(
        self, offset: float, seconds: float, here: dict[str, float] | None = None
    ) -> Any:
        """Begin to move all joints by an offset [rad] in a time [s]; return the goal."""
        here = here or self.position()
        there = [here[joint] + offset for joint in JOINTS]
        start = [here[joint] for joint in JOINTS]
        trajectory = trajectory_message(JOINTS, [(0.0, start), (seconds, there)])
        goal = ExecuteTrajectory.Goal(trajectory=RobotTrajectory(joint_trajectory=trajectory))
        return self._accepted(self.motions, goal)

    def works(self) -> None:
        """Plan, move and arrive."""
        deadline = time.monotonic() + 20.0
        while True:
            error = self.result(self.plan(0.05, 5.0, only=False), 20.0).error_code
            if not any(words in error.message for words in STILL_MOVING):
                break
            assert time.monotonic() < deadline, 'the motion before goes on without end'
        assert error.val == 1, error

    def result(self, goal: Any, timeout: float) -> Any:
        """Return the result of a goal."""
        return self.client.result(goal.get_result_async(), timeout, 'result').result

    def _accepted(self, actions: PatientActionClient, goal: Any) -> Any:
        assert actions.wait_for_server(10.0)
        handle = self.client.result(actions.send_goal_async(goal), 10.0, 'answer to the goal')
        assert handle.accepted
        return handle


@dataclass
class Stack:
    """A running stack, its processes by name, and a client."""

    program: Program
    pids: dict[str, int]
    arm: Arm

    @contextmanager
    def stopped(self, name: str) -> Iterator[None]:
        """Stop a process meanwhile, and until all others have forgotten it."""
        since = time.monotonic()
        os.kill(self.pids[name], signal.SIGSTOP)
        try:
            yield
            threading.Event().wait(since + FORGOTTEN - time.monotonic())
        finally:
            os.kill(self.pids[name], signal.SIGCONT)


class Stacks:
    """
    Stacks in one domain, each of which follows at once upon the last.

    :param arm: client of all of them.
    """

    def __init__(self, domain: int, arm: Arm) -> None:
        self._domain, self._arm = domain, arm
        self._stack: Stack | None = None

    def running(self) -> Stack:
        """Return the stack that runs, or start the next one."""
        if self._stack is not None and self._stack.program.process.poll() is not None:
            self.close()
        if self._stack is None:
            with ExitStack() as unless_ready:
                program = unless_ready.enter_context(start_program('bringup', self._domain))
                program.wait_for_line(re.escape(READY), 60.0)
                self._stack = Stack(program, processes(program), self._arm)
                unless_ready.pop_all()
        return self._stack

    def close(self) -> None:
        """End the stack."""
        if self._stack is not None:
            self._stack.program.stop()
            self._stack = None


def processes(program: Program) -> dict[str, int]:
    """Return the stack's processes by name."""
    pid = program.process.pid
    found = {'bringup': pid}
    for child in Path(f'/proc/{pid}/task/{pid}/children').read_text().split():
        words = Path(f'/proc/{child}/cmdline').read_text().split('\0')
        found[words[words.index('armsim_ros') + 1]] = int(child)
    return found


def wait_until(condition: Any, timeout: float, what: str) -> None:
    """Wait until something is so."""
    pause, deadline = threading.Event(), time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f'{what}: not within {timeout} s'
        pause.wait(0.02)


def runs(pid: int) -> bool:
    """Return whether a process exists and is no zombie."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False
