# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Each program of a stack killed, ended, or stopped and continued, while others are at work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
import os
from pathlib import Path
import re
import signal
import threading
import time
from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Pose
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import (
    CollisionObject,
    Constraints,
    JointConstraint,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.srv import GetPositionFK
import pytest
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive

from armsim_ros.cli.environment import FASTDDS_PROFILES
from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import trajectory_message
from armsim_ros.testing.program import private_domain, Program, start_program

pytestmark = pytest.mark.alone

PROGRAMS = ('bringup', 'simulation', 'move_group')
READY = 'You can start planning now!'
JOINTS = tuple(f'joint_{number}' for number in range(1, 7))
#: A client knows within this time what became of its goal [s].
KNOWN = 3.0
#: A program that is stopped for longer than its lease is taken for gone [s].
STOPPED = 3.0


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


@pytest.fixture(scope='module')
def domain() -> Iterator[int]:
    """
    Lease a domain for all stacks of this module: each follows at once upon the last.

    They have the package's own settings of Fast DDS, with the lease that users have. This process
    keeps those of the tests: Fast DDS reads them once, when the first client is made.
    """
    with private_domain() as number, pytest.MonkeyPatch.context() as environment:
        with ClientNode(number, 'reads_settings'):
            environment.delenv(FASTDDS_PROFILES[0])
        yield number


@pytest.fixture(scope='module')
def arm(domain: int) -> Iterator[Arm]:
    """Give a client that stays while stacks come and go."""
    with ClientNode(domain, 'kill_matrix') as client:
        yield Arm(client)


@pytest.fixture(scope='module')
def stacks(domain: int, arm: Arm) -> Iterator[Stacks]:
    """Give the stacks of this module, one after the other."""
    made = Stacks(domain, arm)
    yield made
    made.close()


@pytest.fixture
def stack(stacks: Stacks) -> Stack:
    """Give a stack; the last one where it still runs."""
    return stacks.running()


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


def test_an_answer_that_never_comes_ends_the_motion(stack: Stack) -> None:
    """The simulation is stopped before it gets a goal: the motion ends, and the next one goes."""
    arm = stack.arm
    start = arm.position()
    os.kill(stack.pids['simulation'], signal.SIGSTOP)
    try:
        error = arm.result(arm.move(0.1, 1.0, start), 15.0).error_code
    finally:
        os.kill(stack.pids['simulation'], signal.SIGCONT)
    assert error.val == MoveItErrorCodes.CONTROL_FAILED
    reasons = 'has not answered|gone|not connected|no joint state newer'
    assert re.search(reasons, error.message), error.message
    arm.works()


@pytest.mark.parametrize('victim', PROGRAMS)
def test_a_program_that_was_stopped_works_when_it_goes_on(victim: str, stack: Stack) -> None:
    """It is stopped while it plans and moves; others take it for gone, and find it again."""
    arm = stack.arm
    goals = {arm.motions: arm.move(0.02, 1.0), arm.plans: arm.long_plan(1.0)}
    os.kill(stack.pids[victim], signal.SIGSTOP)
    try:
        if victim == 'move_group':
            wait_until(lambda: not any(actions.server_is_ready() for actions in goals),
                       KNOWN, 'the stopped program is taken for gone')
        elif victim == 'simulation':
            threading.Event().wait(STOPPED)
        else:  # it is no client's server: the others end their work meanwhile
            for goal in goals.values():
                assert arm.result(goal, 20.0).error_code.val
    finally:
        os.kill(stack.pids[victim], signal.SIGCONT)
    arm.works()
    assert stack.program.process.poll() is None


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.parametrize('victim', PROGRAMS)
def test_who_waits_learns_of_the_end(victim: str, number: int, stack: Stack) -> None:
    """A plan and a motion get a result or see their server gone; nothing stays behind."""
    arm = stack.arm
    pending = {
        arm.motions: arm.move(0.3, 20.0).get_result_async(),
        arm.plans: arm.long_plan(60.0).get_result_async(),
    }
    os.kill(stack.pids[victim], number)
    wait_until(
        lambda: all(result.done() or not actions.server_is_ready()
                    for actions, result in pending.items()),
        KNOWN, 'every client knows')
    status = stack.program.wait(10.0)
    if victim == 'bringup':
        assert status == (0 if number == signal.SIGTERM else -signal.SIGKILL)
    else:
        assert status == 1
        assert f'[bringup] {victim} (pid {stack.pids[victim]}) ' in stack.program.text
    wait_until(lambda: not any(map(runs, stack.pids.values())), 2.0, 'no process is left')
    answers = [result.result() for result in pending.values() if result.done()]
    for answer in answers:
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert answer.result.error_code.message
    # What is killed takes its goals along; bringup's end is that of the others, too.
    if number == signal.SIGTERM or victim == 'simulation':
        assert answers, stack.program.text
