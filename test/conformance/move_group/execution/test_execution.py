# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Execution with controllers that the test plays."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
import re
import shutil
import threading
from typing import Any

from control_msgs.action import GripperCommand
from geometry_msgs.msg import Transform
from lone_server import LoneServer, PlayedArm, PlayedController
from move_group_bench import ABORTED, CANCELED, seconds
from moveit_msgs.msg import RobotTrajectory
import pytest
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from armsim_ros.resources import find_robot

START = {f'joint_{k}': 0.1 * k for k in range(1, 7)}
URDF = f"urdf:={find_robot('sunday').parent.parent / 'urdf' / 'sunday.urdf.xacro'}"
TWO = """
moveit_simple_controller_manager:
  controller_names: [lower, upper, whole, hand, absent, faulty]
  lower:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_1, joint_2, joint_3]
  upper:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    allowed_execution_duration_scaling: 1.0
    allowed_goal_duration_margin: 0.3
    joints: [joint_4, joint_5]
  whole:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5]
  hand:
    type: GripperCommand
    action_ns: gripper_cmd
    joints: [joint_6]
  absent:
    type: FollowJointTrajectory
    action_ns: follow_joint_trajectory
    joints: [joint_2, joint_3]
  faulty:
    type: FollowJointTrajectory
    joints: [joint_2, joint_3]
"""


@pytest.fixture(scope='module')
def robot(tmp_path_factory: Any) -> Path:
    """
    Give a folder of the default arm whose joints belong to several controllers.

    It has no acceleration limits.
    """
    folder = Path(tmp_path_factory.mktemp('robots')) / 'split'
    shutil.copytree(find_robot('sunday'), folder)
    (folder / 'controllers_gazebo.yaml').unlink()
    (folder / 'trajectory_execution.yaml').unlink()
    (folder / 'moveit_controllers.yaml').write_text(TWO, encoding='utf-8')
    limits = folder / 'joint_limits.yaml'
    kept = [line for line in limits.read_text().splitlines() if 'acceleration' not in line]
    limits.write_text('\n'.join(kept))
    return folder


class Stand:
    """move_group, joint states and four of its five controllers."""

    def __init__(self, server: LoneServer) -> None:
        self.server = server
        self.played: PlayedArm = server.play(START)
        self.arm = self.played.arm
        self.whole = self.played.controller('/whole/follow_joint_trajectory')
        self.lower = self.played.controller('/lower/follow_joint_trajectory')
        self.upper = self.played.controller('/upper/follow_joint_trajectory')
        self.hand = self.played.controller('/hand/gripper_cmd', GripperCommand)

    @property
    def all(self) -> tuple[PlayedController, ...]:
        """The controllers."""
        return self.lower, self.upper, self.whole, self.hand

    def reset(self) -> None:
        """Forget what was sent, and let all controllers arrive."""
        self.played.positions.update(START)
        for one in self.all:
            one.behaviour = 'arrive'
            one.goals.clear()
            one.cancelled.clear()

    def move(self, joint: str, by: float) -> None:
        """Put a joint elsewhere, and wait until all know."""
        self.played.positions[joint] += by
        self.arm.joint_states.clear()
        self.arm.joint_states.wait(3)

    def trajectory(self, *joints: str) -> Any:
        """Return a trajectory of these joints, all where none is named."""
        self.arm.joint_states.clear()
        self.arm.joint_states.wait(3)
        whole = self.arm.planned({name: value + 0.1 for name, value in START.items()})
        keep = [k for k, name in enumerate(whole.joint_names) if not joints or name in joints]
        whole.joint_names = [whole.joint_names[k] for k in keep]
        for point in whole.points:
            for part in ('positions', 'velocities', 'accelerations'):
                values = getattr(point, part)
                setattr(point, part, [values[k] for k in keep])
        return whole


