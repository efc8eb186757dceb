"""Leg: three joints; controller and joint states stand in no namespace."""

import threading
import time

from faster import FASTER
import pytest

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

JOINTS = ['hip', 'knee', 'foot']
PATH_TOLERANCE_VIOLATED = -4


@pytest.fixture(scope='module')
def leg():
    """Run the stack."""
    with running_robot('robot:=leg', FASTER) as user:
        yield user


def test_the_names_are_those_that_were_published(leg):
    """
    The published list of topics, in the names of ROS 2.

    An action's topics are hidden and its goal, result and cancel are services; command and state
    are joint_trajectory and controller_state; Gazebo's own topics are not there.
    """
    node, pause, end = leg.client.node, threading.Event(), time.monotonic() + 30.0
    action = '/group_controller/follow_joint_trajectory/_action'
    missing = {'/clock'}
    while missing:
        missing = {
            '/clock', '/joint_states', '/tf', '/tf_static', '/rosout',
            '/group_controller/joint_trajectory', '/group_controller/controller_state',
            f'{action}/feedback', f'{action}/status',
        } - {name for name, _ in node.get_topic_names_and_types()}
        missing |= {f'{action}/{name}' for name in ('send_goal', 'get_result', 'cancel_goal')} - {
            name for name, _ in node.get_service_names_and_types()}
        assert not missing or time.monotonic() < end, missing
        pause.wait(0.05)


def test_a_trajectory_is_followed_within_the_published_constraints(leg):
    """0.1 rad on the way and at the end, 0.6 s to arrive."""
    outcome = leg.send('group_controller', JOINTS, [(0.8, [-0.3, 0.6, -0.3])])
    assert outcome.status == SUCCEEDED
    assert leg.distance({'hip': -0.3, 'knee': 0.6, 'foot': -0.3}) < 0.01


def test_the_published_constraints_end_a_trajectory_that_cannot_be_followed(leg):
    """More than 0.1 rad behind is an abort that names joint and limit."""
    outcome = leg.send('group_controller', JOINTS, [(0.05, [0.6, 0.0, 0.0])])
    assert outcome.status == ABORTED
    assert outcome.error_code == PATH_TOLERANCE_VIOLATED
    assert 'hip' in outcome.error_string
    assert '0.1' in outcome.error_string
    leg.wait_until_still()


def test_a_motion_is_planned_and_executed(leg):
    """A group that lists joints, links and a chain at once is one group of three joints."""
    target = leg.move_group.named_states()['leg', 'squat']
    assert leg.move_group.move('leg', target).error_code.val == SUCCESS
    assert leg.distance(target) < 0.01
