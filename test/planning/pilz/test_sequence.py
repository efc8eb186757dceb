# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sequences of commands, with stops and with blends."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.transforms import pose_from_parts
from armsim_ros.planning.pilz.sequence import SequenceItem
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.update import StartState

CORNERS = ((0.0, 0.15, 0.0), (0.0, 0.15, 0.12), (0.0, 0.0, 0.12))
RADIUS = 0.05
TIP = 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


def line(bench: Any, corner: tuple[float, ...], radius: float = 0.0, **options: Any) -> Any:
    """Return a linear motion to a corner."""
    slow = {'max_velocity_scaling_factor': 0.05}
    request = bench.request('LIN', bench.at(bench.moved(*corner)), **{**slow, **options})
    return SequenceItem(request, radius)


def around(bench: Any, radius: float) -> Any:
    """Return the answer to three lines around two corners."""
    first, second, third = CORNERS
    return bench.sequence(
        line(bench, first, radius), line(bench, second, radius), line(bench, third)
    )


def distances(bench: Any, trajectory: Any, corner: tuple[float, ...]) -> Any:
    """Return how far the tip is from a corner along a trajectory (k,)."""
    return np.linalg.norm(bench.tips(trajectory) - bench.moved(*corner)[:3, 3], axis=1)


def test_nothing_is_a_success(bench: Any) -> None:
    """PLZ-8: an empty list gives no trajectory and no error."""
    answer = bench.sequence()
    assert (answer.error_code, answer.trajectories) == (MoveItErrorCode.SUCCESS, ())


def test_without_radii_it_stops_at_every_corner(bench: Any) -> None:
    """One trajectory through all goals, at rest in each."""
    answer = around(bench, 0.0)
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    (trajectory,) = answer.trajectories
    assert answer.start == pytest.approx(bench.model.positions(bench.q))
    for corner in CORNERS:
        assert distances(bench, trajectory, corner).min() < 2e-3
    assert np.sum(np.abs(trajectory.velocities).max(axis=1) < 1e-9) == 4


def test_a_blend_rounds_its_corner_without_a_stop(bench: Any) -> None:
    """The tip passes within the radius, on both lines outside of it, and never stands still."""
    stopping = around(bench, 0.0)
    answer = around(bench, RADIUS)
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    (trajectory,) = answer.trajectories
    for corner in CORNERS[:2]:
        assert 0.005 < distances(bench, trajectory, corner).min() < RADIUS
    assert distances(bench, trajectory, CORNERS[2])[-1] < 1e-4
    assert np.abs(trajectory.velocities[1:-1]).max(axis=1).min() > 1e-3
    assert trajectory.duration < stopping.trajectories[0].duration
    outside = bench.tips(trajectory) - bench.pose[:3, 3]
    assert np.abs(outside[:, 0]).max() < 2e-3


def test_a_blend_keeps_the_limits_at_its_points(bench: Any) -> None:
    """
    Points of the blend are 0.1 s apart, and their differences keep the joint limits.

    pilz, trajectory_blender_transition_window.cpp, blend.
    """
    (trajectory,) = around(bench, RADIUS).trajectories
    steps = np.diff(trajectory.times)
    assert steps.min() > 0.0
    assert steps.max() <= 0.1 + 1e-9
    speed = np.diff(trajectory.positions, axis=0) / steps[:, None]
    rate = np.diff(speed, axis=0) / (0.5 * (steps[1:] + steps[:-1]))[:, None]
    index = bench.model.group_indices('manipulator')
    assert (np.abs(speed) <= bench.model.velocity_limits[index]).all()
    assert (np.abs(rate) <= bench.model.acceleration_limits[index] * 1.001).all()


def test_a_blend_begins_and_ends_at_the_sphere(bench: Any) -> None:
    """
    Points outside of the sphere are those of the motions without blend.

    pilz, trajectory_blender_transition_window.cpp, searchIntersectionPoints.
    """
    first, second = CORNERS[:2]
    apart = [bench.run('LIN', bench.at(bench.moved(*first)), max_velocity_scaling_factor=0.05)]
    (blended,) = bench.sequence(
        line(bench, first, RADIUS), line(bench, second)).trajectories
    tips = np.array([
        bench.model.link_pose(bench.model.insert(bench.q, 'manipulator', values), TIP)[:3, 3]
        for values in blended.positions])
    away = np.linalg.norm(tips - bench.moved(*first)[:3, 3], axis=1)
    entered = int(np.argmax(away <= RADIUS))
    assert blended.positions[:entered] == pytest.approx(
        apart[0].trajectory.positions[:entered], abs=1e-9)
    assert blended.times[:entered] == pytest.approx(apart[0].trajectory.times[:entered])