@pytest.fixture(scope='module')
def started(pytestconfig: pytest.Config, robot: Path) -> Iterator[Stand]:
    """Start the server once for the module."""
    command = pytestconfig.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs a server of its own with parameters of its own')
    with LoneServer(f'robot:={robot}', URDF) as server:
        yield Stand(server)


@pytest.fixture
def stand(started: Stand) -> Stand:
    """Give the stand with everything as at the start."""
    started.reset()
    return started


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until something is so."""
    pause = threading.Event()
    for _ in range(1000):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError('it never came to be so')


def allowed(trajectory: Any) -> float:
    """Return how long the upper controller may take [s]."""
    return seconds(trajectory.points[-1].time_from_start) + 0.3


LOWER = ('joint_1', 'joint_2', 'joint_3')
UPPER = ('joint_4', 'joint_5')


@pytest.mark.statement('EXE-3')
def test_the_fewest_controllers_are_chosen(stand: Stand) -> None:
    """One controller for five joints rather than two."""
    assert stand.arm.execute(stand.trajectory(*LOWER, *UPPER)).code == 'SUCCESS'
    assert [len(one.goals) for one in stand.all] == [0, 0, 1, 0]


@pytest.mark.statement('EXE-3')
def test_the_one_with_fewer_surplus_joints_is_chosen(stand: Stand) -> None:
    """Two joints go to the controller that has no others."""
    assert stand.arm.execute(stand.trajectory(*UPPER)).code == 'SUCCESS'
    assert [len(one.goals) for one in stand.all] == [0, 1, 0, 0]


@pytest.mark.statement('EXE-3', 'EXE-4', 'ACT-12', 'EXE-11')
def test_a_trajectory_is_split(stand: Stand) -> None:
    """Each controller gets its own joints at the same times, from now on."""
    trajectory = stand.trajectory(*LOWER, *UPPER)
    assert stand.arm.execute(trajectory, ['lower', 'upper']).code == 'SUCCESS'
    (one,), (two,) = stand.lower.goals, stand.upper.goals
    assert list(one.trajectory.joint_names) == list(LOWER)
    assert list(two.trajectory.joint_names) == list(UPPER)
    for goal in (one, two):
        assert goal.trajectory.header.stamp.sec == 0
        assert not goal.path_tolerance
        assert not goal.goal_tolerance
        assert [p.time_from_start for p in goal.trajectory.points] == [
            p.time_from_start for p in trajectory.points
        ]


@pytest.mark.statement('EXE-1', 'EXE-4')
def test_a_gripper_gets_the_last_position(stand: Stand) -> None:
    """GripperCommand: the command joint's last position."""
    trajectory = stand.trajectory()
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    (goal,) = stand.hand.goals
    place = list(trajectory.joint_names).index('joint_6')
    assert goal.command.position == pytest.approx(trajectory.points[-1].positions[place])


@pytest.mark.statement('EXE-3', 'E14', 'SEED-9')
def test_controllers_that_do_not_cover_the_joints(stand: Stand) -> None:
    """-4 with the sentence that users search for, and the known controllers."""
    ended = stand.arm.execute(stand.trajectory(*LOWER), ['upper'])
    text = ended.result.error_code.message
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert 'Unable to identify any set of controllers that can actuate the specified' in text
    assert 'Known controllers and their joints:' in text
    stand.server.program.wait_for_line('Known controllers and their joints:')


@pytest.mark.statement('EXE-7', 'E16')
def test_a_goal_that_a_controller_rejects(stand: Stand) -> None:
    """-4, and the message names the controller."""
    stand.whole.behaviour = 'reject'
    ended = stand.arm.execute(stand.trajectory(*LOWER, *UPPER))
    assert ended.code == 'CONTROL_FAILED'
    assert 'whole' in ended.result.error_code.message


