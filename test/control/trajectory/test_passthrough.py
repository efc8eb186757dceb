# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which goals the controller takes whose trajectories the arm interpolates.

As ``goal_received_callback`` and ``check_goal_tolerances`` of
passthrough_trajectory_controller.cpp.
"""

import pytest

from armsim_ros.control.trajectory.tolerances import JointTolerance

MOVE = (1.0, [0.4, 0.0])


@pytest.fixture
def running(rig):
    """Return a rig whose controller is active, and the controller."""
    r = rig()
    controller = r.load('arm', 'ur_controllers/PassthroughTrajectoryController',
                        joints=['a', 'b'], state_interfaces=['position', 'velocity'])
    assert r.manager.switch(activate=['arm']).ok
    r.step()
    return r, controller


@pytest.mark.parametrize('seconds', [0.0, 0.5])
def test_a_goal_is_refused_while_another_one_runs(running, trajectory, seconds):
    """From its acceptance to its end; it goes on, and the next goal is taken after it."""
    r, controller = running
    first = controller.send_goal(trajectory(MOVE)).goal
    r.run(seconds)
    assert 'another trajectory' in controller.check_goal(trajectory(MOVE))
    assert not controller.send_goal(trajectory(MOVE)).accepted
    r.run(1.2)
    assert first.status.name == 'SUCCEEDED'
    assert controller.send_goal(trajectory(MOVE)).accepted


def test_a_goal_that_is_cancelled_makes_room_at_once(running, trajectory):
    """The next goal does not wait for the update that ends the first."""
    r, controller = running
    first = controller.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    assert controller.cancel(first)
    second = controller.send_goal(trajectory(MOVE)).goal
    r.run(1.2)
    assert (first.status.name, second.status.name) == ('CANCELED', 'SUCCEEDED')


@pytest.mark.parametrize(('names', 'accepted'), [
    ('', True), ('ba', True), ('a', False), ('ac', False), ('abc', False)])
def test_goal_tolerances_are_those_of_all_joints(running, trajectory, names, accepted):
    """Or none; the order does not matter."""
    _, controller = running
    tolerances = [JointTolerance(name, position=0.1) for name in names]
    assert controller.send_goal(
        trajectory(MOVE), goal_tolerances=tolerances).accepted is accepted
