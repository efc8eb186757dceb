# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where and when joints begin to follow a trajectory."""

import math

import numpy as np
import pytest

from armsim_ros.model.robot_model import JointType

MOVE = (1.0, [0.4, 0.0], [0, 0], [0, 0])


def test_start_from_the_measured_state_by_parameter(rig, trajectory):
    """E7, B9: interpolate_from_desired_state false starts where the arm is."""
    r = rig(gain=0.2)
    arm = r.arm(interpolate_from_desired_state=False)
    arm.set_trajectory(trajectory(MOVE))
    r.run(0.5)
    measured = r.hardware.state.position[0]
    arm.set_trajectory(trajectory(MOVE))
    r.step()
    assert arm.snapshot().reference.positions[0] == measured
    assert measured < 0.19


def test_future_stamp_waits(rig, trajectory):
    """E4: the arm holds until the stamp and reaches the first point at stamp + t1."""
    r = rig()
    arm = r.arm()
    stamp = r.now_ns + 500_000_000
    goal = arm.send_goal(trajectory(MOVE, stamp_ns=stamp)).goal
    r.run(0.5)
    assert goal.status.name == 'EXECUTING'
    np.testing.assert_array_equal(r.hardware.state.position, [0.0, 0.0])
    r.run(0.5)
    assert 0.1 < r.hardware.state.position[0] < 0.3
    r.run(0.52)
    assert goal.status.name == 'SUCCEEDED'


def test_future_stamp_keeps_the_old_motion(rig, trajectory):
    """E4, I5: until the stamp the old trajectory goes on; its goal is preempted at once."""
    r = rig()
    arm = r.arm()
    old = arm.send_goal(trajectory((1.0, [1.0, 0.0]))).goal
    r.run(0.2)
    arm.send_goal(trajectory((1.0, [0.0, 0.0]), stamp_ns=r.now_ns + 300_000_000))
    r.step()
    assert old.status.name == 'ABORTED'
    r.run(0.29)
    assert arm.snapshot().reference.positions[0] == pytest.approx(0.49)
    r.run(1.1)
    np.testing.assert_allclose(r.hardware.state.position, [0.0, 0.0], atol=1e-12)


def test_a_stream_whose_clock_is_ahead_moves_the_arm(rig, trajectory):
    """
    Short trajectories from the topic, each replaced before its stamp, still move the arm.

    So upstream's does, which begins at once whatever the stamp (joint_trajectory_controller.cpp,
    update; trajectory.cpp, sample before the first point).
    """
    r = rig()
    arm = r.arm()
    for k in range(200):
        arm.set_trajectory(trajectory(
            (0.05, [0.001 * k, 0.0]), stamp_ns=r.now_ns + 500_000_000))
        r.run(0.01)
    assert 0.05 < arm.snapshot().reference.positions[0] < 0.2
    r.run(1.0)
    np.testing.assert_allclose(r.hardware.state.position, [0.199, 0.0], atol=1e-9)


def test_canceled_while_it_waits(rig, trajectory):
    """I1: a goal that waits for its stamp can be canceled."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE, stamp_ns=r.now_ns + 500_000_000)).goal
    r.step()
    arm.cancel(goal)
    r.run(2.0)
    assert goal.status.name == 'CANCELED'
    np.testing.assert_array_equal(r.hardware.state.position, [0.0, 0.0])


def test_past_stamp_joins_without_a_jump(rig, trajectory):
    """E5: points of the past are dropped; the end comes at stamp + t_end."""
    r = rig()
    arm = r.arm()
    stamp = r.now_ns - 1_500_000_000
    goal = arm.send_goal(
        trajectory((1.0, [1.0, 0.0]), (2.0, [0.5, 0.0]), (3.0, [0.2, 0.0]), stamp_ns=stamp)
    ).goal
    references = []
    for _ in range(152):
        r.step()
        references.append(arm.snapshot().reference.positions[0])
    assert np.abs(np.diff(references)).max() <= 0.0101
    assert references[50] == pytest.approx(0.5)
    assert goal.status.name == 'SUCCEEDED'


def test_continuous_joint_never_steps(rig, trajectory):
    """G3: a target many turns away moves less than half a turn, without a step."""
    r = rig({'a': JointType.CONTINUOUS, 'b': JointType.REVOLUTE})
    arm = r.arm(constraints={'a': {'goal': 0.01, 'trajectory': 0.5}})
    goal = arm.send_goal(trajectory((1.0, [0.5 + 8 * math.pi, 0.0]))).goal
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'
    assert r.hardware.state.position[0] == pytest.approx(0.5)


@pytest.fixture
def blocked(rig, trajectory):
    """Return a rig whose joint a should be at 0.4 rad and is kept at 0.1, and its controller."""
    r = rig(gain=0.1)
    arm = r.arm()
    arm.set_trajectory(trajectory((0.5, [0.4, 0.0])))
    while r.hardware.state.position[0] < 0.1:
        r.step()
    r.hardware.frozen = True
    r.run(0.6)
    assert arm.snapshot().reference.positions[0] == 0.4
    return r, arm, r.hardware.state.position[0]


def test_a_plan_from_where_a_blocked_joint_stands(blocked, trajectory):
    """A joint that something blocks is led away from where it is, not from where it should be."""
    r, arm, stands = blocked
    goal = arm.send_goal(trajectory((0.0, [stands, 0.0]), (0.5, [-0.4, 0.0]))).goal
    r.step()
    assert arm.snapshot().reference.positions[0] == pytest.approx(stands, abs=1e-12)
    r.hardware.frozen = False
    r.run(2.0)
    assert goal.status.name == 'SUCCEEDED'
    assert r.hardware.state.position[0] == pytest.approx(-0.4, abs=1e-3)


def test_a_blocked_joint_goes_on_from_where_it_should_be(blocked, trajectory):
    """E7, G3: a trajectory that begins at the reference is taken, without a step."""
    r, arm, _ = blocked
    arm.send_goal(trajectory((0.0, [0.4, 0.0]), (0.5, [0.2, 0.0])))
    r.step()
    assert arm.snapshot().reference.positions[0] == 0.4


@pytest.mark.parametrize('first', [0.2, 0.3, 0.5, 0.0])
def test_a_first_point_near_neither_is_jumped_to(blocked, trajectory, first):
    """
    The warning names how far the joint is from the first point; the reference goes there.

    trajectory.cpp, sample: at the time of the first point the trajectory is that point.
    """
    r, arm, stands = blocked
    r.texts()
    goal = arm.send_goal(trajectory((0.0, [first, 0.0]), (0.5, [0.0, 0.0]))).goal
    assert f"{first - stands:g} rad away from joint 'a'" in r.texts()[0]
    r.step()
    assert arm.snapshot().reference.positions[0] == first
    r.hardware.frozen = False
    r.run(2.0)
    assert goal.status.name == 'SUCCEEDED'


@pytest.fixture
def ending(trajectory):
    """Return a function that makes a trajectory which ends before a controller's next update."""

    def make(arm, *positions):
        return trajectory((0.5, [*positions]), stamp_ns=arm.time_ns - 495_000_000)

    return make


