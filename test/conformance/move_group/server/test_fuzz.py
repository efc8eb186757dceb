# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random messages: no crash, no hang, no half of a refused change.

``--fuzz N`` sends N messages of each kind; the answer to every one is looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
import math
from typing import Any

from move_group_bench import name_of
from moveit_msgs.msg import (
    AllowedCollisionMatrix,
    AttachedCollisionObject,
    CollisionObject,
    MotionPlanRequest,
    PositionIKRequest,
)
from moveit_msgs.srv import (
    GetCartesianPath,
    GetMotionPlan,
    GetPlannerParams,
    GetPlanningScene,
    GetPositionFK,
    GetPositionIK,
    GetStateValidity,
    SetPlannerParams,
)
import pytest
from wire import at, box, carried, pose_goal, quiet_diff, robot_state, tetrahedron, thing

from benchmarks.endurance.random_messages import RandomMessages

DEFAULT = 30
LONGEST = 0.15


@pytest.fixture
def messages(running: Any) -> RandomMessages:
    """Give messages with texts that mean something to the server."""
    return RandomMessages((
        running.group, running.frame, running.tip, *running.links[:3], *running.group_joints[:3],
        'crate', 'tool', 'crate/handle', 'ompl', 'RRTConnect', 'PTP', 'LIN', 'CIRC', 'center',
        'pilz_industrial_motion_planner',
    ))


@pytest.fixture
def fuzz(
    pytestconfig: pytest.Config, running: Any, rules: Any, server: Any, messages: RandomMessages
) -> Iterator[Callable[..., None]]:
    """Give a function that tries many messages; afterwards the server has to work as before."""
    def run(judge: Callable[[Any], None], *patterns: Any) -> None:
        for _ in range(int(pytestconfig.getoption('fuzz', None) or DEFAULT)):
            judge(messages.like(*patterns))

    running.clear(rules)
    furnish(running)
    yield run
    running.clear(rules)
    assert running.planned(running.near()).points
    if server.program is not None:
        text = server.program.text
        assert 'Traceback' not in text
        assert 'internal error' not in text
        assert server.program.process.poll() is None


def furnish(arm: Any) -> None:
    """Put an object into the world and one onto the robot."""
    crate = thing('crate', arm.frame, [box(0.1, 0.1, 0.1), tetrahedron(0.1)], pose=at(2.0))
    crate.subframe_names, crate.subframe_poses = ['handle'], [at(0.0, 0.1)]
    assert arm.add(crate)
    tool = thing('tool', arm.tip, [box(0.02, 0.02, 0.02)], pose=at(0.0, 0.0, 0.1))
    assert arm.attach(carried(tool, arm.tip, arm.links))


def contents(arm: Any) -> str:
    """Return all of the scene but the joints; as text, in which not-a-number equals itself."""
    scene = arm.scene()
    return repr((
        scene.name, scene.world, scene.allowed_collision_matrix, scene.link_padding,
        scene.link_scale, scene.object_colors, scene.robot_state.attached_collision_objects,
        scene.fixed_frame_transforms,
    ))


def finite(pose: Any) -> bool:
    """Return whether a pose has only numbers."""
    return all(map(math.isfinite, (
        pose.position.x, pose.position.y, pose.position.z, pose.orientation.x,
        pose.orientation.y, pose.orientation.z, pose.orientation.w,
    )))


def judge_plan(code: Any, trajectory: Any) -> None:
    """Check that a trajectory comes with SUCCESS alone, and a sentence with all else."""
    if name_of(code) == 'SUCCESS':
        assert trajectory.joint_trajectory.points
        for point in trajectory.joint_trajectory.points:
            assert all(map(math.isfinite, point.positions))
    else:
        assert not trajectory.joint_trajectory.points
        assert code.message
        assert code.source


@pytest.mark.statement('ERR-2', 'ERR-0.1')
def test_plan_requests(fuzz: Any, running: Any) -> None:
    """Any request is answered in time, with a trajectory or with code, sentence and source."""
    good = running.request(pose_goal(running.tip, running.pose()))
    state = running.positions()
    other = running.request({name: state[name] + 0.1 for name in running.group_joints})

    def judge(message: Any) -> None:
        if not message.allowed_planning_time <= LONGEST:
            message.allowed_planning_time = LONGEST
        message.num_planning_attempts = min(message.num_planning_attempts, 2)
        request = GetMotionPlan.Request(motion_plan_request=message)
        answer = running.client.call(
            running.name('plan_kinematic_path'), GetMotionPlan, request, 30.0
        ).motion_plan_response
        judge_plan(answer.error_code, answer.trajectory)

    fuzz(judge, MotionPlanRequest, good, other)


