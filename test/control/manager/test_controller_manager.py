# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Loading, switching, claims and failures of controllers."""

from itertools import pairwise, product
import threading
from types import SimpleNamespace

import pytest

from armsim_ros.config.base import ControllerParameters
from armsim_ros.control.manager.controller_factory import CONTROLLER_TYPES
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.errors import ControllerError

ARM = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'


def states(r):
    """Return name -> state."""
    return {info.name: info.state for info in r.manager.list_controllers()}


def test_life_of_a_controller(rig):
    """C1, P6: unconfigured, inactive, active, inactive; claims only while active."""
    r = rig()
    r.manager.load(SimpleNamespace(name='arm', type=ARM, parameters={'joints': ['a']}))
    (info,) = r.manager.list_controllers()
    assert (info.state, info.required_command_interfaces) == ('unconfigured', ())
    r.manager.configure('arm')
    (info,) = r.manager.list_controllers()
    assert info.state == 'inactive'
    assert info.required_command_interfaces == ('a/position',)
    assert info.required_state_interfaces == ('a/position', 'a/velocity')
    assert info.claimed_interfaces == ()
    assert r.manager.switch(activate=['arm']).ok
    assert r.manager.list_controllers()[0].claimed_interfaces == ('a/position',)
    assert r.hardware.claimed == {'a': frozenset({'position'})}
    assert r.manager.switch(deactivate=['arm']).ok
    (info,) = r.manager.list_controllers()
    assert (info.state, info.claimed_interfaces) == ('inactive', ())
    assert r.hardware.claimed == {}
    r.manager.cleanup('arm')
    assert states(r) == {'arm': 'unconfigured'}
    r.manager.unload('arm')
    assert states(r) == {}


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        ({'name': 'arm', 'type': ARM, 'parameters': {'joints': ['a']}}, ['loaded already']),
        ({'name': 'x', 'type': ARM + 's', 'parameters': {}}, ['unknown controller type', ARM]),
        (
            {
                'name': 'x',
                'type': ARM,
                'parameters': {'joints': ['a'], 'constraints': {'goal_time': -1}, 'verbos': True},
            },
            ['constraints.goal_time', 'verbos'],
        ),
    ],
)
def test_load_refuses(rig, settings, words):
    """B22, P1: the name is taken, the type unknown, a parameter wrong: all of them named."""
    r = rig()
    r.arm()
    with pytest.raises(ControllerError) as caught:
        r.manager.load(SimpleNamespace(**settings))
    for word in words:
        assert word in str(caught.value)


def test_configure_cleanup_unload_refuse_the_wrong_state(rig):
    """P1: active controllers are neither configured nor cleaned up nor unloaded."""
    r = rig()
    r.arm()
    for work in (r.manager.configure, r.manager.cleanup, r.manager.unload):
        with pytest.raises(ControllerError, match='active'):
            work('arm')
        with pytest.raises(ControllerError, match="did you mean 'arm'"):
            work('arn')


def test_configure_again(rig):
    """P1: an inactive controller is configured anew."""
    r = rig()
    r.arm()
    r.manager.switch(deactivate=['arm'])
    r.manager.configure('arm')
    assert r.manager.switch(activate=['arm']).ok


@pytest.mark.parametrize(
    ('activate', 'deactivate', 'word'),
    [
        (['spare', 'nobody'], [], "'nobody'"),
        (['arm'], [], 'active already'),
        (['raw'], [], 'configure it first'),
        ([], ['spare'], 'inactive'),
        (['rival'], [], "'arm' has claimed"),
    ],
)
def test_strict_switches_nothing(rig, activate, deactivate, word):
    """P3, P4: one wrong name and nothing is switched; the message explains."""
    r = crowded(rig)
    before = states(r)
    result = r.manager.switch(activate, deactivate, Strictness.STRICT)
    assert not result.ok
    assert word in result.message
    assert states(r) == before


def crowded(rig):
    """Return a rig with controllers in all states: arm and rival want the same joint."""
    r = rig()
    r.load('rival', ARM, joints=['a'])
    r.load('spare', BROADCASTER)
    r.manager.load(SimpleNamespace(name='raw', type=BROADCASTER, parameters={}))
    r.arm()
    return r