def test_a_goal_that_ends_before_the_next_update_is_followed(rig, trajectory, ending):
    """
    The joints are at its last point at once, and stay there; the goal before is preempted.

    trajectory.cpp, sample: a trajectory that has played out is its last point.
    """
    r = rig()
    arm = r.arm()
    old = arm.send_goal(trajectory((2.0, [1.0, 1.0]))).goal
    r.run(0.5)
    goal = arm.send_goal(ending(arm, 0.2, 0.2)).goal
    r.step(3)
    assert (old.status.name, goal.status.name) == ('ABORTED', 'SUCCEEDED')
    r.run(3.0)
    np.testing.assert_array_equal(r.hardware.state.position, [0.2, 0.2])


def test_a_goal_that_ends_before_the_next_update_keeps_its_path_tolerance(rig, ending):
    """
    Its first check is one of the path: the joints stay where they are.

    joint_trajectory_controller.cpp, update: the state tolerance is checked on the first sample
    even if that is the last point.
    """
    r = rig()
    arm = r.arm(constraints={'a': {'trajectory': 0.05}})
    goal = arm.send_goal(ending(arm, 0.2, 0.2)).goal
    r.run(1.0)
    assert goal.result.code.name == 'PATH_TOLERANCE_VIOLATED'
    np.testing.assert_array_equal(r.hardware.state.position, [0.0, 0.0])


def test_a_topic_trajectory_that_ends_before_the_next_update_ends_no_goal(
    rig, trajectory, ending
):
    """
    The goal goes on with the trajectory of the topic, and succeeds at its end.

    joint_trajectory_controller.cpp, update: a message replaces the trajectory, not the goal.
    """
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((2.0, [1.0, 1.0]))).goal
    r.run(1.0)
    arm.set_trajectory(ending(arm, 0.5, 0.5))
    r.run(3.0)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_array_equal(r.hardware.state.position, [0.5, 0.5])


@pytest.mark.parametrize('ahead_ns', [500_000_000, 503_000_000], ids=['aligned', 'between'])
@pytest.mark.parametrize('way', ['send_goal', 'set_trajectory'])
def test_a_first_point_at_a_future_stamp_is_reached_then(rig, trajectory, way, ahead_ns):
    """
    The joints are there at the stamp, and move from now on: no step.

    trajectory.cpp, sample: before the first point it is a segment from the present state.
    """
    r = rig()
    arm = r.arm()
    getattr(arm, way)(trajectory((0.0, [0.5, 0.0]), stamp_ns=r.now_ns + ahead_ns))
    references = []
    for _ in range(53):
        r.step()
        references.append(arm.snapshot().reference.positions[0])
    assert references[25] == pytest.approx(0.5 * 250_000_000 / ahead_ns)
    assert references[-1] == 0.5
    assert np.abs(np.diff(references)).max() < 0.0101


def test_a_goal_whose_first_point_is_at_a_future_stamp_succeeds_there(rig, trajectory):
    """Not before, although it is followed from now on."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((0.0, [0.5, 0.0]), stamp_ns=r.now_ns + 503_000_000)).goal
    r.run(0.5)
    assert goal.status.name == 'EXECUTING'
    r.step(2)
    assert goal.status.name == 'SUCCEEDED'


def test_a_goal_that_is_over_soon_after_its_future_stamp_is_followed(rig, trajectory):
    """E4: a last point between the stamp and the next update is commanded."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((0.005, [0.02, 0.0]), stamp_ns=r.now_ns + 102_000_000)).goal
    r.run(0.2)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_array_equal(r.hardware.state.position, [0.02, 0.0])
