# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Plans of a script."""

from types import SimpleNamespace

from ball_message import ball_message
from geometry_msgs.msg import PoseStamped
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, Constraints, MoveItErrorCodes
import numpy as np
import pytest

from armsim_ros.moveit_py import planning_component, utils
from moveit.core.kinematic_constraints import construct_joint_constraint
from moveit.core.robot_state import RobotState
from moveit.planning import (
    MultiPipelinePlanRequestParameters,
    PlanningComponent,
    PlanRequestParameters,
)


def goal_state(moveit, **joints):
    """Return a state near 'ready'."""
    state = RobotState(moveit.get_robot_model())
    assert state.set_to_default_values('panda_arm', 'ready')
    state.joint_positions = joints
    return state


@pytest.mark.statement('B4')
def test_named_states(arm):
    """A group has its states; an unknown one is False for a goal, an error for its values."""
    assert arm.planning_group_name == 'panda_arm'
    assert arm.named_target_states == ['ready', 'extended']
    assert arm.get_named_target_state_values('ready')['panda_joint4'] == -2.356
    assert arm.set_goal_state(configuration_name='up') is False
    assert arm.set_start_state('up') is False
    with pytest.raises(ValueError, match='ready, extended'):
        arm.get_named_target_state_values('up')


@pytest.mark.statement('A7', 'B4')
def test_an_unknown_group(moveit):
    """The error lists the groups."""
    with pytest.raises(RuntimeError, match='panda_arm, hand'):
        PlanningComponent('arm', moveit)


@pytest.mark.statement('B4')
def test_the_start_is_the_present_state_unless_another_is_set(moveit, arm, panda):
    """A given state is copied."""
    present = arm.get_start_state().joint_positions
    assert present['panda_joint4'] == pytest.approx(panda.positions['panda_joint4'])
    state = goal_state(moveit, panda_joint1=0.3)
    assert arm.set_start_state(robot_state=state)
    state.joint_positions = {'panda_joint1': 0.6}
    assert arm.get_start_state().joint_positions['panda_joint1'] == 0.3
    arm.set_start_state_to_current_state()
    assert arm.get_start_state().joint_positions == present


@pytest.mark.statement('B4')
@pytest.mark.parametrize('arguments', [
    {}, {'configuration_name': 'ready', 'motion_plan_constraints': []},
    {'pose_stamped_msg': PoseStamped()}, {'pose_link': 'panda_link8', 'configuration_name': 'up'}])
def test_a_goal_is_exactly_one(arm, arguments):
    """None, two, or a pose without its link are refused."""
    with pytest.raises(ValueError, match=r'give exactly one|needs both'):
        arm.set_goal_state(**arguments)
    with pytest.raises(ValueError, match='exactly one'):
        arm.set_start_state()


@pytest.mark.statement('B4', 'B5')
def test_plans_to_all_kinds_of_goals(moveit, arm):
    """A state, the pose of a link, constraints; the plan begins at the start and ends there."""
    arm.set_start_state(robot_state=goal_state(moveit))
    target = goal_state(moveit, panda_joint1=0.5, panda_joint4=-2.0)
    pose = PoseStamped(pose=target.get_pose('panda_link8'))
    pose.header.frame_id = 'panda_link0'
    group = moveit.get_robot_model().get_joint_model_group('panda_arm')
    for goal in ({'robot_state': target},
                 {'motion_plan_constraints': [construct_joint_constraint(target, group)]},
                 {'pose_stamped_msg': pose, 'pose_link': 'panda_link8'}):
        assert arm.set_goal_state(**goal)
        response = arm.plan()
        assert response, response.error_code.message
        assert response.error_code.val == MoveItErrorCodes.SUCCESS
        assert response.planning_time > 0.0
        plan = response.trajectory
        assert plan.joint_model_group_name == 'panda_arm'
        assert plan[0].joint_positions == pytest.approx(arm.get_start_state().joint_positions)
        end = plan[-1].get_pose('panda_link8').position
        assert (end.x, end.y, end.z) == pytest.approx(
            (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z), abs=0.02)


