# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Waypoints, their times, and the timing of a path."""

from types import SimpleNamespace

from moveit_msgs.msg import RobotTrajectory as RobotTrajectoryMessage
import numpy as np
import pytest
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.errors import PlanningError
from armsim_ros.moveit_py import utils
from moveit.core.robot_model import RobotModel
from moveit.core.robot_state import RobotState
from moveit.core.robot_trajectory import RobotTrajectory

pytestmark = pytest.mark.statement('C6')


def trajectory_message(joint_names, rows, times=range(10), velocities=None):
    """Return the message of waypoints with these positions at these times [s]."""
    message = RobotTrajectoryMessage()
    message.joint_trajectory.joint_names = joint_names
    for row, time, rates in zip(rows, times, velocities or [[]] * len(rows), strict=False):
        point = JointTrajectoryPoint(positions=row, velocities=rates)
        point.time_from_start.sec = int(time)
        point.time_from_start.nanosec = round(time % 1 * 1e9)
        message.joint_trajectory.points.append(point)
    return message


@pytest.fixture(scope='module')
def turning(tmp_path_factory):
    """Return a robot with two continuous joints and one that has bounds beyond a turn."""
    folder = tmp_path_factory.mktemp('turning')
    urdf, srdf = folder / 'turns.urdf', folder / 'turns.srdf'
    urdf.write_text(
        '<robot name="turns"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>'
        '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/>'
        '<limit effort="1" velocity="1"/></joint>'
        '<joint name="bend" type="revolute"><parent link="b"/><child link="c"/>'
        '<limit lower="-7" upper="7" effort="1" velocity="1"/></joint>'
        '<joint name="tool" type="continuous"><parent link="c"/><child link="d"/>'
        '<limit effort="1" velocity="1"/></joint></robot>')
    srdf.write_text(
        '<robot name="turns"><group name="arm"><joint name="turn"/><joint name="bend"/></group>'
        '</robot>')
    return RobotModel(str(urdf), str(srdf))


def turning_path(model, rows, group=''):
    """Return a trajectory with these positions of turn, bend and tool, 1 s apart."""
    made = RobotTrajectory(model).set_robot_trajectory_msg(
        RobotState(model), trajectory_message(['turn', 'bend', 'tool'], rows))
    made.joint_model_group_name = group
    return made


@pytest.fixture
def path(model, ready):
    """Return a trajectory of three waypoints, 1 s apart."""
    message = trajectory_message(
        ['panda_joint1', 'panda_joint2'], [[0.0, -0.7], [0.4, -0.5], [0.8, -0.7]],
        velocities=[[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]])
    made = RobotTrajectory(model)
    assert made.set_robot_trajectory_msg(robot_state=ready, msg=message) is made
    made.joint_model_group_name = 'panda_arm'
    return made


def test_waypoints_are_states(path, ready):
    """By number, from the end too, and in a loop, alone or with their duration."""
    assert len(path) == 3
    assert isinstance(path[1], RobotState)
    assert path[-1].joint_positions['panda_joint1'] == 0.8
    assert path[-1].joint_velocities['panda_joint1'] == pytest.approx(0.2)
    assert path[0].joint_positions['panda_joint4'] == ready.joint_positions['panda_joint4']
    assert [state.joint_positions['panda_joint1'] for state in path] == [0.0, 0.4, 0.8]
    assert [duration for _, duration in path] == path.get_waypoint_durations() == [0.0, 1.0, 1.0]
    with pytest.raises(IndexError, match='3 waypoints'):
        path[3]


def test_a_waypoint_is_a_copy(path):
    """What is done to it does not change the trajectory."""
    path[0].joint_positions = {'panda_joint1': 1.0}
    assert path[0].joint_positions['panda_joint1'] == 0.0


def test_durations(path, model):
    """Of the whole and between waypoints; an empty trajectory has none."""
    assert path.duration == 2.0
    assert path.average_segment_duration == 1.0
    empty = RobotTrajectory(model)
    assert (len(empty), empty.duration, empty.average_segment_duration) == (0, 0.0, 0.0)
    assert empty.get_waypoint_durations() == []


def test_the_message_may_be_of_some_joints(path, model):
    """A filter chooses columns; the header has the model frame."""
    message = path.get_robot_trajectory_msg(['panda_joint2'])
    assert message.joint_trajectory.joint_names == ['panda_joint2']
    assert message.joint_trajectory.header.frame_id == model.model_frame
    assert path.get_robot_trajectory_msg(['finger']) == RobotTrajectoryMessage()
    assert RobotTrajectory(model).get_robot_trajectory_msg() == RobotTrajectoryMessage()