def test_best_effort_drops_what_is_wrong(rig):
    """
    Names beside loaded ones and wrong states are left out; with nothing left it is still ok.

    controller_manager.cpp, ControllerManager::switch_controller_cb.
    """
    r = crowded(rig)
    result = r.manager.switch(['spare', 'nobody', 'arm'], ['raw'], Strictness.BEST_EFFORT)
    assert result.ok
    assert "'nobody'" in result.message
    assert states(r)['spare'] == 'active'
    again = r.manager.switch(['spare'], [], Strictness.BEST_EFFORT)
    assert again.ok
    assert 'nothing to do' in again.message


def test_default_strictness(rig):
    """P1: strictness 0 takes the default of the parameters."""
    for strictness, done in (('best_effort', True), ('strict', False)):
        r = rig(defaults={'switch_controller': {'strictness': strictness}})
        r.load('states', BROADCASTER)
        assert r.manager.switch(['states', 'nobody'], strictness=0).ok is done


def test_swap_in_one_call(rig):
    """P4: one controller takes the joints over from another in one switch."""
    r = crowded(rig)
    assert r.manager.switch(['rival'], ['arm']).ok
    assert states(r)['rival'] == 'active'
    assert r.hardware.claimed == {'a': frozenset({'position'})}


def test_two_that_want_the_same(rig):
    """P4: two controllers for one interface are not activated together."""
    r = rig()
    r.load('one', ARM, joints=['a'])
    r.load('two', ARM, joints=['a', 'b'])
    assert not r.manager.switch(['one', 'two']).ok
    assert set(states(r).values()) == {'inactive'}


def test_restart(rig):
    """A controller that is named in both lists starts anew."""
    r = rig()
    r.arm()
    assert r.manager.switch(['arm'], ['arm']).ok
    assert states(r) == {'arm': 'active'}


def test_hardware_that_refuses(rig):
    """A set of interfaces that the hardware cannot follow leaves all as it was."""
    r = crowded(rig)
    r.hardware.refuse = 'no such mode'
    result = r.manager.switch(['rival'], ['arm'])
    assert not result.ok
    assert 'no such mode' in result.message
    assert states(r)['arm'] == 'active'


def test_requests_of_other_threads_wait_for_the_loop(rig):
    """P5: done by the next update, or while time stands still."""
    r = rig()
    r.load('arm', ARM, joints=['a'])
    future = r.manager.request_switch(['arm'])
    assert not future.done()
    r.manager.process_requests(r.now_ns)
    assert future.result(0).ok
    future = r.manager.request_switch([], ['arm'])
    r.step()
    assert future.result(0).ok
    assert states(r) == {'arm': 'inactive'}


def test_failing_controller_is_deactivated(rig, monkeypatch):
    """P10: the others go on, the reason is told, the fallback takes the joints."""
    r = rig(arm={'type': ARM, 'fallback_controllers': ['rival']})
    r.load('rival', ARM, joints=['a'])
    arm = r.arm()
    states_seen = r.load('states', BROADCASTER)
    r.manager.switch(['states'])
    monkeypatch.setattr(arm, 'update', lambda *_: 1 / 0)
    r.step()
    assert states(r) == {'rival': 'active', 'arm': 'inactive', 'states': 'active'}
    assert any('ZeroDivisionError' in text for text in r.texts())
    r.step()
    assert states_seen.poll() is not None


def test_stale_position_commands_are_forgotten(rig):
    """C3: after another interface moved the joint, the old position command is not held."""
    r = rig()
    r.load('speed', ARM, joints=['a', 'b'], command_interfaces=['velocity'],
           gains={'a': {'p': 1.0}})
    r.arm()
    r.manager.switch(['speed'], ['arm'])
    r.hardware.state.position[0] = 1.0
    r.manager.switch(['arm'], ['speed'])
    assert r.manager.controllers['arm'].snapshot().reference.positions[0] == 1.0


def test_update_rate_divides(rig, monkeypatch):
    """B18, A15: a controller with its own rate runs every so many updates, with its period."""
    r = rig()
    arm = r.arm(update_rate=25)
    calls = []
    monkeypatch.setattr(arm, 'update', lambda time_ns, period: calls.append((time_ns, period)))
    r.step(100)
    assert len(calls) == 25
    assert {b[0] - a[0] for a, b in pairwise(calls)} == {40_000_000}
    assert calls[0][1] == pytest.approx(0.04)


