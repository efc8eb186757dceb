# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a switch request refuses as a whole, and what is left of one that fails half-way.

The behaviour is that of controller_manager.cpp: switch_controller_cb,
check_for_interfaces_availability_to_activate, activate_controllers.
"""

from types import SimpleNamespace

import pytest

from armsim_ros.control.manager.switching import Strictness
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import JointType

ARM = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'
FORWARD = 'forward_command_controller/ForwardCommandController'
PID = 'pid_controller/PidController'
BOTH = [Strictness.STRICT, Strictness.BEST_EFFORT]


def states(r):
    """Return name -> state."""
    return {info.name: info.state for info in r.manager.list_controllers()}


@pytest.fixture
def crowd(rig):
    """Return an active arm, an inactive rival for one of its joints, and a broadcaster."""
    r = rig()
    r.load('rival', ARM, joints=['a'])
    r.load('spare', BROADCASTER)
    r.arm()
    return r


def refused(r, activate, deactivate, strictness, *words):
    """Assert that a request fails, changes nothing, and explains itself."""
    before = states(r)
    result = r.manager.switch(activate, deactivate, strictness)
    assert not result.ok
    assert states(r) == before
    for word in words:
        assert word in result.message


@pytest.mark.parametrize('strictness', BOTH)
def test_a_claimed_interface_refuses_the_whole_request(crowd, strictness):
    """A claimed command interface refuses the request with all its controllers."""
    refused(crowd, ['spare', 'rival'], [], strictness, "'rival'", 'a/position', "'arm'")


@pytest.mark.parametrize('strictness', BOTH)
def test_two_controllers_of_a_request_for_one_interface(rig, strictness):
    """Two controllers of a request that need one command interface refuse it."""
    r = rig()
    for name in ('one', 'two'):
        r.load(name, ARM, joints=['a'])
    refused(r, ['one', 'two'], [], strictness, "'two'", 'a/position', "'one'")


@pytest.mark.parametrize('strictness', BOTH)
def test_a_restarted_controller_keeps_its_interfaces(crowd, strictness):
    """What a controller of both lists holds is not free for another one."""
    refused(crowd, ['arm', 'rival'], ['arm'], strictness, "'rival'", 'a/position')


@pytest.mark.parametrize('strictness', BOTH)
def test_a_missing_command_interface_refuses_the_whole_request(crowd, strictness):
    """A command interface that does not exist refuses the request."""
    crowd.load('lost', FORWARD, joints=['nowhere'], interface_name='position')
    refused(crowd, ['spare', 'lost'], [], strictness, "'lost'", 'nowhere/position')


@pytest.mark.parametrize('strictness', BOTH)
@pytest.mark.parametrize('key', ['state_interface', 'command_interface'])
def test_a_missing_speed_scaling_interface_is_found_before_the_switch(rig, key, strictness):
    """
    The speed scaling interfaces are required as those of the joints are.

    joint_trajectory_controller.cpp: command_interface_configuration,
    state_interface_configuration.
    """
    r = rig()
    r.load('spare', BROADCASTER)
    r.load('arm', ARM, joints=['a'], speed_scaling={key: 'pace/factor'})
    info = next(one for one in r.manager.list_controllers() if one.name == 'arm')
    assert 'pace/factor' in (*info.required_state_interfaces, *info.required_command_interfaces)
    refused(r, ['spare', 'arm'], [], strictness, "'arm'", 'pace/factor')


def test_best_effort_with_unknown_names_alone(crowd):
    """If no name of one list is loaded, the other list is not carried out either."""
    refused(crowd, ['nobody', 'no_one'], ['arm'], Strictness.BEST_EFFORT, "'nobody'", "'no_one'")
    refused(crowd, ['spare'], ['nobody'], Strictness.BEST_EFFORT, "'nobody'")
    assert crowd.manager.switch(['nobody', 'spare'], ['nobody', 'arm'], Strictness.BEST_EFFORT).ok
    assert states(crowd) == {'rival': 'inactive', 'spare': 'active', 'arm': 'inactive'}


def test_a_joint_set_free_in_the_request_can_be_taken(crowd):
    """Interfaces of the controllers that the request deactivates are free for the others."""
    assert crowd.manager.switch(['rival'], ['arm'], Strictness.BEST_EFFORT).ok
    assert states(crowd)['rival'] == 'active'


def test_best_effort_that_loses_a_follower(rig):
    """Without the controller whose references it writes, a controller refuses the request."""
    r = rig()
    r.load('arm', ARM, joints=['a'], command_joints=['loop/a'])
    r.manager.load(SimpleNamespace(name='loop', type=PID, parameters={
        'dof_names': ['a'], 'command_interface': 'velocity',
        'reference_and_state_interfaces': ['position'], 'gains': {'a': {'p': 1.0}}}))
    refused(r, ['arm', 'loop'], [], Strictness.BEST_EFFORT, "'arm'", 'loop/a/position')


@pytest.fixture
def three(rig, monkeypatch):
    """Return an active controller, and three for other interfaces of which the second fails."""
    r = rig(dict.fromkeys('abcd', JointType.REVOLUTE))
    r.arm(joints=['a'])
    for name in 'bcd':
        r.load(name, ARM, joints=[name])

    def fail(time_ns):
        raise ControllerError('broken drive')

    monkeypatch.setattr(r.manager.controllers['c'], 'activate', fail)
    return r


def test_strict_failure_deactivates_the_others_again(three):
    """If one controller fails in a strict switch, none that the request activated is active."""
    result = three.manager.switch(['b', 'c', 'd'], ['arm'], Strictness.STRICT)
    assert not result.ok
    assert 'broken drive' in result.message
    assert all(f"'{name}'" in result.message for name in 'bcd')
    assert states(three) == {
        'arm': 'inactive', 'b': 'inactive', 'c': 'unconfigured', 'd': 'inactive'}
    assert three.hardware.claimed == {}


def test_best_effort_failure_leaves_the_others_active(three):
    """In a best effort switch the others stay active; the answer is not ok."""
    result = three.manager.switch(['b', 'c', 'd'], ['arm'], Strictness.BEST_EFFORT)
    assert not result.ok
    assert 'broken drive' in result.message
    assert states(three) == {'arm': 'inactive', 'b': 'active', 'c': 'unconfigured', 'd': 'active'}


def test_strict_failure_of_a_writer_stops_the_restarted_follower(rig, monkeypatch):
    """A follower that the request restarts in chained mode is deactivated with the others."""
    r = rig()
    r.load('loop', PID, dof_names=['a'], command_interface='velocity',
           reference_and_state_interfaces=['position'], gains={'a': {'p': 1.0}})
    arm = r.load('arm', ARM, joints=['a'], command_joints=['loop/a'])
    assert r.manager.switch(['loop']).ok

    def fail(time_ns):
        raise ControllerError('broken drive')

    monkeypatch.setattr(arm, 'activate', fail)
    assert not r.manager.switch(['arm'], [], Strictness.STRICT).ok
    assert states(r) == {'loop': 'inactive', 'arm': 'unconfigured'}
    assert not r.manager.controllers['loop'].chained


def test_a_failed_activation_is_made_good_by_configuring(three, monkeypatch):
    """A controller that fails while it is activated is unconfigured, and can be configured."""
    three.manager.switch(['c'])
    assert states(three)['c'] == 'unconfigured'
    monkeypatch.undo()
    three.manager.configure('c')
    assert three.manager.switch(['c']).ok


def test_a_failed_follower_keeps_its_writer_inactive(rig, monkeypatch):
    """In a best effort switch, what writes references of a failed controller is not activated."""
    r = rig()
    loop = r.load('loop', PID, dof_names=['a'], command_interface='velocity',
                  reference_and_state_interfaces=['position'], gains={'a': {'p': 1.0}})
    r.load('arm', ARM, joints=['a'], command_joints=['loop/a'])
    r.load('other', ARM, joints=['b'])

    def fail(time_ns):
        raise ControllerError('broken drive')

    monkeypatch.setattr(loop, 'activate', fail)
    assert not r.manager.switch(['arm', 'loop', 'other'], [], Strictness.BEST_EFFORT).ok
    assert states(r) == {'arm': 'inactive', 'loop': 'unconfigured', 'other': 'active'}


@pytest.mark.parametrize('strictness', [0, *Strictness])
def test_an_empty_request(rig, strictness):
    """A request without names is done; unknown names alone are an error of any strictness."""
    r = rig()
    assert r.manager.switch([], [], strictness).ok
    assert not r.manager.switch(['nobody'], [], strictness).ok
    assert not r.manager.switch([], ['nobody'], strictness).ok


def test_an_interface_named_twice(rig):
    """A controller that names an interface twice cannot be configured (configure_controller)."""
    r = rig()
    with pytest.raises(ControllerError, match='more than once: a/position'):
        r.load('arm', ARM, joints=['a', 'b'], speed_scaling={'command_interface': 'a/position'})
    assert states(r) == {'arm': 'unconfigured'}