def test_the_group_selects_the_joints(model, ready):
    """
    All active joints of it, in the order of the model, whatever the message named.

    robot_trajectory.cpp: getRobotTrajectoryMsg. Joints that the message lacks are where the
    state has them; joints outside of the group and mimic joints are left out.
    """
    made = RobotTrajectory(model).set_robot_trajectory_msg(ready, trajectory_message(
        ['panda_joint2', 'panda_finger_joint2', 'panda_finger_joint1', 'panda_joint1'],
        [[-0.7, 0.0, 0.0, 0.0], [-0.5, 0.04, 0.04, 0.4]], velocities=[[0.1] * 4, []]))
    joints = made.get_robot_trajectory_msg().joint_trajectory
    assert joints.joint_names == [*(f'panda_joint{k}' for k in range(1, 8)), 'panda_finger_joint1']
    made.joint_model_group_name = 'panda_arm'
    joints = made.get_robot_trajectory_msg().joint_trajectory
    others = [ready.joint_positions[f'panda_joint{k}'] for k in range(3, 8)]
    assert joints.joint_names == [f'panda_joint{k}' for k in range(1, 8)]
    assert [point.positions.tolist() for point in joints.points] == [
        [0.0, -0.7, *others], [0.4, -0.5, *others]]
    assert [point.velocities.tolist() for point in joints.points] == [
        [0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0], []]
    assert made[1].joint_positions['panda_finger_joint2'] == 0.04


def test_timing_moves_the_joints_of_the_group(model, ready):
    """
    The others stay where they are at the first waypoint.

    time_optimal_trajectory_generation.cpp: doTimeParameterizationCalculations.
    """
    made = RobotTrajectory(model).set_robot_trajectory_msg(ready, trajectory_message(
        ['panda_joint1', 'panda_finger_joint1'], [[0.0, 0.01], [0.4, 0.04]]))
    made.joint_model_group_name = 'panda_arm'
    assert made.apply_totg_time_parameterization(1.0, 1.0)
    assert made[-1].joint_positions['panda_joint1'] == pytest.approx(0.4)
    assert made[-1].joint_positions['panda_joint4'] == ready.joint_positions['panda_joint4']
    assert made[-1].joint_positions['panda_finger_joint1'] == 0.01


def test_the_stamp_of_a_message_is_not_kept(path, ready):
    """Durations alone are (robot_trajectory.cpp: setRobotTrajectoryMsg): it begins at once."""
    message = path.get_robot_trajectory_msg()
    message.joint_trajectory.header.stamp.sec = 1000
    path.set_robot_trajectory_msg(ready, message)
    assert path.get_robot_trajectory_msg().joint_trajectory.header.stamp.sec == 0


def test_a_message_for_another_robot_is_refused(path, ready):
    """Upstream aborts the process, or reads positions that are not there."""
    for names, rows, fault in (
            (['a', 'b'], [[0.0, 0.0]], "'a'"),
            (['panda_joint1'], [[0.0, 0.0]], '2 positions for 1 joints'),
            (['panda_joint1'], [[0.0], []], 'point 1 has no positions')):
        with pytest.raises((PlanningError, ValueError), match=fault):
            path.set_robot_trajectory_msg(ready, trajectory_message(names, rows))
    assert path.duration == 2.0


def test_reversed(path):
    """It ends where it began, and its velocities point the other way."""
    assert path.__reverse__() is path
    assert [state.joint_positions['panda_joint1'] for state in path] == [0.8, 0.4, 0.0]
    assert path[0].joint_velocities['panda_joint1'] == pytest.approx(-0.2)
    assert path.duration == 2.0


def test_a_first_waypoint_that_is_not_at_the_start(model, ready):
    """
    The time before it counts, and stays where it is in the reversed trajectory.

    robot_trajectory.cpp: getAverageSegmentDuration, reverse.
    """
    made = RobotTrajectory(model).set_robot_trajectory_msg(ready, trajectory_message(
        ['panda_joint1'], [[0.0], [0.1], [0.2]], [0.5, 1.5, 2.0]))
    assert made.average_segment_duration == pytest.approx(2.0 / 3.0)
    made.__reverse__()
    assert made.get_waypoint_durations() == pytest.approx([0.5, 0.5, 1.0])
    assert made.duration == 2.0
    single = RobotTrajectory(model).set_robot_trajectory_msg(
        ready, trajectory_message(['panda_joint1'], [[0.0]], [0.5]))
    assert single.average_segment_duration == 0.5


