# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Garbage on topics that stream and services beside them: nothing moves, words say why."""

from __future__ import annotations

from typing import Any

from control_msgs.msg import JointJog, MultiDOFCommand
from geometry_msgs.msg import PoseStamped
from moveit_task_constructor_msgs.action import ExecuteTaskSolution
from moveit_task_constructor_msgs.msg import Solution, SubTrajectory
import numpy as np
import pytest
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool, Trigger
from streaming_bench import ARM, JOINTS, NAMESPACE, Streamed
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.action_client import PatientActionClient

pytestmark = pytest.mark.usefixtures('statuses')
statement = pytest.mark.statement

NAN, INF = float('nan'), float('inf')
JOG, POSE = 0, 2


def pose(*values: float, frame: str = 'base_link') -> PoseStamped:
    """Return a pose of position and orientation, one value each 7."""
    message = PoseStamped()
    message.header.frame_id = frame
    for part, names in ((message.pose.position, 'xyz'), (message.pose.orientation, 'xyzw')):
        for name in names:
            value, *values = values  # type: ignore[assignment]
            setattr(part, name, float(value))
    return message


CONTROLLERS = [
    pytest.param(name, topic, message, words, id=f'{topic}-{words}', marks=statement(number))
    for number, name, topic, message, words in (
        ('FWD-6', 'velocity_stream', 'commands', Float64MultiArray(data=[INF] * 6), 'inf for'),
        ('FWD-6', 'effort_stream', 'commands', Float64MultiArray(data=[1.0]), '1 values'),
        ('FWD-6', 'named_stream', 'commands', Float64MultiArray(data=[NAN, 0.0]), 'nan for'),
        ('CHN-2', 'loop', 'reference',
         MultiDOFCommand(dof_names=['nobody'], values=[1.0]), "'nobody' is not controlled"),
        ('CHN-2', 'loop', 'reference', MultiDOFCommand(values=[1.0]), '1 values for 6 names'),
        ('CHN-2', 'loop', 'reference',
         MultiDOFCommand(dof_names=['joint_1'], values=[INF]), 'values [inf'),
        ('CHN-3', 'soft', 'joint_references',
         JointTrajectoryPoint(positions=[INF] * 6), 'position [inf'),
        ('CHN-3', 'soft', 'joint_references',
         JointTrajectoryPoint(velocities=[1.0]), 'velocity [1.0]'),
        ('CHN-3', 'soft', 'joint_references',
         JointTrajectoryPoint(positions=[NAN] * 6), 'no value for'),
    )
]


@pytest.mark.parametrize(('name', 'topic', 'message', 'words'), CONTROLLERS)
def test_controllers(arm: Streamed, name: str, topic: str, message: Any, words: str) -> None:
    """A controller that takes commands drops garbage with a warning, and stays active."""
    arm.use(name)
    before, marker = arm.positions, len(arm.program.text)
    with arm.publisher(type(message), f'{NAMESPACE}/{name}/{topic}') as publisher:
        arm.stream_until(publisher, message, lambda: words in arm.program.text[marker:],
                         f'the log has: {words}')
    arm.rest(0.2)
    np.testing.assert_allclose(arm.positions, before, atol=2e-3)
    arm.use(ARM)  # strictly: it fails where the other one is no longer active


@statement('SRV-11')
@pytest.mark.parametrize(
    ('kind', 'message', 'words'),
    [
        (JOG, JointJog(joint_names=['nobody'], velocities=[1.0]), "'nobody' is not a joint"),
        (JOG, JointJog(joint_names=['joint_1']), 'velocities has 0'),
        (JOG, JointJog(joint_names=['joint_1'], velocities=[NAN]), 'velocities'),
        (POSE, pose(0, 0, 0, 0, 0, 0, 0), 'quaternion'),
        (POSE, pose(NAN, 0, 0, 0, 0, 0, 1), 'pose.position'),
        (POSE, pose(0, 0, 0, 0, 0, 0, 1, frame=''), 'frame_id is empty'),
        (POSE, pose(0, 0, 0, 0, 0, 0, 1, frame='nowhere'), "'nowhere'"),
    ],
)
def test_servo(arm: Streamed, kind: int, message: Any, words: str) -> None:
    """servo_node refuses garbage and says so in its status."""
    assert arm.choose(kind)
    before = arm.positions
    arm.forget()
    publisher = arm.jog if kind == JOG else arm.pose
    arm.stream_until(publisher, message, arm.has_said(words, -1), f'the status has: {words}')
    arm.rest(0.2)
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)


