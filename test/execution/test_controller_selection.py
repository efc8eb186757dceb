# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the choice of controllers and of splitting trajectories."""

from dataclasses import replace

import numpy as np
import pytest

from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import PlanningError
from armsim_ros.execution.controller_selection import (
    actuated,
    controlled_joints,
    coverage_report,
    select_controllers,
    split_trajectory,
)
from armsim_ros.model.robot_model import Mimic
from armsim_ros.trajectory import JointTrajectory


def controller(name, *joints, default=False):
    """Return a FollowJointTrajectory controller."""
    return MoveItControllerSettings(name=name, joints=joints, default=default)


WHOLE = controller('whole', 'a', 'b', 'c')
LEFT, RIGHT = controller('left', 'a', 'b'), controller('right', 'c')


def names(selected):
    """Return the names of controllers as a set."""
    return {each.name for each in selected}


def test_the_fewest_controllers():
    """EXE-3: one controller that has all joints goes before two."""
    assert names(select_controllers('abc', [LEFT, RIGHT, WHOLE])) == {'whole'}


def test_several_controllers_together():
    """EXE-3: two controllers together where none has all joints."""
    assert names(select_controllers('abc', [LEFT, RIGHT])) == {'left', 'right'}


def test_no_joint_twice():
    """EXE-3: controllers that share a joint are not combined."""
    with pytest.raises(PlanningError, match='share joints'):
        select_controllers('abc', [LEFT, controller('other', 'b', 'c')])


def test_default_goes_first():
    """EXE-3: among equals the default controller."""
    preferred = controller('preferred', 'a', 'b', 'c', default=True)
    assert names(select_controllers('abc', [WHOLE, preferred])) == {'preferred'}


def test_fewer_surplus_joints():
    """EXE-3: then the one that has fewer joints beside those that are needed."""
    assert names(select_controllers('ab', [WHOLE, LEFT])) == {'left'}


def test_active_goes_first():
    """EXE-3: then the one that is active."""
    twin = controller('twin', 'a', 'b', 'c')
    assert names(select_controllers('abc', [WHOLE, twin], active={'twin'})) == {'twin'}


def test_active_controllers_go_before_fewer():
    """
    Where inactive controllers cannot be activated, active ones are used even if they are more.

    Upstream: trajectory_execution_manager.cpp, selectControllers.
    """
    running = {'left', 'right'}
    assert names(select_controllers('abc', [LEFT, RIGHT, WHOLE], active=running)) == running
    assert names(select_controllers(
        'abc', [LEFT, RIGHT, WHOLE], active=running, manages=True)) == {'whole'}
    preferred = controller('preferred', 'a', 'b', 'c', default=True)
    assert names(select_controllers('abc', [WHOLE, preferred], active={'whole'})) == {'whole'}


def test_alphabet_decides_at_last():
    """
    Among equals the first by name is used, whatever the order of the file.

    Upstream: trajectory_execution_manager.cpp, findControllers over a map of names.
    """
    twins = [controller('b', 'x'), controller('a', 'x')]
    assert names(select_controllers('x', twins)) == {'a'}
    assert names(select_controllers('x', twins, names=('b', 'a'))) == {'b'}


def test_no_controller_fits():
    """SEED-9a: the message has the words that users search for, and the missing joint."""
    with pytest.raises(PlanningError) as caught:
        select_controllers('abd', [LEFT, RIGHT])
    text = str(caught.value)
    assert caught.value.code == -4
    assert ('Unable to identify any set of controllers that can actuate the specified joints: '
            '[ a b d ]') in text
    assert 'Known controllers and their joints:' in text
    assert "controller 'left' controls joints: a, b" in text
    assert 'no controller has d' in text


def test_named_controllers_only():
    """ACT-12: controllers that are named explicitly are the only ones that are used."""
    assert names(select_controllers('ab', [LEFT, WHOLE], names=('whole',))) == {'whole'}


def test_unknown_name():
    """ACT-12: a name that is not known is refused with the known ones."""
    with pytest.raises(PlanningError, match="'lft' is not known; did you mean 'left'"):
        select_controllers('ab', [LEFT], names=('lft',))