@pytest.mark.statement('EXE-10', 'E16')
def test_a_part_that_fails_ends_the_others(stand: Stand) -> None:
    """-4 with the controller's own sentence; the other part is cancelled."""
    stand.lower.behaviour, stand.upper.behaviour = 'hold', 'abort'
    ended = stand.arm.execute(stand.trajectory(*LOWER, *UPPER), ['lower', 'upper'])
    assert ended.code == 'CONTROL_FAILED'
    assert stand.upper.error_string in ended.result.error_code.message
    assert stand.lower.cancelled.wait(2.0)


@pytest.mark.statement('EXE-8', 'E17')
def test_a_controller_that_takes_too_long(stand: Stand) -> None:
    """-6 with the time that was allowed, and the controller is cancelled."""
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    ended = stand.arm.execute(trajectory)
    assert ended.code == 'TIMED_OUT'
    assert f'{allowed(trajectory):.2f} s' in ended.result.error_code.message
    assert stand.upper.cancelled.is_set()


@pytest.mark.statement('EXE-8')
def test_a_result_that_is_late(stand: Stand) -> None:
    """An arm that is where it should be has not failed: the result is waited for a little."""
    stand.upper.behaviour = 'late'
    trajectory = stand.trajectory(*UPPER)
    handle = stand.arm.send_execute(trajectory)
    with pytest.raises(AssertionError, match='no result'):
        stand.arm.ended(handle, timeout=allowed(trajectory) + 0.3)
    stand.upper.release()
    assert stand.arm.ended(handle).code == 'SUCCESS'


@pytest.mark.statement('EXE-8', 'PAR-5')
def test_the_duration_monitor_can_be_switched_off(stand: Stand) -> None:
    """Without it a slow controller is waited for."""
    name = 'trajectory_execution.execution_duration_monitoring'
    assert stand.arm.execution_parameters.set(name, False) == ''
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    handle = stand.arm.send_execute(trajectory)
    with pytest.raises(AssertionError, match='no result'):
        stand.arm.ended(handle, timeout=allowed(trajectory) + 0.5)
    stand.arm.cancel(handle)
    assert stand.arm.execution_parameters.set(name, True) == ''


@pytest.mark.statement('EXE-7')
def test_a_controller_that_never_answers(stand: Stand) -> None:
    """-4 after some seconds; the next motion runs, and a late answer leads to a cancel."""
    stand.upper.behaviour = 'mute'
    ended = stand.arm.execute(stand.trajectory(*UPPER))
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert "'upper' has not answered" in ended.result.error_code.message
    assert stand.arm.execute(stand.trajectory(*LOWER)).code == 'SUCCESS'
    stand.upper.release()
    assert stand.upper.cancelled.wait(20.0)


@pytest.mark.statement('EXE-7', 'ACT-5')
def test_a_goal_is_cancelled_before_its_controller_answers(stand: Stand) -> None:
    """The cancel ends it; what the controller accepts after that is cancelled there."""
    stand.upper.behaviour = 'mute'
    handle = stand.arm.send_execute(stand.trajectory(*UPPER))
    wait_for(lambda: stand.upper.goals)
    stand.arm.cancel(handle)
    assert stand.arm.ended(handle, timeout=20.0).status == CANCELED
    stand.upper.release()
    assert stand.upper.cancelled.wait(20.0)


@pytest.mark.statement('ACT-5', 'ACT-10')
def test_a_goal_is_cancelled_while_it_waits_for_another(stand: Stand) -> None:
    """The second one ends at once, and never reaches its controller; the first goes on."""
    stand.lower.behaviour = 'hold'
    there = stand.trajectory(*LOWER)
    first = stand.arm.send_execute(there)
    wait_for(lambda: stand.lower.goals)
    back = deepcopy(there)
    for point, mirrored in zip(back.points, reversed(there.points), strict=True):
        point.positions = mirrored.positions
        point.velocities = [-value for value in mirrored.velocities]
        point.accelerations = mirrored.accelerations
    second = stand.arm.send_execute(back)
    stand.arm.cancel(second)
    assert stand.arm.ended(second, timeout=20.0).status == CANCELED
    assert not stand.lower.cancelled.is_set()
    stand.arm.cancel(first)
    assert stand.arm.ended(first).status == CANCELED
    assert len(stand.lower.goals) == 1


