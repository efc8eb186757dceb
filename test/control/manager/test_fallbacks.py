# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Fallback controllers: when a controller may be activated, and what its failure does.

The behaviour is that of controller_manager.cpp: load_controller, update,
check_fallback_controllers_state_pre_activation.
"""

from types import SimpleNamespace

import pytest

from armsim_ros.control.manager.switching import Strictness
from armsim_ros.errors import ControllerError, SimulationError

ARM = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'
FORWARD = 'forward_command_controller/ForwardCommandController'
PID = 'pid_controller/PidController'
LOOP = {'dof_names': ['a'], 'command_interface': 'velocity',
        'reference_and_state_interfaces': ['position'], 'gains': {'a': {'p': 1.0}}}


def states(r):
    """Return name -> state."""
    return {info.name: info.state for info in r.manager.list_controllers()}


def load(r, name, kind, fallbacks, **parameters):
    """Load and configure a controller with fallback controllers."""
    controller = r.manager.load(
        SimpleNamespace(name=name, type=kind, parameters=parameters), fallbacks)
    r.manager.configure(name)
    return controller


def break_it(monkeypatch, controller):
    """Have a controller raise at its next update."""
    def fail(time_ns, period):
        raise RuntimeError('broken')

    monkeypatch.setattr(controller, 'update', fail)


@pytest.mark.parametrize('strictness', [Strictness.STRICT, Strictness.BEST_EFFORT])
def test_a_fallback_must_be_loaded_configured_and_able_to_start(rig, strictness):
    """A controller whose fallback could not take over is not activated."""
    r = rig()
    arm = load(r, 'arm', ARM, ['spare'], joints=['a'])

    def refusal():
        result = r.manager.switch(['arm'], [], strictness)
        assert not arm.active
        assert result.ok is (strictness is Strictness.BEST_EFFORT)
        return result.message

    assert "'spare' is not loaded" in refusal()
    r.manager.load(SimpleNamespace(name='spare', type=FORWARD, parameters={
        'joints': ['nowhere'], 'interface_name': 'position'}))
    assert "'spare' is unconfigured" in refusal()
    r.manager.configure('spare')
    assert 'nowhere/position' in refusal()
    r.manager.unload('spare')
    r.load('spare', FORWARD, joints=['a'], interface_name='position')
    assert r.manager.switch(['arm'], [], strictness).ok
    assert arm.active


def test_a_fallback_in_a_chain_needs_its_follower_in_the_list(rig):
    """References that a fallback writes count if their controller is in the list, too."""
    r = rig()
    r.load('loop', PID, **LOOP)
    r.load('spare', ARM, joints=['a'], command_joints=['loop/a'])
    load(r, 'arm', ARM, ['spare'], joints=['b'])
    result = r.manager.switch(['arm'])
    assert not result.ok
    assert 'loop/a/position' in result.message
    r.manager.unload('arm')
    load(r, 'arm', ARM, ['spare', 'loop'], joints=['b'])
    assert r.manager.switch(['arm']).ok


def test_no_controller_is_its_own_fallback(rig):
    """A controller that names itself is not loaded."""
    r = rig()
    with pytest.raises(ControllerError, match='its own fallback'):
        load(r, 'arm', ARM, ['arm'], joints=['a'])
    assert states(r) == {}


def test_a_failure_frees_what_the_fallback_needs(rig, monkeypatch):
    """Active controllers that hold interfaces of the fallback are deactivated."""
    r = rig()
    r.load('spare', FORWARD, joints=['a', 'b'], interface_name='position')
    arm = load(r, 'arm', ARM, ['spare'], joints=['a'])
    r.load('other', ARM, joints=['b'])
    assert r.manager.switch(['arm', 'other']).ok
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'spare': 'active', 'arm': 'inactive', 'other': 'inactive'}


def test_a_failure_whose_fallback_is_gone(rig, monkeypatch):
    """The failed controller is deactivated even if its fallback cannot be activated."""
    r = rig()
    r.load('spare', FORWARD, joints=['a'], interface_name='position')
    arm = load(r, 'arm', ARM, ['spare'], joints=['a'])
    assert r.manager.switch(['arm']).ok
    r.manager.unload('spare')
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'arm': 'inactive'}
    assert any("'spare'" in text for text in r.texts())


def test_a_fallback_that_is_active_already(rig, monkeypatch):
    """
    A fallback that is active stays so, with what is active through it, and the others start.

    Upstream: controller_manager.cpp, ControllerManager::update.
    """
    r = rig()
    r.load('states', BROADCASTER)
    r.load('loop', PID, **LOOP)
    r.load('stream', FORWARD, joints=['loop/a'], interface_name='position')
    r.load('spare', FORWARD, joints=['b'], interface_name='position')
    arm = load(r, 'arm', ARM, ['states', 'loop', 'spare'], joints=['b'])
    assert r.manager.switch(['states', 'loop', 'stream', 'arm']).ok
    r.step()
    r.texts()
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'states': 'active', 'stream': 'active', 'loop': 'active',
                         'spare': 'active', 'arm': 'inactive'}
    assert not any(name in text for text in r.texts() for name in ('states', 'loop', 'stream'))


def test_a_fallback_of_several_is_gone(rig, monkeypatch):
    """
    A fallback that is not loaded any more is left out, with an event, and the others start.

    Upstream: controller_manager.cpp, ControllerManager::update and activate_controllers.
    """
    r = rig()
    r.load('gone', FORWARD, joints=['b'], interface_name='position')
    r.load('spare', FORWARD, joints=['a'], interface_name='position')
    arm = load(r, 'arm', ARM, ['gone', 'spare'], joints=['a'])
    assert r.manager.switch(['arm']).ok
    r.manager.unload('gone')
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'spare': 'active', 'arm': 'inactive'}
    assert any("no controller 'gone'" in text and 'active: spare' in text for text in r.texts())


def test_a_fallback_takes_over_from_a_chain(rig, monkeypatch):
    """What writes to a controller that holds the interfaces is deactivated with it."""
    r = rig()
    r.load('loop', PID, **LOOP)
    r.load('stream', FORWARD, joints=['loop/a'], interface_name='position')
    r.load('spare', FORWARD, joints=['a', 'b'], interface_name='velocity')
    arm = load(r, 'arm', ARM, ['spare'], joints=['b'])
    assert r.manager.switch(['loop', 'stream', 'arm']).ok
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {
        'stream': 'inactive', 'loop': 'inactive', 'spare': 'active', 'arm': 'inactive'}


def test_a_fallback_that_writes_to_the_failed_chain(rig, monkeypatch):
    """
    A following controller that is a fallback itself starts anew, with the new writer.

    Upstream: controller_manager.cpp, ControllerManager::update.
    """
    r = rig()
    loop = r.load('loop', PID, **LOOP)
    r.load('spare', FORWARD, joints=['loop/a'], interface_name='position')
    arm = load(r, 'arm', ARM, ['spare', 'loop'], joints=['a'], command_joints=['loop/a'])
    assert r.manager.switch(['loop', 'arm']).ok
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'spare': 'active', 'loop': 'active', 'arm': 'inactive'}
    assert loop.chained


def test_the_fallbacks_of_a_fallback_do_not_matter(rig, monkeypatch):
    """
    A fallback takes over even if its own fallback could not.

    Upstream: controller_manager.cpp, ControllerManager::update.
    """
    r = rig()
    load(r, 'spare', FORWARD, ['gone'], joints=['a'], interface_name='position')
    arm = load(r, 'arm', ARM, ['spare'], joints=['a'])
    assert r.manager.switch(['arm']).ok
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'spare': 'active', 'arm': 'inactive'}


def test_a_failure_whose_fallback_the_hardware_refuses(rig, monkeypatch):
    """The failed controller is deactivated even if the hardware cannot follow its fallback."""
    r = rig()
    r.load('spare', FORWARD, joints=['a'], interface_name='velocity')
    arm = load(r, 'arm', ARM, ['spare'], joints=['a'])
    assert r.manager.switch(['arm']).ok
    accept = r.hardware.perform_command_mode_switch

    def refuse_velocity(claimed):
        if any('velocity' in kinds for kinds in claimed.values()):
            raise SimulationError('no such mode')
        accept(claimed)

    monkeypatch.setattr(r.hardware, 'perform_command_mode_switch', refuse_velocity)
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'spare': 'inactive', 'arm': 'inactive'}
    assert any('no such mode' in text for text in r.texts())


def test_a_failure_stops_the_whole_chain(rig, monkeypatch):
    """With a preceding controller its following controllers are deactivated, too."""
    r = rig()
    r.load('loop', PID, **LOOP)
    arm = r.load('arm', ARM, joints=['a'], command_joints=['loop/a'])
    r.load('other', ARM, joints=['b'])
    assert r.manager.switch(['loop', 'arm', 'other']).ok
    break_it(monkeypatch, arm)
    r.step(2)
    assert states(r) == {'loop': 'inactive', 'arm': 'inactive', 'other': 'active'}