@pytest.mark.statement('SCN-2a', 'ERR-2')
def test_collision_objects(fuzz: Any, running: Any) -> None:
    """A refused object leaves the scene as it was; one that is taken has numbers only."""
    good = thing('crate', running.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))

    def judge(message: Any) -> None:
        before = contents(running)
        if not running.add(message):
            assert contents(running) == before
        for item in running.objects().values():
            assert finite(item.pose)
            assert all(map(finite, (*item.primitive_poses, *item.mesh_poses)))

    fuzz(judge, CollisionObject, good)


@pytest.mark.statement('SCN-8', 'ERR-2')
def test_attached_objects(fuzz: Any, running: Any) -> None:
    """A refused attached object leaves the scene as it was."""
    tool = thing('tool', running.tip, [box(0.02, 0.02, 0.02)], pose=at(0.0, 0.0, 0.1))
    good = carried(tool, running.tip, [running.tip])

    def judge(message: Any) -> None:
        before = contents(running)
        if not running.attach(message):
            assert contents(running) == before

    fuzz(judge, AttachedCollisionObject, good)


@pytest.mark.statement('SCN-13a', 'ERR-2')
def test_matrices_and_full_scenes(fuzz: Any, running: Any, rules: Any) -> None:
    """A refused matrix leaves the rules; scenes with anything in them are answered."""
    def judge(message: Any) -> None:
        if isinstance(message, AllowedCollisionMatrix):
            scene = quiet_diff()
            scene.allowed_collision_matrix = message
            before = contents(running)
            if not running.apply(scene):
                assert contents(running) == before
        else:
            running.apply(message)
            running.scene()

    fuzz(judge, AllowedCollisionMatrix, rules.allowed_collision_matrix, type(rules), rules)


@pytest.mark.statement('SRV-1', 'ERR-2')
def test_ik_requests(fuzz: Any, running: Any) -> None:
    """Any request for inverse kinematics is answered; a solution comes with SUCCESS alone."""
    good = PositionIKRequest(group_name=running.group, pose_stamped=running.pose())

    def judge(message: Any) -> None:
        message.timeout.sec, message.timeout.nanosec = 0, message.timeout.nanosec % 50_000_000
        answer = running.client.call(
            running.name('compute_ik'), GetPositionIK, GetPositionIK.Request(ik_request=message)
        )
        solved = name_of(answer.error_code) == 'SUCCESS'
        assert solved == bool(answer.solution.joint_state.name)
        assert solved or answer.error_code.message

    fuzz(judge, PositionIKRequest, good)


@pytest.mark.statement('SRV-10', 'SRV-20', 'SRV-50', 'SRV-61', 'SRV-62', 'ERR-2')
def test_questions(fuzz: Any, running: Any) -> None:
    """fk, validity, scene parts and planner parameters are answered whatever is asked."""
    kinds = {
        'compute_fk': GetPositionFK, 'check_state_validity': GetStateValidity,
        'get_planning_scene': GetPlanningScene, 'get_planner_params': GetPlannerParams,
        'set_planner_params': SetPlannerParams,
    }
    by_request = {kind.Request: (running.name(name), kind) for name, kind in kinds.items()}
    state = GetStateValidity.Request(
        group_name=running.group, robot_state=robot_state(running.positions())
    )
    fuzz(lambda message: running.client.call(*by_request[type(message)], message),
         *by_request, state)


@pytest.mark.statement('SRV-31', 'SRV-34', 'ERR-2')
def test_cartesian_requests(fuzz: Any, running: Any) -> None:
    """Any request for a Cartesian path is answered, with a fraction from 0 to 1."""
    pose = running.pose().pose
    pose.position.z -= 0.02
    good = GetCartesianPath.Request(
        group_name=running.group, waypoints=[pose], max_step=0.01, avoid_collisions=True
    )

    def judge(message: Any) -> None:
        if 0.0 < message.max_step < 1e-3:
            message.max_step = 1e-3
        answer = running.client.call(
            running.name('compute_cartesian_path'), GetCartesianPath, message, 30.0
        )
        assert 0.0 <= answer.fraction <= 1.0
        if name_of(answer.error_code) != 'SUCCESS':
            assert not answer.solution.joint_trajectory.points
            assert answer.error_code.message

    fuzz(judge, GetCartesianPath.Request, good)
