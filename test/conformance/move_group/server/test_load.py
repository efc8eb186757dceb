# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Nobody waits for the long work of another: everything is answered while a plan takes long."""

from __future__ import annotations

from collections.abc import Callable
import threading
import time
from typing import Any

from motions import until_moving
from move_group_bench import CANCELED, name_of
from moveit_msgs.msg import CollisionObject
from moveit_msgs.srv import GetPositionFK, GetPositionIK
from planners import set_planner
import pytest
from rclpy.qos import QoSHistoryPolicy, QoSProfile
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from wire import at, box, quiet_diff, removal, thing

#: How long an answer may take that must not hang [s]; what it really takes is for benchmarks.
PATIENCE = 10.0
SLOW = {'max_velocity_scaling_factor': 0.05, 'max_acceleration_scaling_factor': 0.3}


def in_time(call: Callable[[], Any]) -> Any:
    """Return what a call returns, which must not take long."""
    began = time.monotonic()
    answer = call()
    assert time.monotonic() - began < PATIENCE
    return answer


@pytest.mark.statement('SRV-51', 'SRV-62', 'PAR-1')
def test_settings_edits_and_questions_during_a_plan(arm: Any, long_plan: Any) -> None:
    """Parameters, planner settings, scene edits and queries never wait for a plan."""
    for k in range(5):
        in_time(lambda: set_planner(arm, 'EST', range='0.1'))
        assert in_time(lambda k=k: arm.parameters.set('planning_seed', k)) == ''
        assert in_time(lambda: arm.add(thing('crate', arm.frame, [box(.1, .1, .1)], pose=at(2.))))
        assert in_time(lambda: name_of(arm.fk([arm.tip]).error_code)) == 'SUCCESS'
        assert in_time(lambda: arm.validity(arm.positions())).valid
        assert 'crate' in in_time(arm.objects)
        assert in_time(lambda: arm.add(removal('crate')))
    assert arm.parameters.set('planning_seed', -1) == ''


@pytest.mark.statement('ACT-5', 'ACT-6', 'UT-1')
def test_a_motion_is_cancelled_during_a_plan(arm: Any, long_plan: Any) -> None:
    """Whatever else is being worked at, a cancelled motion stops."""
    goal = {name: value + 0.5 for name, value in arm.positions().items()
            if name in arm.group_joints}
    trajectory = straight(arm, goal, 10.0)
    handle = arm.send_execute(trajectory)
    until_moving(arm)
    in_time(lambda: arm.cancel(handle))
    before = arm.positions()
    assert in_time(lambda: arm.ended(handle)).status == CANCELED
    arm.joint_states.clear()
    arm.joint_states.wait(10)
    now = arm.positions()
    assert max(abs(value - before[name]) for name, value in now.items()) < 0.05


@pytest.mark.statement('ACT-5', 'UT-1')
def test_a_plan_that_waits_for_another_can_be_cancelled(arm: Any, long_plan: Any) -> None:
    """A goal whose planning has not begun ends when it is cancelled, not after the other."""
    second = arm.send_move(arm.near(0.1), plan_only=True)
    in_time(lambda: arm.cancel(second))
    ended = in_time(lambda: arm.ended(second))
    assert (ended.status, ended.code) == (CANCELED, 'PREEMPTED')


@pytest.mark.statement('SRV-1')
def test_a_burst_of_questions(arm: Any) -> None:
    """Three hundred requests at once are all answered."""
    node = arm.client.node
    every = QoSProfile(history=QoSHistoryPolicy.KEEP_ALL)
    client = node.create_client(GetPositionFK, arm.name('compute_fk'), qos_profile=every)
    assert client.wait_for_service(5.0)
    arm.client.settle()
    request = GetPositionFK.Request(fk_link_names=[arm.tip])
    pending = [client.call_async(request) for _ in range(300)]
    answers = [arm.client.result(one, 15.0, 'answer of compute_fk') for one in pending]
    assert {name_of(answer.error_code) for answer in answers} == {'SUCCESS'}
    arm.client.in_executor(lambda: node.destroy_client(client))


@pytest.mark.statement('SRV-1', 'SRV-10')
def test_inverse_kinematics_without_end_delays_nobody(arm: Any) -> None:
    """A timeout of 1000 s is cut, with a warning, and others are answered meanwhile."""
    request = GetPositionIK.Request()
    request.ik_request.group_name = arm.group
    request.ik_request.robot_state.is_diff = True
    request.ik_request.pose_stamped = arm.pose()
    request.ik_request.pose_stamped.pose.position.x += 50.0
    request.ik_request.timeout.sec = 1000
    client = arm.client.node.create_client(GetPositionIK, arm.name('compute_ik'))
    assert client.wait_for_service(5.0)
    pending = client.call_async(request)
    for _ in range(5):
        assert in_time(lambda: arm.validity(arm.positions())).valid
        assert in_time(lambda: name_of(arm.ik(pose_stamped=arm.pose()).error_code)) == 'SUCCESS'
    assert not pending.done()
    answer = arm.client.result(pending, 15.0, 'answer of compute_ik')
    assert name_of(answer.error_code) == 'NO_IK_SOLUTION'
    arm.client.in_executor(lambda: arm.client.node.destroy_client(client))


@pytest.mark.alone
@pytest.mark.statement('SCN-1', 'SRV-51')
def test_a_scene_of_ten_thousand_objects(arm: Any) -> None:
    """It is taken in seconds; meanwhile motions are watched and questions answered."""
    scene = quiet_diff()
    scene.world.collision_objects = [
        thing(f'item {k}', arm.frame, [box(.01, .01, .01)], pose=at(3. + k % 100, k // 100))
        for k in range(10_000)
    ]
    longest = [0.0]
    done = threading.Event()

    def ask() -> None:
        while not done.is_set():
            began = time.monotonic()
            arm.fk([arm.tip])
            longest[0] = max(longest[0], time.monotonic() - began)

    asking = threading.Thread(target=ask)
    asking.start()
    try:
        assert arm.apply(scene)
        assert arm.add(removal('item 7'))
    finally:
        done.set()
        asking.join()
    assert longest[0] < 2.0 * PATIENCE
    assert arm.validity(arm.positions()).valid
    assert arm.planned(arm.near()).points
    assert arm.add(CollisionObject(operation=CollisionObject.REMOVE))
    assert not arm.objects()


def straight(arm: Any, goal: dict[str, float], seconds: int) -> Any:
    """Return a trajectory straight to a goal, which a client makes itself."""
    now = arm.positions()
    names = list(goal)
    first = JointTrajectoryPoint(positions=[now[name] for name in names])
    last = JointTrajectoryPoint(positions=[goal[name] for name in names])
    last.time_from_start.sec = int(seconds)
    return JointTrajectory(joint_names=names, points=[first, last])