def test_commands_of_all_kinds_follow_each_other(bench: Any) -> None:
    """
    A PTP blends into a LIN; the pipeline of the first motion plans the second, too.

    pilz, move_group_sequence_action.cpp, planUsingSequenceManager.
    """
    first = SequenceItem(bench.request('PTP', bench.at(bench.moved(*CORNERS[0]))), RADIUS)
    answer = bench.sequence(first, line(bench, CORNERS[1], pipeline_id='nowhere'))
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    assert 0.0 < distances(bench, answer.trajectories[0], CORNERS[0]).min() < RADIUS


@pytest.mark.parametrize('radius', [0.0, 0.02])
@pytest.mark.parametrize('rounds', [1, 2])
def test_a_sequence_of_all_kinds(bench: Any, radius: float, rounds: int) -> None:
    """
    PTP, CIRC, LIN and PTP, with and without blends, once and repeated, are one trajectory.

    Upstream: integrationtest_sequence_service_capability.cpp, TestComplexSequenceWithoutBlending,
    TestComplexSequenceWithBlending, TestLargeRequest.
    """
    corners = [(0.0, 0.15, 0.0), (-0.08, 0.23, 0.0), (-0.08, 0.23, 0.1)]
    slow = {'max_velocity_scaling_factor': 0.05}
    first, second, third = (bench.at(bench.moved(*corner)) for corner in corners)
    center = bench.at(bench.moved(0.0, 0.23, 0.0), name='center')
    items = [
        SequenceItem(bench.request('PTP', first), radius),
        SequenceItem(bench.request('CIRC', second, path_constraints=center, **slow), radius),
        SequenceItem(bench.request('LIN', third, **slow), radius),
        SequenceItem(bench.request('PTP', bench.joints(START))),
    ]
    answer = bench.sequence(*items * rounds)
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    (trajectory,) = answer.trajectories
    assert trajectory.positions[-1] == pytest.approx(START, abs=1e-6)
    for corner in corners:
        nearest = distances(bench, trajectory, corner).min()
        assert (1e-4 < nearest < radius) if radius else nearest < 2e-3


def test_a_sequence_that_lacks_a_motion(bench: Any) -> None:
    """
    An arc whose centre does not fit where the motion before it ends fails the sequence.

    Upstream: integrationtest_sequence_action.cpp, TestInvalidCmd.
    """
    center = bench.at(bench.moved(0.0, 0.23, 0.0), name='center')
    answer = bench.sequence(line(bench, CORNERS[2]), SequenceItem(bench.request(
        'CIRC', bench.at(bench.moved(-0.08, 0.23, 0.0)), path_constraints=center)))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert 'motion 1' in answer.message
    assert not answer.trajectories


@pytest.mark.parametrize(('radii', 'said'), [
    ((-0.1, 0.0, 0.0), 'motion 0 is -0.1'),
    ((math.nan, 0.0, 0.0), 'motion 0 is nan'),
    ((0.0, 0.0, 0.05), 'last motion is 0.05'),
    ((0.08, 0.05, 0.0), 'after motion 0 and after motion 1 overlap'),
])
def test_radii_that_cannot_be(bench: Any, radii: tuple[float, ...], said: str) -> None:
    """PLZ-8: negative, overlapping, or at the end: -2 with the motion and the numbers."""
    answer = bench.sequence(*(
        line(bench, corner, radius) for corner, radius in zip(CORNERS, radii, strict=True)))
    assert answer.error_code == MoveItErrorCode.INVALID_MOTION_PLAN
    assert said in answer.message
    assert answer.trajectories == ()


def test_a_radius_beyond_the_motion(bench: Any) -> None:
    """PLZ-8: where the blend would begin before its motion does: 99999."""
    answer = bench.sequence(line(bench, (0.0, 0.02, 0.0), 0.05), line(bench, CORNERS[0]))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert 'the first motion lies within the blend radius 0.05 m' in answer.message


