# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What holds for any trajectory, good or bad."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np

from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

PERIOD = 0.01

numbers = st.floats(-1.0, 1.0)
pairs = st.lists(numbers, min_size=2, max_size=2)
gaps = st.floats(0.05, 0.6)


@st.composite
def good_trajectories(draw):
    """Draw trajectories with positions, or velocities too, or accelerations too."""
    level = draw(st.integers(0, 2))
    steps = draw(st.lists(gaps, min_size=1, max_size=4))
    tables = np.array([[draw(pairs) for _ in steps] for _ in range(level + 1)])
    tables[1:2, -1] = 0.0
    return JointTrajectory(('a', 'b'), np.cumsum(steps), *tables)


anything = st.one_of(st.floats(), st.integers(-5, 5).map(float))
fields = st.lists(anything, max_size=3).map(np.array)
points = st.builds(TrajectoryPoint, fields, fields, fields, fields)
times = st.floats(allow_nan=False, allow_infinity=False)
names = st.lists(st.sampled_from(['a', 'b', 'c', '']), max_size=3).map(tuple)
any_trajectory = st.builds(
    lambda names, rows, stamp_ns: JointTrajectory.of_points(
        names, [time for time, _ in rows], [point for _, point in rows], stamp_ns),
    names, st.lists(st.tuples(times, points), max_size=3), st.integers(-(10**10), 10**10),
)


@settings(deadline=None, max_examples=30)
@given(data=st.data())
def test_reference_never_steps(rig, data):
    """E7, I5: however goals follow each other, the command moves at most by its own velocity."""
    r = rig()
    arm = r.arm()
    commands = [r.hardware.command.position.copy()]
    fastest = [np.zeros(2)]
    for _ in range(data.draw(st.integers(1, 3))):
        goal = data.draw(good_trajectories())
        assert arm.send_goal(goal).accepted
        for _ in range(data.draw(st.integers(1, 80))):
            r.step()
            commands.append(r.hardware.command.position.copy())
            motion = arm._loop.execution.motion
            time = arm._loop.execution.time
            inside = np.linspace(max(time - PERIOD, motion.start), time, 65)
            fastest.append(np.max([np.abs(motion.at(t)[2:4]) for t in inside], axis=0))
    steps = np.abs(np.diff(commands, axis=0))
    bounds = np.array(fastest[1:]) * PERIOD
    assert (steps <= bounds * 1.01 + 1e-3 * PERIOD + 1e-9).all()


@settings(deadline=None, max_examples=300)
@given(bad=any_trajectory)
def test_malformed_trajectories_never_move_the_arm(rig, bad):
    """D1 to D14: what is refused changes no command; what is accepted has finite numbers."""
    r = rig()
    arm = r.arm()
    before = r.hardware.command.position.copy()
    response = arm.send_goal(bad)
    r.step(3)
    if response.accepted:
        assert np.isfinite(r.hardware.command.position).all()
        assert not bad.fault
        assert np.isfinite(bad.positions).all()
    else:
        assert response.reason
        np.testing.assert_array_equal(r.hardware.command.position, before)
    assert arm.active
    rest = JointTrajectory(('a', 'b'), np.array([5.0]), np.zeros((1, 2)))
    assert arm.send_goal(rest).accepted


@settings(deadline=None, max_examples=40)
@given(trajectory=good_trajectories(), cancel_after=st.integers(0, 60))
def test_every_goal_ends_once(rig, trajectory, cancel_after):
    """I11: success or cancel, never both, never none."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory).goal
    ends = []
    goal.add_done_callback(lambda done: ends.append(done.status))
    r.step(cancel_after)
    arm.cancel(goal)
    r.run(3.0)
    assert len(ends) == 1
    assert ends[0].name in ('SUCCEEDED', 'CANCELED')
