# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the controllers of a controller_manager."""

from dataclasses import replace

import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.execution.ros2_control import (
    controllers_to_switch,
    ListedController,
    ManagedControllers,
)

TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
FORWARD = 'position_controllers/JointGroupPositionController'


def interfaces(*joints):
    """Return the position interfaces of joints."""
    return tuple(f'{joint}/position' for joint in joints)


ARM = ListedController('arm', TRAJECTORY, required=interfaces('a', 'b'))
SLIDER = ListedController(
    'slider', FORWARD, active=True, claimed=interfaces('a', 'b'), required=interfaces('a', 'b'))


@pytest.mark.parametrize(('kind', 'action'), [
    (TRAJECTORY, ('FollowJointTrajectory', 'follow_joint_trajectory')),
    ('position_controllers/GripperActionController', ('GripperCommand', 'gripper_cmd')),
    ('effort_controllers/GripperActionController', ('GripperCommand', 'gripper_cmd')),
    ('parallel_gripper_action_controller/GripperActionController',
     ('ParallelGripperCommand', 'gripper_cmd')),
])
def test_actions_of_types(kind, action):
    """
    Inactive controllers are known too; joints are those of the required interfaces.

    Upstream: controller_manager_plugin.cpp, discover, and
    moveit_ros_control_interface_plugins.xml.
    """
    one = replace(ARM, type=kind, required=(*interfaces('a', 'b'), 'a/velocity'))
    (known,) = ManagedControllers('/', (one, SLIDER)).settings
    assert (known.name, known.joints) == ('/arm', ('a', 'b'))
    assert (known.type, known.action_ns) == action
    assert known.action_name == f'/arm/{action[1]}'


def test_names_have_the_namespace():
    """
    Controllers have the namespace of their manager in front.

    Upstream: controller_manager_plugin.cpp, getAbsName.
    """
    managed = ManagedControllers('/cell/left', (replace(ARM, active=True),))
    assert managed.settings[0].name == '/cell/left/arm'
    assert managed.active == {'/cell/left/arm'}


def test_joints_of_a_chain():
    """
    A controller that commands another one moves the joints of that one's references.

    Upstream: controller_manager_plugin.cpp, fixChainedControllers.
    """
    chained = replace(ARM, required=('filter/a/position',), chained_to=('filter',))
    follower = ListedController('filter', 'x/Filter', references=interfaces('a', 'b'))
    assert ManagedControllers('/', (chained, follower)).settings[0].joints == ('filter', 'a', 'b')


def test_a_controller_of_several_chains():
    """
    Where an active controller commands several others no controller is known.

    Upstream: controller_manager_plugin.cpp, fixChainedControllers.
    """
    fork = replace(ARM, active=True, chained_to=('left', 'right'))
    assert ManagedControllers('/', (fork, SLIDER)).settings == ()
    assert ManagedControllers('/', (replace(fork, active=False), SLIDER)).settings


def test_who_holds_a_joint_is_deactivated():
    """
    A controller of any type that holds a needed joint is deactivated in the same switch.

    Upstream: controller_manager_plugin.cpp, switchControllers.
    """
    assert ManagedControllers('/', (ARM, SLIDER)).switch(['/arm'], []) == (['arm'], ['slider'])
    assert ManagedControllers('/left', (ARM, SLIDER)).switch(['/right/arm'], []) == ([], [])


def test_switches_of_a_chain():
    """
    What a controller commands starts with it, what commands a controller stops with it.

    Upstream: test_controller_manager_plugin.cpp, SwitchControllers.
    """
    references = ('ref_1', 'ref_2', 'ref_3')
    running = set()

    def switch(activate, deactivate):
        managed = ManagedControllers('/', (
            ListedController('A', TRAJECTORY, 'A' in running, required=('jnt_1', 'jnt_2', 'jnt_3'),
                             chained_to=('B',)),
            ListedController('B', TRAJECTORY, 'B' in running, required=('jnt_4', 'jnt_5'),
                             references=references)))
        starting, stopping = managed.switch(activate, deactivate)
        running.difference_update(stopping)
        running.update(starting)
        return sorted(starting), sorted(stopping)

    assert switch(['/A'], []) == (['A', 'B'], [])
    assert switch([], ['/B']) == ([], ['A', 'B'])
    assert switch(['/B'], []) == (['B'], [])
    assert switch([], ['/B']) == ([], ['B'])
    assert switch(['/B'] * 4, []) == (['B'], [])
    assert switch([], ['/B']) == ([], ['B'])
    assert switch(['/B', '/A'], ['/A'] * 3) == (['B'], [])


def test_what_runs_already_is_not_switched():
    """
    Only inactive controllers are activated, and only those that share their joints stop.

    Upstream: trajectory_execution_manager.cpp, ensureActiveControllers.
    """
    known = ManagedControllers('/', (
        replace(ARM, active=True), ListedController('hand', TRAJECTORY, required=('c/position',)),
        ListedController('other', TRAJECTORY, True, required=interfaces('a', 'b')),
        ListedController('free', TRAJECTORY, True, required=('d/position',)))).settings
    assert controllers_to_switch(['/arm'], known, {'/arm'}) == ([], [])
    assert controllers_to_switch(['/arm', '/hand'], known, {'/other', '/free'}) == (
        ['/arm', '/hand'], ['/other'])


def test_joints_that_would_be_left_alone():
    """
    Joints of a deactivated controller get another one; where there is none nothing is switched.

    Upstream: trajectory_execution_manager.cpp, ensureActiveControllers.
    """
    whole = ListedController('whole', TRAJECTORY, True, required=interfaces('a', 'b', 'c'))
    rest = ListedController('rest', TRAJECTORY, required=('c/position',))
    known = ManagedControllers('/', (ARM, whole, rest)).settings
    assert controllers_to_switch(['/arm'], known, {'/whole'}) == (['/arm', '/rest'], ['/whole'])
    with pytest.raises(PlanningError, match='no controller has c'):
        controllers_to_switch(['/arm'], known[:2], {'/whole'})


def test_a_needed_controller_that_is_gone_is_named():
    """With those that there are."""
    known = ManagedControllers('/', (ARM, SLIDER)).settings
    with pytest.raises(PlanningError, match=r"'/gone' is gone; known: /arm"):
        controllers_to_switch(['/gone'], known, {'/slider'})