@pytest.mark.statement('B5', 'D2')
def test_a_plan_that_fails_is_an_answer(moveit, arm, monitor):
    """No goal, a goal that collides, an impossible constraint: a code, not an exception."""
    response = arm.plan()
    assert not response
    assert response.trajectory is None
    assert response.error_code.val == MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS
    target = goal_state(moveit, panda_joint1=0.8)
    assert monitor.process_collision_object(ball_message(
        'panda_link0', 'ball', target.get_global_link_transform('panda_hand')[:3, 3]))
    arm.set_goal_state(robot_state=target)
    response = arm.plan()
    assert response.error_code.val != MoveItErrorCodes.SUCCESS
    assert "'ball'" in response.error_code.message
    arm.set_goal_state(motion_plan_constraints=[Constraints()])
    assert arm.plan().error_code.val == MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS


@pytest.mark.statement('B5')
def test_arguments_that_exclude_each_other(moveit, arm):
    """Both kinds of parameters, or a scene without any."""
    single = PlanRequestParameters(moveit, 'lin')
    several = MultiPipelinePlanRequestParameters(moveit, ['lin'])
    with pytest.raises(ValueError, match='not both'):
        arm.plan(single, several)
    with moveit.get_planning_scene_monitor().read_only() as scene, \
            pytest.raises(ValueError, match='single_plan_parameters'):
        arm.plan(planning_scene=scene)


@pytest.mark.statement('B6')
def test_parameters_of_a_plan(moveit, arm):
    """Those of a namespace, with upstream's defaults; they can be set."""
    slow, default = PlanRequestParameters(moveit, 'slow'), PlanRequestParameters(moveit, '')
    assert (slow.max_velocity_scaling_factor, slow.planning_time, slow.planning_attempts) == (
        0.1, 2.0, 5)
    assert (default.planning_attempts, default.planning_time, default.planner_id) == (1, 1.0, '')
    arm.set_goal_state(robot_state=goal_state(moveit, panda_joint1=0.5))
    fast = arm.plan(single_plan_parameters=default).trajectory.duration
    assert arm.plan(slow).trajectory.duration > 3.0 * fast
    slow.max_velocity_scaling_factor, slow.planning_pipeline = 1.0, ''
    assert arm.plan(slow).trajectory.duration < 2.0 * fast


@pytest.mark.statement('A7')
def test_parameters_that_are_not_used_are_logged(monkeypatch):
    """Once, with those that are known; a namespace without any has the defaults."""
    lines = []
    monkeypatch.setattr(utils, 'logger', lambda: SimpleNamespace(warning=lines.append))
    monkeypatch.setattr(utils, '_reported', set())
    script = SimpleNamespace(_cpp=SimpleNamespace(parameters={
        'a.plan_request_params.planning_attempt': 1, 'a.plan_request_params.planner_id': 'x'}))
    for _ in range(2):
        assert PlanRequestParameters(script, 'a').planner_id == 'x'
        assert PlanRequestParameters(script, 'b').planning_attempts == 5
    unused, absent = lines
    assert 'planning_attempt not used' in unused
    assert 'planning_attempts' in unused
    assert 'b.plan_request_params' in absent


@pytest.mark.statement('B7')
def test_several_pipelines(moveit, arm):
    """What is not available fails and does not disturb the others; the shortest plan wins."""
    arm.set_goal_state(robot_state=goal_state(moveit, panda_joint1=0.4))
    several = MultiPipelinePlanRequestParameters(moveit, ['slow', 'lin', 'other'])
    assert [each.planning_pipeline for each in several.multi_plan_request_parameters] == [
        'ompl', 'pilz_industrial_motion_planner', 'chomp']
    assert arm.plan(multi_plan_parameters=several)
    seen = []

    def last_plan(answers):
        seen.append([each.error_code.val for each in answers])
        return [each for each in answers if each][-1]


    assert arm.plan(
        multi_plan_parameters=several, solution_selection_function=last_plan).planner_id == 'PTP'
    assert seen == [[MoveItErrorCodes.SUCCESS] * 2 + [MoveItErrorCodes.FAILURE]]

    def enough(answers, requests):
        seen.append((len(answers), len(requests)))
        return bool(answers[-1])

    assert arm.plan(multi_plan_parameters=several, stopping_criterion_callback=enough)
    assert seen[-1] == (1, 3)