@pytest.mark.statement('EXE-5')
def test_tolerance_of_one_joint(stand: Stand) -> None:
    """The start of one joint may be further away than that of the others."""
    trajectory = stand.trajectory(*UPPER)
    stand.move('joint_4', 0.1)
    ended = stand.arm.execute(trajectory)
    assert ended.code == 'CONTROL_FAILED'
    assert 'joint_4' in ended.result.error_code.message
    name = 'trajectory_execution.allowed_start_tolerance_joints.joint_4'
    assert stand.arm.execution_parameters.set(name, 0.2) == ''
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    assert stand.arm.execution_parameters.set(name, 0.01) == ''


@pytest.mark.statement('S20', 'PAR-4', 'EXE-1')
def test_controllers_are_parameters(stand: Stand) -> None:
    """
    The controllers without faults are parameters; a faulty one is reported and left out.

    Upstream: moveit_simple_controller_manager.cpp, initialize.
    """
    manager = 'moveit_simple_controller_manager'
    for parameters in (stand.arm.parameters, stand.arm.execution_parameters):
        get = parameters.get
        assert get(f'{manager}.controller_names') == ['lower', 'upper', 'whole', 'hand', 'absent']
        assert get(f'{manager}.hand.action_ns') == 'gripper_cmd'
        assert get(f'{manager}.upper.allowed_goal_duration_margin') == 0.3
    stand.server.program.wait_for_line("'faulty' has no 'action_ns'")


@pytest.mark.statement('S19')
def test_parameters_count_on_the_controller_managers_node(stand: Stand) -> None:
    """
    move_group takes trajectory_execution.* without effect; others than these are refused.

    Upstream: trajectory_execution_manager.cpp, initialize.
    """
    name = 'trajectory_execution.allowed_start_tolerance'
    assert stand.arm.parameters.set(name, 5.0) == ''
    stand.server.program.wait_for_line('no effect on this node')
    trajectory = stand.trajectory(*UPPER)
    stand.move('joint_4', 0.1)
    assert stand.arm.execute(trajectory).code == 'CONTROL_FAILED'
    refused = stand.arm.execution_parameters.set
    assert 'not known' in refused('anything', 1)
    assert "no joint 'elbow'" in refused(f'{name}_joints.elbow', 0.1)
    assert 'from 0 up' in refused(f'{name}_joints.joint_4', -0.1)