def test_a_blend_that_is_too_fast(bench: Any) -> None:
    """
    A sharp corner at speed is 99999, with joint and remedy.

    pilz, plan_components_builder.cpp, blend.
    """
    first, second = CORNERS[:2]
    fast = {'max_velocity_scaling_factor': 0.2, 'max_acceleration_scaling_factor': 0.3}
    answer = bench.sequence(line(bench, first, 0.03, **fast), line(bench, second, **fast))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert 'the blend before motion 1' in answer.message
    assert 'max_velocity_scaling_factor' in answer.message


def test_motions_of_different_sampling_times_are_not_blended(bench: Any) -> None:
    """
    A blend needs motions with the same even sampling time: 99999 for those of OMPL.

    pilz, trajectory_functions.cpp, determineAndCheckSamplingTime.
    """
    answer = bench.sequence(*(
        line(bench, corner, radius, pipeline_id='ompl')
        for corner, radius in zip(CORNERS[:2], (0.05, 0.0), strict=True)))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert 'the blend before motion 1: blending failed' in answer.message


def test_a_blend_of_motions_with_a_limited_speed(bench: Any) -> None:
    """
    max_cartesian_speed, which upstream ignores, does not make a blend fail; both lines keep it.

    pilz, trajectory_functions.cpp, determineAndCheckSamplingTime.
    """
    limit = 0.03
    answer = bench.sequence(
        line(bench, CORNERS[0], 0.04, max_cartesian_speed=limit),
        line(bench, CORNERS[1], max_cartesian_speed=limit))
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    (trajectory,) = answer.trajectories
    tips = bench.tips(trajectory)
    step = trajectory.duration / (len(tips) - 1)
    outside = np.linalg.norm(tips[1:] - bench.moved(*CORNERS[0])[:3, 3], axis=1) > 0.045
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1) / step
    assert speeds[outside].max() < 1.01 * limit


def test_a_cancelled_sequence_is_preempted(bench: Any) -> None:
    """
    A cancel while a motion is planned is PREEMPTED, not the code of a motion without a plan.

    Upstream: move_group_sequence_action.cpp, preemptMoveCallback.
    """
    answer = bench.planner.plan_sequence(
        (line(bench, CORNERS[0]), line(bench, CORNERS[1])), bench.scene.snapshot(),
        clock=time.monotonic, cancelled=lambda: True)
    assert answer.error_code == MoveItErrorCode.PREEMPTED
    assert not answer.trajectories


def test_the_plans_of_a_failed_sequence(bench: Any) -> None:
    """
    The answer has the plan of each motion up to the one that failed, with its code.

    pilz, command_list_manager.cpp, solveSequenceItems: generatePlan publishes each of them.
    """
    far = line(bench, (5.0, 0.0, 0.0))
    answer = bench.sequence(line(bench, CORNERS[0]), far, line(bench, CORNERS[1]))
    assert [plan.error_code for plan in answer.plans] == [
        MoveItErrorCode.SUCCESS, MoveItErrorCode.NO_IK_SOLUTION]


def test_overlap_of_two_motions_is_allowed(bench: Any) -> None:
    """
    Only radii between three motions or more can overlap.

    pilz, command_list_manager.cpp, checkForOverlappingRadii.
    """
    answer = bench.sequence(line(bench, CORNERS[0], 0.149), line(bench, CORNERS[1]))
    assert answer.error_code != MoveItErrorCode.INVALID_MOTION_PLAN


def test_sequences_that_stay_where_they_are(bench: Any) -> None:
    """
    Motions to the place where the robot is leave one point at 0.1 s.

    pilz, plan_components_builder.cpp, appendWithStrictTimeIncrease.
    """
    here = SequenceItem(bench.request('PTP', bench.joints(START)))
    (trajectory,) = bench.sequence(here, here).trajectories
    assert trajectory.times.tolist() == [0.1]


def test_the_pipeline_may_be_given(bench: Any) -> None:
    """
    All motions are planned by one pipeline, whatever they name; an unknown one is 99999.

    pilz, move_group_sequence_service.cpp, plan.
    """
    answer = bench.planner.plan_sequence(
        (line(bench, CORNERS[0]),), bench.scene.snapshot(), clock=time.monotonic,
        pipeline='nowhere')
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert "'nowhere' is not known" in answer.message