@pytest.mark.statement('B7')
def test_the_shortest_plan_is_taken():
    """In joint space, whatever it lasts; an answer without a plan only where there is no plan."""
    def answer(*positions):
        points = SimpleNamespace(positions=np.array(positions).reshape(-1, 1))
        return SimpleNamespace(trajectory=SimpleNamespace(_points=points))

    failed, detour, direct = SimpleNamespace(trajectory=None), answer(0.0, 2.0, 1.0), answer(0, 1)
    assert planning_component._shortest([failed, detour, direct]) is direct
    assert planning_component._shortest([failed]) is failed


@pytest.mark.statement('B5', 'B9')
def test_plans_in_a_scene_of_the_script(moveit, arm):
    """A copy of the scene, changed, decides; in a block, the scene of the block."""
    parameters = PlanRequestParameters(moveit, '')
    target = goal_state(moveit, panda_joint1=0.5)
    arm.set_goal_state(robot_state=target)
    place = target.get_global_link_transform('panda_hand')[:3, 3]
    with moveit.get_planning_scene_monitor().read_only() as scene:
        copied = scene.__copy__()
    copied.apply_collision_object(ball_message('panda_link0', 'ball', place))
    assert not arm.plan(parameters, planning_scene=copied)
    assert arm.plan(parameters)
    with moveit.get_planning_scene_monitor().read_write() as scene:
        scene.apply_collision_object(ball_message('panda_link0', 'ball', place))
        assert not arm.plan(parameters)
        scene.remove_all_collision_objects()
        assert arm.plan(parameters)


@pytest.fixture
def held_ball(monitor):
    """Return a function that has the robot carry a ball at a distance before its hand [m]."""
    held = AttachedCollisionObject(
        link_name='panda_hand', object=ball_message('panda_hand', 'held', (0.0, 0.0, 0.0)))

    def hold(distance):
        held.object.pose.position.z = distance
        assert monitor.process_attached_collision_object(held)

    yield hold
    held.object.operation = CollisionObject.REMOVE
    assert monitor.process_attached_collision_object(held)


@pytest.mark.statement('B5', 'B9')
def test_the_robot_carries_its_objects_in_a_scene_of_the_script(moveit, arm, monitor, held_ball):
    """
    Those of the monitor, also in a scene that was made before (planning_component.cpp).

    getMotionPlanRequest takes the whole present state; plan puts it into the scene.
    """
    parameters = PlanRequestParameters(moveit, '')
    target = goal_state(moveit, panda_joint1=0.5)
    arm.set_goal_state(robot_state=target)
    with monitor.read_only() as scene:
        before = scene.__copy__()
    hand = target.get_global_link_transform('panda_hand')
    before.apply_collision_object(ball_message(
        'panda_link0', 'ball', (hand @ [0.0, 0.0, 0.4, 1.0])[:3]))
    assert arm.plan(parameters, planning_scene=before)
    held_ball(0.4)
    response = arm.plan(parameters, planning_scene=before)
    assert not response
    assert "'held'" in response.error_code.message
    with monitor.read_only() as scene:
        carrying = scene.__copy__()
    assert arm.plan(parameters, planning_scene=carrying)


@pytest.mark.statement('B4')
def test_path_constraints_and_workspace(moveit, arm):
    """A constraint that the start does not keep is refused; a workspace limits no arm."""
    arm.set_goal_state(robot_state=goal_state(moveit, panda_joint1=0.5))
    group = moveit.get_robot_model().get_joint_model_group('panda_arm')
    arm.set_workspace(-0.1, -0.1, -0.1, 0.1, 0.1, 0.1)
    assert arm.plan()
    arm.unset_workspace()
    assert arm.set_path_constraints(
        construct_joint_constraint(goal_state(moveit, panda_joint4=-1.0), group))
    assert not arm.plan()
    arm.set_path_constraints(Constraints())
    assert arm.plan()
