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


@pytest.fixture
def path(model, ready):
    """Return a trajectory of three waypoints, 1 s apart."""
    message = RobotTrajectoryMessage()
    message.joint_trajectory.joint_names = ['panda_joint1', 'panda_joint2']
    for k, (first, second) in enumerate([(0.0, -0.7), (0.4, -0.5), (0.8, -0.7)]):
        point = JointTrajectoryPoint(positions=[first, second], velocities=[0.1 * k, 0.0])
        point.time_from_start.sec = k
        message.joint_trajectory.points.append(point)
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
    assert path.get_robot_trajectory_msg().joint_trajectory.points[2].positions.tolist() == [
        0.8, -0.7]


def test_a_message_for_another_robot_is_refused(path, ready):
    """Upstream aborts the process."""
    message = path.get_robot_trajectory_msg()
    message.joint_trajectory.joint_names = ['a', 'b']
    with pytest.raises(PlanningError, match="'a'"):
        path.set_robot_trajectory_msg(ready, message)
    message.joint_trajectory.joint_names = ['panda_joint1']
    with pytest.raises(ValueError, match='2 positions for 1 joints'):
        path.set_robot_trajectory_msg(ready, message)


def test_reversed(path):
    """It ends where it began, and its velocities point the other way."""
    assert path.__reverse__() is path
    assert [state.joint_positions['panda_joint1'] for state in path] == [0.8, 0.4, 0.0]
    assert path[0].joint_velocities['panda_joint1'] == pytest.approx(-0.2)
    assert path.duration == 2.0


def test_continuous_joints_are_unwound(tmp_path):
    """A jump by a full turn goes; a joint with bounds keeps its values."""
    urdf, srdf = tmp_path / 'turns.urdf', tmp_path / 'turns.srdf'
    urdf.write_text(
        '<robot name="turns"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<joint name="bend" type="revolute"><parent link="b"/><child link="c"/>'
        '<limit lower="-7" upper="7" effort="1" velocity="1"/></joint></robot>')
    srdf.write_text('<robot name="turns"/>')
    model, message = RobotModel(str(urdf), str(srdf)), RobotTrajectoryMessage()
    message.joint_trajectory.joint_names = ['turn', 'bend']
    for k, angle in enumerate((3.0, -3.0)):
        message.joint_trajectory.points.append(JointTrajectoryPoint(positions=[angle, angle]))
        message.joint_trajectory.points[-1].time_from_start.sec = k
    made = RobotTrajectory(model).set_robot_trajectory_msg(RobotState(model), message)
    assert made.unwind() is made
    assert made[1].joint_positions == pytest.approx({'turn': 2.0 * np.pi - 3.0, 'bend': -3.0})


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