def test_parts_have_their_joints_and_the_same_times():
    """EXE-4: each controller gets its own joints, all get the same times."""
    positions, velocities = np.outer(range(3), [1.0, 2.0, 3.0]), np.full((3, 3), [4.0, 5.0, 6.0])
    whole = JointTrajectory(('c', 'a', 'b'), np.array([0.0, 0.5, 1.0]), positions, velocities)
    parts = {each.name: part for each, part in split_trajectory(whole, [LEFT, RIGHT])}
    assert parts['left'].joint_names == ('a', 'b')
    assert parts['left'].positions.tolist() == [[0, 0], [2, 3], [4, 6]]
    assert parts['left'].velocities[1].tolist() == [5, 6]
    assert parts['right'].positions.tolist() == [[0], [1], [2]]
    assert parts['right'].accelerations is None
    assert parts['left'].times.tolist() == parts['right'].times.tolist() == [0, 0.5, 1]


def test_joints_of_a_part_are_in_order():
    """
    A part has its joints in the order of the alphabet.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    whole = JointTrajectory(('b', 'a'), np.array([0.0]), np.array([[1.0, 2.0]]))
    ((_, part),) = split_trajectory(whole, [LEFT])
    assert part.joint_names == ('a', 'b')
    assert part.positions.tolist() == [[2.0, 1.0]]


def test_velocity_scaling_changes_velocities_only():
    """
    The factor multiplies the velocities of the points; times and accelerations stay.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    whole = JointTrajectory(
        ('a',), np.array([0.0, 1.0]), np.array([[0.0], [1.0]]), np.array([[0.0], [2.0]]),
        np.array([[0.0], [3.0]]))
    ((_, part),) = split_trajectory(whole, [LEFT], velocity=0.5)
    assert part.velocities.tolist() == [[0.0], [1.0]]
    assert part.accelerations.tolist() == [[0.0], [3.0]]
    assert part.times.tolist() == [0.0, 1.0]


def test_fixed_joints_need_no_controller(planar):
    """EXE-2: only joints that move by themselves are asked for."""
    assert controlled_joints(('axis1', 'mount', 'axis2'), planar.robot) == ('axis1', 'axis2')


def test_a_trajectory_of_unknown_joints(planar):
    """ACT-13: an unknown joint is refused by name."""
    with pytest.raises(PlanningError, match="'axis9', which robot 'planar' lacks"):
        controlled_joints(('axis9',), planar.robot)


def test_a_trajectory_without_movable_joints(planar):
    """EXE-2: nothing that could be moved is refused."""
    with pytest.raises(PlanningError, match='names no joint'):
        controlled_joints(('mount',), planar.robot)


def test_coverage_names_what_is_missing(planar):
    """Each group whose joints no controller has is reported with the YAML to add."""
    report = coverage_report(planar.robot, [controller('some', 'axis1', 'axis2')])
    assert len(report) == 1
    assert "group 'arm'" in report[0]
    assert 'joints: [axis3]' in report[0]
    assert not coverage_report(planar.robot, [controller('all', 'axis1', 'axis2', 'axis3')])


def test_coverage_leaves_passive_joints_out(planar):
    """
    A group whose other joints a controller has can be moved; a passive joint needs none.

    Upstream: trajectory_execution_manager.cpp, configure and ensureActiveControllersForJoints.
    """
    robot = planar.robot
    for passive in (('axis3',), ('axis1', 'axis2', 'axis3')):
        model = replace(robot, semantic=replace(robot.semantic, passive_joints=passive))
        assert not coverage_report(model, [controller('some', 'axis1', 'axis2')])


def test_one_controller_for_each_of_many_joints():
    """
    As many controllers as it takes.

    Upstream: trajectory_execution_manager.cpp, selectControllers.
    """
    joints = [f'joint_{number}' for number in range(12)]
    singles = [controller(f'{name}_controller', name) for name in joints]
    pairs = [controller('first_two', *joints[:2]), controller('overlap', *joints[1:3])]
    chosen = names(select_controllers(joints, [*singles, *pairs]))
    assert chosen == {'first_two', *(f'{name}_controller' for name in joints[2:])}


def test_only_actuated_joints_are_sent(planar):
    """
    A mimic joint and a passive one follow, whatever a recorded trajectory says of them.

    Upstream: trajectory_execution_manager.cpp, distributeTrajectory.
    """
    robot = planar.robot
    follower = replace(robot.joints['axis3'], mimic=Mimic('axis1', 1.0, 0.0))
    with_mimic = replace(robot, joints={**robot.joints, 'axis3': follower})
    passive = replace(robot, semantic=replace(robot.semantic, passive_joints=('axis3',)))
    whole = JointTrajectory(
        ('axis3', 'axis1', 'axis2'), np.array([0.0]), np.array([[3.0, 1.0, 2.0]]))
    for model in (with_mimic, passive):
        part = actuated(whole, model)
        assert part.joint_names == ('axis1', 'axis2')
        assert part.positions.tolist() == [[1.0, 2.0]]