@pytest.mark.statement('S18')
def test_velocity_scaling_at_run_time(stand: Stand) -> None:
    """
    The velocities of the points are multiplied, nothing else.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    name = 'trajectory_execution.execution_velocity_scaling'
    trajectory = stand.trajectory(*UPPER)
    assert stand.arm.execution_parameters.set(name, 0.5) == ''
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    assert stand.arm.execution_parameters.set(name, 1.0) == ''
    (goal,) = stand.upper.goals
    for sent, given in zip(goal.trajectory.points, trajectory.points, strict=True):
        assert list(sent.velocities) == pytest.approx([0.5 * each for each in given.velocities])
        assert list(sent.positions) == pytest.approx(list(given.positions))
        assert sent.time_from_start == given.time_from_start


@pytest.mark.statement('S12')
def test_joint_states_that_have_stopped(stand: Stand) -> None:
    """
    Without a joint state newer than the request nothing is started: -4.

    Upstream: trajectory_execution_manager.cpp, validate.
    """
    trajectory = stand.trajectory(*UPPER)
    stand.played.silence()
    try:
        ended = stand.arm.execute(trajectory)
    finally:
        stand.played.resume()
    assert ended.code == 'CONTROL_FAILED'
    assert 'no joint state newer' in ended.result.error_code.message
    assert not stand.upper.goals


@pytest.mark.statement('S15')
def test_a_trajectory_with_a_stamp(stand: Stand) -> None:
    """
    The header reaches the controller; the time until its stamp belongs to the allowed duration.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory and executePart.
    """
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    late = stand.server.client.node.get_clock().now().nanoseconds + 2_000_000_000
    stamp = trajectory.header.stamp
    stamp.sec, stamp.nanosec = divmod(late, 10**9)
    ended = stand.arm.execute(trajectory)
    (goal,) = stand.upper.goals
    assert goal.trajectory.header.stamp == stamp
    assert ended.code == 'TIMED_OUT'
    (told,) = re.findall(r'longer than the ([0-9.]+) s', ended.result.error_code.message)
    assert allowed(trajectory) + 1.0 < float(told) < allowed(trajectory) + 2.5


@pytest.mark.statement('S16')
def test_multi_dof_points_need_a_controller(stand: Stand) -> None:
    """
    A trajectory with multi-DOF points is not empty: without a controller for them it is -4.

    Upstream: trajectory_execution_manager.cpp, configure.
    """
    whole = RobotTrajectory()
    whole.multi_dof_joint_trajectory.joint_names = ['base']
    whole.multi_dof_joint_trajectory.points = [
        MultiDOFJointTrajectoryPoint(transforms=[Transform()])]
    ended = stand.arm.execute(whole)
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert "'base'" in ended.result.error_code.message
    assert stand.arm.execute(RobotTrajectory()).code == 'SUCCESS'


@pytest.mark.statement('S13', 'M28')
def test_a_gripper_that_closed_on_an_object(stand: Stand) -> None:
    """
    The status of the goal decides: stalled and succeeded is success, aborted is -4.

    Upstream: action_based_controller_handle.hpp, finishControllerExecution.
    """
    stand.hand.behaviour = 'stall'
    trajectory = stand.trajectory('joint_6')
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    stand.hand.behaviour = 'abort'
    assert stand.arm.execute(trajectory).code == 'CONTROL_FAILED'


@pytest.mark.statement('M30')
def test_a_goal_that_the_controller_cancels(stand: Stand) -> None:
    """
    execute_trajectory ends with -7, move_action with -4, both aborted.

    Upstream: trajectory_execution_manager.cpp, executePart; plan_execution.cpp,
    executeAndMonitor.
    """
    stand.whole.behaviour = 'give up'
    handles = (lambda: stand.arm.send_execute(stand.trajectory(*LOWER, *UPPER)),
               lambda: stand.arm.send_move(dict.fromkeys(START, 0.3)))
    for send, code in zip(handles, ('PREEMPTED', 'CONTROL_FAILED'), strict=True):
        stand.whole.goals.clear()
        handle = send()
        wait_for(lambda: stand.whole.goals)
        wait_for(stand.whole.waits)
        stand.whole.release()
        ended = stand.arm.ended(handle, timeout=20.0)
        assert (ended.status, ended.code) == (ABORTED, code)


@pytest.mark.statement('EXE-7')
def test_a_controller_that_is_not_there(stand: Stand) -> None:
    """-4 within seconds, and the message names its action."""
    ended = stand.arm.execute(stand.trajectory('joint_2', 'joint_3'))
    assert ended.code == 'CONTROL_FAILED'
    assert "'absent/follow_joint_trajectory'" in ended.result.error_code.message


@pytest.mark.statement('BOOT-5', 'E12')
def test_missing_acceleration_limits_do_not_hinder(stand: Stand) -> None:
    """A default is assumed and told once, in one line that names the joints."""
    for step in (0.1, 0.2):
        stand.arm.planned({name: value + step for name, value in START.items()})
    lines = [line for line in stand.server.program.output if 'no acceleration limit' in line]
    assert len(lines) == 1
    assert all(name in lines[0] for name in START)
