# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The scene that a request is planned in: the monitored one with the request's differences."""

from __future__ import annotations

import json
from pathlib import Path
import sys
from typing import Any

from move_group_bench import name_of
from moveit_msgs.msg import CollisionObject, MoveItErrorCodes, PlanningScene
import pytest
from wire import at, box, carried, quiet_diff, removal, robot_state, thing

from armsim_ros.testing.program import Program, ros_environment


def tool(arm: Any) -> Any:
    """Return a box in front of the tip that may touch the arm."""
    return carried(
        thing('tool', arm.tip, [box(0.02, 0.02, 0.02)], pose=at(0.0, 0.0, 0.3)), arm.tip,
        arm.links)


def wall(arm: Any, goal: Any, link: str) -> CollisionObject:
    """Return a small box at the place that a link or object has at a goal."""
    return thing('wall', arm.frame, [box(0.03, 0.03, 0.03)], pose=arm.pose(goal, link).pose)


@pytest.mark.statement('X4', 'M1', 'M2')
@pytest.mark.parametrize('carries', [False, True])
def test_a_client_that_fills_in_the_request_alone(
    arm: Any, server: Any, carries: bool
) -> None:
    """
    A goal with a default-constructed scene difference is planned among all objects there are.

    moveit_ros plan_execution.cpp, planning_scene_monitor.cpp (copyPlanningScene).
    """
    goal = arm.near(0.4)
    if carries:
        assert arm.attach(tool(arm))
    assert arm.add(wall(arm, goal, 'tool' if carries else arm.tip))
    before = arm.positions()
    words = json.dumps({'namespace': arm.namespace, 'group': arm.group, 'goal': goal})
    script = str(Path(__file__).with_name('plain_goals.py'))
    environment = ros_environment(server.domain)
    with Program([sys.executable, script, words], environment=environment) as program:
        program.wait(100.0)
    said = [line.split(' ', 2) for line in program.output if line]
    assert len(said) == 5, program.output
    for name, code, message in said:
        assert int(code) != MoveItErrorCodes.SUCCESS, name
        assert 'wall' in message, name
    assert arm.positions() == pytest.approx(before, abs=2e-3)
    assert set(arm.objects()) == {'wall'}
    assert set(arm.attached()) == ({'tool'} if carries else set())


@pytest.mark.statement('X4', 'M1')
@pytest.mark.parametrize('is_diff', [False, True])
def test_a_difference_is_laid_over_the_scene_whatever_its_is_diff(
    arm: Any, is_diff: bool
) -> None:
    """
    The objects of the difference and those of the scene both count, for this request alone.

    moveit_ros planning_scene_monitor.cpp, copyPlanningScene.
    """
    goal = arm.near(0.4)
    scene = PlanningScene(is_diff=is_diff)
    scene.world.collision_objects = [wall(arm, goal, arm.tip)]
    assert arm.move(goal, plan_only=True, planning_scene_diff=scene).code == 'GOAL_IN_COLLISION'
    assert not arm.objects()
    assert arm.add(wall(arm, goal, arm.tip))
    scene.world.collision_objects = [
        thing('other', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0))]
    assert arm.move(goal, plan_only=True, planning_scene_diff=scene).code == 'GOAL_IN_COLLISION'
    scene.world.collision_objects = [removal('wall')]
    assert arm.move(goal, plan_only=True, planning_scene_diff=scene).code == 'SUCCESS'


@pytest.mark.statement('X6')
def test_what_a_difference_cannot_do_is_named_in_the_answer(arm: Any) -> None:
    """
    The rest of the difference counts; the answer and one line of the log name what does not.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    goal = arm.near(0.4)
    scene = quiet_diff()
    scene.world.collision_objects = [removal('nobody')]
    ended = arm.move(goal, plan_only=True, planning_scene_diff=scene)
    assert ended.code == 'SUCCESS'
    assert 'nobody' in ended.result.error_code.message
    scene.world.collision_objects = [removal('nobody'), wall(arm, goal, arm.tip)]
    ended = arm.move(goal, plan_only=True, planning_scene_diff=scene)
    assert ended.code == 'GOAL_IN_COLLISION'
    assert 'nobody' in ended.result.error_code.message


@pytest.mark.statement('M3')
@pytest.mark.parametrize('plan_only', [True, False])
def test_the_robot_state_of_a_difference_counts_for_plans_alone(
    arm: Any, plan_only: bool
) -> None:
    """
    A plan that is executed begins where the robot is, with what it carries.

    moveit_ros move_action_capability.cpp, move_group_capability.cpp (clearSceneRobotState).
    """
    here, goal = arm.positions(), arm.near(0.4)
    scene = PlanningScene()
    first = arm.group_joints[0]
    scene.robot_state = robot_state({first: here[first] + 0.1})
    scene.robot_state.attached_collision_objects = [tool(arm)]
    ended = arm.move(goal, plan_only=plan_only, planning_scene_diff=scene)
    assert ended.code == 'SUCCESS'
    start = ended.result.trajectory_start
    began = dict(zip(start.joint_state.name, start.joint_state.position, strict=True))[first]
    assert began == pytest.approx(here[first] + (0.1 if plan_only else 0.0), abs=5e-3)
    assert len(start.attached_collision_objects) == int(plan_only)


@pytest.mark.statement('M2', 'M22')
def test_only_a_difference_without_content_lets_a_goal_be_satisfied_already(arm: Any) -> None:
    """
    At the goal a default-constructed difference is planned with, an empty one ends the request.

    moveit_core message_checks.cpp; moveit_ros move_action_capability.cpp.
    """
    here = {name: arm.positions()[name] for name in arm.group_joints}
    ended = arm.move(here, planning_scene_diff=quiet_diff())
    assert (ended.code, ended.feedback) == ('SUCCESS', ['IDLE'])
    ended = arm.move(here, planning_scene_diff=PlanningScene())
    assert ended.code == 'SUCCESS'
    assert 'PLANNING' in ended.feedback


@pytest.mark.statement('M14')
def test_attached_objects_of_a_start_state_need_shapes_and_poses(arm: Any) -> None:
    """
    REMOVE makes an attached object vanish for the request; an ADD without poses is refused.

    moveit_core conversions.cpp, msgToAttachedBody.
    """
    goal = arm.near(0.4)
    assert arm.attach(tool(arm))
    assert arm.add(wall(arm, goal, 'tool'))
    assert name_of(arm.refused(goal)) == 'GOAL_IN_COLLISION'
    start = robot_state(None)
    start.attached_collision_objects = [tool(arm)]
    start.attached_collision_objects[0].object = removal('tool')
    answer = arm.plan(goal, start_state=start)
    assert name_of(answer.error_code) == 'SUCCESS'
    assert not answer.trajectory_start.attached_collision_objects
    bare = tool(arm)
    bare.object.id = 'bare'
    start.attached_collision_objects.append(bare)
    answer = arm.plan(goal, start_state=start)
    assert name_of(answer.error_code) == 'SUCCESS'
    assert "'bare'" in answer.error_code.message
    assert set(arm.attached()) == {'tool'}