@statement('SRV-3')
@pytest.mark.parametrize('kind', [-128, -1, 3, 127])
def test_types_that_do_not_exist(arm: Streamed, kind: int) -> None:
    """They are refused, the log lists the others, and the chosen one stays."""
    assert arm.choose(JOG)
    marker = len(arm.program.text)
    assert not arm.choose(kind)
    arm.until(
        lambda: f'{kind} is not a command type' in arm.program.text[marker:], 'the log says so')
    before = arm.positions
    arm.stream_until(arm.jog, JointJog(joint_names=['joint_6'], velocities=[1.0]),
                     arm.has_moved(before, 0.02), 'the joint moves')
    arm.rest()


@statement('SRV-3', 'SRV-22')
def test_pauses_in_any_order(arm: Streamed) -> None:
    """Each is answered in words; garbage that comes meanwhile moves nothing and ends no pause."""
    assert arm.choose(JOG)
    before = arm.positions
    for name, kind, request in (
        ('stop_servo', Trigger, Trigger.Request()), ('stop_servo', Trigger, Trigger.Request()),
        ('pause_servo', SetBool, SetBool.Request(data=False)),
        ('start_servo', Trigger, Trigger.Request()),
        ('pause_servo', SetBool, SetBool.Request(data=True)),
        ('stop_servo', Trigger, Trigger.Request()),
    ):
        answer = arm.client.call(f'/servo_node/{name}', kind, request)
        assert answer.success
        assert answer.message
    arm.forget()
    for message in (JointJog(joint_names=['joint_1'], velocities=[NAN]),
                    JointJog(joint_names=['joint_1'], velocities=[1.0])):
        arm.stream(arm.jog, message, 0.2)
    arm.until(arm.has_said('paused', 0), 'it is still paused')
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)


@statement('CHN-2')
@pytest.mark.parametrize('active', [False, True])
def test_feedforward(arm: Streamed, active: bool) -> None:
    """Switched to what it is already, or while the loop is inactive, it moves nothing."""
    if active:
        arm.use('loop')
    before = arm.positions
    for wanted in (True, True, False, False):
        answer = arm.client.call(
            f'{NAMESPACE}/loop/set_feedforward_control', SetBool, SetBool.Request(data=wanted))
        assert answer.success
        assert ('on' if wanted else 'off') in answer.message.split()
    arm.rest(0.1)
    np.testing.assert_allclose(arm.positions, before, atol=2e-3)
    arm.use(ARM)


@statement('MTC-3')
@pytest.mark.parametrize(
    ('positions', 'words'),
    [([[NAN] * 6, [0.0] * 6], 'finite'), ([[0.0] * 5, [0.0] * 6], 'position')],
)
def test_tasks(arm: Streamed, positions: list[list[float]], words: str) -> None:
    """A solution with garbage is refused as a whole, and the part is named."""
    client = PatientActionClient(arm.client.node, ExecuteTaskSolution, '/execute_task_solution')
    assert client.wait_for_server(10.0)
    before = arm.positions
    bad = SubTrajectory()
    points = [JointTrajectoryPoint(positions=values) for values in positions]
    points[1].time_from_start.sec = 1
    bad.trajectory.joint_trajectory = JointTrajectory(joint_names=list(JOINTS), points=points)
    goal = ExecuteTaskSolution.Goal(solution=Solution(sub_trajectory=[bad]))
    handle = arm.client.result(client.send_goal_async(goal))
    result = arm.client.result(handle.get_result_async(), 30.0).result
    assert result.error_code.val < 0
    assert 'part 0 of 1' in result.error_code.message
    assert words in result.error_code.message.lower()
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)
    arm.client.in_executor(client.destroy)
