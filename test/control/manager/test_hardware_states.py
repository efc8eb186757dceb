# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
States of hardware components: what they allow, and what reaches the joints.

The behaviour is that of resource_manager.cpp (ResourceStorage::set_component_state,
ResourceManager::prepare_command_mode_switch) and of
ControllerManager::set_initial_hardware_components_state.
"""

import numpy as np
import pytest

from armsim_ros.control.manager.switching import Strictness

ARM = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'


def component(r):
    """Return the state of the only component."""
    return r.manager.list_hardware_components()[0].state


def available(r):
    """Return whether the command interfaces and the state interfaces are available."""
    return tuple({one.is_available for one in found}.pop()
                 for found in r.manager.list_hardware_interfaces())


def test_hardware_changes_state_while_it_is_commanded(rig, trajectory):
    """
    Controllers stay active; commands do not reach the joints until the hardware is active.

    system.cpp, System::write.
    """
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory((1.0, [1.0, 1.0])))
    r.run(0.3)
    r.manager.set_hardware_component_state('rig', 'inactive')
    assert (component(r), arm.active) == ('inactive', True)
    r.step()
    before = r.hardware.state.position.copy()
    r.run(0.5)
    np.testing.assert_array_equal(r.hardware.state.position, before)
    assert r.hardware.claimed == {}
    r.manager.set_hardware_component_state('rig', 'active')
    r.run(1.0)
    np.testing.assert_allclose(r.hardware.state.position, 1.0, atol=1e-6)


@pytest.mark.parametrize(('state', 'expected'), [
    ('unconfigured', (False, False)), ('inactive', (True, True)), ('active', (True, True)),
    ('finalized', (False, False))])
def test_interfaces_are_available_from_configured_hardware_on(rig, state, expected):
    """Interfaces are available while the hardware is inactive or active."""
    r = rig()
    r.manager.set_hardware_component_state('rig', state)
    assert available(r) == expected


def test_interfaces_of_unconfigured_hardware_are_not_claimed(rig):
    """
    A controller of hardware that is not configured claims nothing until it is again.

    resource_manager.cpp, ResourceManager::command_interface_is_claimed.
    """
    r = rig()
    arm = r.arm(joints=['a'])

    def claimed():
        return [one.name for one in r.manager.list_hardware_interfaces()[0] if one.is_claimed]

    r.manager.set_hardware_component_state('rig', 'unconfigured')
    r.step()
    assert claimed() == []
    assert arm.active
    r.manager.set_hardware_component_state('rig', 'active')
    r.step()
    assert claimed() == ['a/position']


def test_a_controller_of_unconfigured_hardware_can_be_deactivated(rig):
    """Its joints hold already; upstream refuses the mode switch."""
    r = rig()
    arm = r.arm()
    r.manager.set_hardware_component_state('rig', 'unconfigured')
    r.step()
    assert r.manager.switch(deactivate=['arm']).ok
    assert not arm.active


@pytest.mark.parametrize('strictness', [Strictness.STRICT, Strictness.BEST_EFFORT])
@pytest.mark.parametrize('state', ['inactive', 'unconfigured'])
def test_hardware_that_is_not_active_refuses_controllers(rig, state, strictness):
    """A controller that commands hardware that is not active refuses the whole request."""
    r = rig()
    arm = r.load('arm', ARM, joints=['a'])
    states = r.load('states', BROADCASTER)
    r.manager.set_hardware_component_state('rig', state)
    result = r.manager.switch(['states', 'arm'], [], strictness)
    assert not result.ok
    assert "'arm'" in result.message
    assert "'rig'" in result.message
    assert {arm.state.value, states.state.value} == {'inactive'}


def test_broadcasters_run_on_inactive_hardware(rig):
    """Only commands need active hardware."""
    r = rig()
    states = r.load('states', BROADCASTER)
    r.manager.set_hardware_component_state('rig', 'inactive')
    assert r.manager.switch(['states']).ok
    assert states.active


def test_inactive_hardware_can_be_allowed(rig):
    """With defaults.allow_controller_activation_with_inactive_hardware controllers start."""
    r = rig(defaults={'allow_controller_activation_with_inactive_hardware': True},
            hardware_components_initial_state={'inactive': ['rig']})
    arm = r.arm()
    assert (component(r), arm.active) == ('inactive', True)


@pytest.mark.parametrize('state', ['unconfigured', 'inactive'])
def test_the_initial_state_of_hardware(rig, state):
    """hardware_components_initial_state names the components that do not start active."""
    r = rig(hardware_components_initial_state={state: ['rig']})
    r.load('arm', ARM, joints=['a'])
    assert component(r) == state
    assert not r.manager.switch(['arm']).ok
    r.manager.set_hardware_component_state('rig', 'active')
    assert r.manager.switch(['arm']).ok


def test_an_initial_state_of_unknown_hardware(rig):
    """A component that nothing declares is a warning; the others start active."""
    r = rig(hardware_components_initial_state={'inactive': ['gripper']})
    assert component(r) == 'active'
    assert any("'gripper'" in text for text in r.texts())


def test_held_joints_follow_a_plant_that_was_put_elsewhere(rig):
    """After a reset, joints of inactive hardware hold where they are then."""
    r = rig(hardware_components_initial_state={'inactive': ['rig']})
    r.step()
    r.hardware.state.position[:] = 0.7
    r.manager.resume(r.now_ns)
    r.step()
    np.testing.assert_array_equal(r.hardware.command.position, 0.7)


def test_components_list_claims(rig):
    """list_hardware_components lists which command interfaces are claimed."""
    r = rig()
    r.arm(joints=['a'])
    (info,) = r.manager.list_hardware_components()
    assert [one.name for one in info.command_interfaces if one.is_claimed] == ['a/position']