@pytest.mark.parametrize('rate', [100, 50, 25])
def test_updates_that_are_left_out_let_the_time_of_a_trajectory_pass(rig, trajectory, rate):
    """A controller with a rate of its own misses its own updates, wherever the gap begins."""
    for before, left_out in product(range(4), range(1, 10)):
        passed = []
        for skips in (True, False):
            r = rig()
            arm = r.arm(update_rate=rate)
            arm.set_trajectory(trajectory((0.1, [0.0, 0.0])))
            r.step(40 + before)
            if skips:
                r.manager.pass_updates(left_out, 0.01)
                r.now_ns += left_out * 10_000_000
            else:
                r.step(left_out)
            r.step(4)
            passed.append(arm.snapshot().desired_time_from_start)
        assert passed[0] == pytest.approx(passed[1])


@pytest.mark.parametrize(('asked', 'run'), [
    (None, 100), (0, 100), (25, 25), (30, 33), (40, 33), (70, 100), (200, 100)])
def test_the_rate_that_is_run(rig, asked, run):
    """
    An update rate becomes one that the manager's updates allow, with a warning.

    controller_interface_base.cpp, ControllerInterfaceBase::configure.
    """
    r = rig()
    r.arm(**({} if asked is None else {'update_rate': asked}))
    (info,) = r.manager.list_controllers()
    assert info.update_rate == run
    warned = any(f'runs at {run} Hz instead of {asked} Hz' in text for text in r.texts())
    assert warned is (asked not in (None, 0, run))


def test_parameters_of_every_controller(rig):
    """
    Every kind of controller declares update_rate with the manager's rate, and two more.

    controller_interface_base.cpp, ControllerInterfaceBase::init.
    """
    assert all(issubclass(kind.parameters_class, ControllerParameters)
               for kind in CONTROLLER_TYPES.values())
    parameters = rig().arm().parameters
    assert parameters.update_rate == 100
    assert not parameters.is_async
    assert parameters.thread_priority == -100


def test_hardware_interfaces(rig):
    """P1: names, availability and claims of all interfaces."""
    r = rig()
    r.arm(joints=['a'])
    command, state = r.manager.list_hardware_interfaces()
    assert [i.name for i in command if i.is_claimed] == ['a/position']
    assert 'b/effort' in [i.name for i in state]
    assert all(i.is_available for i in command)


def test_hardware_component(rig):
    """The robot is one component where its description declares none."""
    r = rig()
    (component,) = r.manager.list_hardware_components()
    assert (component.name, component.state) == ('rig', 'active')
    with pytest.raises(ControllerError, match='known: rig'):
        r.manager.set_hardware_component_state('gir', 'active')


def test_generation_counts_changes(rig):
    """P9: every change of a state is seen."""
    r = rig()
    seen = [r.manager.generation]
    r.load('arm', ARM, joints=['a'])
    seen.append(r.manager.generation)
    r.manager.switch(['arm'])
    seen.append(r.manager.generation)
    r.step(5)
    assert seen[0] < seen[1] < seen[2] == r.manager.generation


def test_robot_without_description(hardware_class):
    """C2: without a model, controllers run; no joint has limits."""
    from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
    from armsim_ros.control.manager.controller_manager import ControllerManager

    manager = ControllerManager(hardware_class(), ControllerManagerParameters())
    manager.load(SimpleNamespace(name='arm', type=ARM, parameters={'joints': ['a', 'b']}))
    manager.configure('arm')
    assert manager.switch(['arm']).ok
    manager.update(0, 0.01)
    assert manager.list_hardware_components()[0].name == 'hardware'


def test_a_failure_does_not_wait_for_those_who_change_controllers(rig, monkeypatch):
    """While somebody configures a controller a failed one is left alone, and replaced after."""
    r = rig()
    arm = r.arm()
    other = r.load('other', 'joint_state_broadcaster/JointStateBroadcaster')
    configuring, go_on = threading.Event(), threading.Event()

    def slowly():
        configuring.set()
        assert go_on.wait(20.0)

    monkeypatch.setattr(other, 'configure', slowly)
    thread = threading.Thread(target=r.manager.configure, args=('other',))
    thread.start()
    assert configuring.wait(20.0)
    updates = []

    def fail(time_ns, period):
        updates.append(time_ns)
        raise ValueError('broken')

    monkeypatch.setattr(arm, 'update', fail)
    r.step(3)
    assert (len(updates), arm.state.value) == (1, 'active')
    go_on.set()
    thread.join(20.0)
    r.step()
    assert (len(updates), arm.state.value) == (1, 'inactive')
    assert any('broken' in text for text in r.texts())