def test_continuous_joints_are_unwound(turning):
    """A jump by a full turn goes; a joint with bounds keeps its values."""
    made = turning_path(turning, [[3.0, 3.0, 0.0], [-3.0, -3.0, 0.0]])
    assert made.unwind() is made
    assert made[1].joint_positions == pytest.approx(
        {'turn': 2.0 * np.pi - 3.0, 'bend': -3.0, 'tool': 0.0})


def test_an_unwound_trajectory_begins_within_half_a_turn_of_0(turning):
    """Continuous joints of the group only (robot_trajectory.cpp: unwind)."""
    made = turning_path(turning, [[7.0, 6.5, 7.0], [7.2, 6.7, 7.2]], 'arm').unwind()
    assert made[0].joint_positions == pytest.approx(
        {'turn': 7.0 - 2.0 * np.pi, 'bend': 6.5, 'tool': 7.0})
    assert made[1].joint_positions == pytest.approx(
        {'turn': 7.2 - 2.0 * np.pi, 'bend': 6.7, 'tool': 7.2})


@pytest.mark.parametrize('timing', ['apply_totg_time_parameterization', 'apply_ruckig_smoothing'])
def test_a_path_is_unwound_before_it_is_timed(turning, timing):
    """
    A continuous joint takes the short way across half a turn.

    time_optimal_trajectory_generation.cpp: doTimeParameterizationCalculations;
    ruckig_traj_smoothing.cpp: runRuckig.
    """
    made = turning_path(turning, [[each, 0.0, 0.0] for each in (3.0, 3.1, -3.1, -3.0)], 'arm')
    assert getattr(made, timing)(1.0, 1.0)
    angles = [state.joint_positions['turn'] for state in made]
    assert min(angles) == pytest.approx(3.0)
    assert max(angles) == pytest.approx(2.0 * np.pi - 3.0)


def test_timing_is_optimal_and_keeps_the_limits(path):
    """It begins and ends at rest, and half the speed takes longer."""
    assert path.apply_totg_time_parameterization(1.0, 1.0)
    fast = path.duration
    assert path[-1].joint_positions['panda_joint1'] == pytest.approx(0.8)
    assert path[0].joint_velocities['panda_joint1'] == 0.0
    assert path[-1].joint_velocities['panda_joint1'] == pytest.approx(0.0, abs=1e-9)
    assert np.diff(path.get_waypoint_durations()[1:-1]) == pytest.approx(0.0, abs=1e-9)
    bounds = path.robot_model.get_joint_model_group('panda_arm').active_joint_model_bounds
    assert max(abs(state.joint_velocities['panda_joint1']) for state in path) <= \
        bounds[0][0].max_velocity
    assert path.apply_totg_time_parameterization(0.5, 0.5, resample_dt=0.05)
    assert path.duration > fast
    assert path.average_segment_duration <= 0.05 + 1e-9


def test_smoothing_keeps_a_jerk_limit(path, monkeypatch):
    """What has no limit gets 1000 rad/s^3; an argument that is not used is logged once."""
    lines = []
    monkeypatch.setattr(utils, 'logger', lambda: SimpleNamespace(warning=lines.append))
    monkeypatch.setattr(utils, '_reported', set())
    assert path.apply_totg_time_parameterization(1.0, 1.0, resample_dt=0.02)
    for _ in range(2):
        assert path.apply_ruckig_smoothing(
            1.0, 1.0, mitigate_overshoot=True, overshoot_threshold=0.02)
    assert len(lines) == 1
    assert 'mitigate_overshoot is not used' in lines[0]
    acceleration = np.array([state.joint_accelerations['panda_joint1'] for state in path])
    jerk = np.diff(acceleration) / np.array(path.get_waypoint_durations()[1:])
    assert np.abs(jerk).max() < 1000.0
    assert path[-1].joint_positions['panda_joint1'] == pytest.approx(0.8)


def test_a_trajectory_without_group_is_not_timed(path):
    """The group has the limits; an unknown group is refused."""
    with pytest.raises(PlanningError, match='panda_arm'):
        path.joint_model_group_name = 'arm'
    path.joint_model_group_name = ''
    assert path.apply_totg_time_parameterization(1.0, 1.0) is False
    assert path.duration == 2.0


def test_a_path_of_a_point_needs_no_time(path, model, ready):
    """Nor does a trajectory without waypoints."""
    message = path.get_robot_trajectory_msg()
    message.joint_trajectory.points = message.joint_trajectory.points[:1]
    path.set_robot_trajectory_msg(ready, message)
    assert path.apply_totg_time_parameterization(1.0, 1.0)
    assert (len(path), path.duration) == (1, 0.0)
    empty = RobotTrajectory(model)
    empty.joint_model_group_name = 'panda_arm'
    assert empty.apply_totg_time_parameterization(1.0, 1.0)