def test_only_the_first_motion_gives_a_start_state(bench: Any) -> None:
    """PLZ-8: -17 for a start state where the motion before it ends."""
    there = StartState.from_positions({'elbow_joint': 1.0})
    answer = bench.sequence(line(bench, CORNERS[0]), line(bench, CORNERS[1], start_state=there))
    assert answer.error_code == MoveItErrorCode.INVALID_ROBOT_STATE
    assert "motion 1 gives a start state, but group 'manipulator'" in answer.message


def test_the_first_start_state_is_where_it_begins(bench: Any) -> None:
    """The whole sequence starts from it, not from the scene."""
    there = {**bench.model.positions(bench.q), 'wrist_3_joint': 0.5}
    answer = bench.sequence(
        SequenceItem(bench.request('PTP', bench.at(bench.moved(*CORNERS[0])),
                                   start_state=StartState.from_positions(there))),
        line(bench, CORNERS[1]),
    )
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    assert answer.trajectories[0].positions[0, 5] == pytest.approx(0.5)


def test_a_motion_without_a_plan_is_named(bench: Any) -> None:
    """
    Whatever a motion fails with is 99999 for the sequence; the message has number and code.

    pilz, command_list_manager.cpp, solveSequenceItems.
    """
    answer = bench.sequence(line(bench, CORNERS[0]), line(bench, (5.0, 0.0, 0.0)))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert answer.message.startswith('motion 1: NO_IK_SOLUTION: ')


def test_a_blend_that_hits_something(bench: Any) -> None:
    """Both lines are free, what lies inside the corner is not: -2 with what it would touch."""
    ahead = np.array([0.0, 0.0, 0.15])
    bench.scene.apply_attached(AttachedObject(
        TIP,
        CollisionObject(
            'feeler', frame_id=TIP, pose=pose_from_parts(ahead, np.eye(3)),
            shapes=(ObjectShape(Sphere(0.005)),))))
    motions = (line(bench, CORNERS[0], 0.08), line(bench, CORNERS[1]))
    free = bench.sequence(*motions)
    assert free.error_code == MoveItErrorCode.SUCCESS, free.message
    nearest = np.argmin(distances(bench, free.trajectories[0], CORNERS[0]))
    tip = bench.tips(free.trajectories[0])[nearest]
    bench.scene.apply_object(CollisionObject(
        'post', pose=pose_from_parts(tip + bench.pose[:3, :3] @ ahead, np.eye(3)),
        shapes=(ObjectShape(Sphere(0.003)),)))
    stops = bench.sequence(line(bench, CORNERS[0]), line(bench, CORNERS[1]))
    assert stops.error_code == MoveItErrorCode.SUCCESS, stops.message
    answer = bench.sequence(*motions)
    assert answer.error_code == MoveItErrorCode.INVALID_MOTION_PLAN
    assert "'post'" in answer.message
    assert 'the blend before motion 1' in answer.message


def test_every_motion_carries_what_the_first_one_does(bench: Any) -> None:
    """An object of the first start state is still in the hand in the second motion."""
    ahead = np.array([0.0, 0.0, 0.15])
    feeler = AttachedObject(
        TIP,
        CollisionObject(
            'feeler', frame_id=TIP, pose=pose_from_parts(ahead, np.eye(3)),
            shapes=(ObjectShape(Sphere(0.005)),)))
    middle = bench.moved(0.0, 0.15, 0.06)[:3, 3] + bench.pose[:3, :3] @ ahead
    bench.scene.apply_object(CollisionObject(
        'post', pose=pose_from_parts(middle, np.eye(3)), shapes=(ObjectShape(Sphere(0.003)),)))
    first, second = CORNERS[:2]
    empty = bench.sequence(line(bench, first), line(bench, second))
    assert empty.error_code == MoveItErrorCode.SUCCESS, empty.message
    holding = StartState(attached_objects=(feeler,))
    answer = bench.sequence(line(bench, first, start_state=holding), line(bench, second))
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert answer.message.startswith('motion 1: INVALID_MOTION_PLAN: ')
    assert "'post'" in answer.message
