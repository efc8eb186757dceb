# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is sampled for joint_states, and when."""

import numpy as np
import pytest

from armsim_ros.control.controller import NEVER_NS, Rate
from armsim_ros.model.robot_model import JointType

BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'


def broadcaster(r, **parameters):
    """Return an active broadcaster."""
    controller = r.load('states', BROADCASTER, **parameters)
    result = r.manager.switch(['states'])
    assert result.ok, result.message
    return controller


def samples(controller):
    """Return all samples that wait."""
    found = []
    while (sample := controller.poll()) is not None:
        found.append(sample)
    return found


def test_joints_of_the_urdf_in_alphabetical_order(rig):
    """
    M1, M3, M4: the URDF's movable joints by name, one entry in every array, mimic joints too (G7).

    joint_state_broadcaster.cpp, init_joint_data.
    """
    kinds = {'b': JointType.REVOLUTE, 'a': JointType.PRISMATIC, 'm': JointType.REVOLUTE,
             'fixed': JointType.FIXED}
    r = rig(kinds, mimics=('m',))
    states = broadcaster(r)
    r.hardware.state.position[:] = [1.0, 2.0, 3.0, 4.0]
    r.hardware.state.effort[:] = [4.0, 5.0, np.nan, np.nan]
    r.step()
    (sample,) = samples(states)
    assert sample.names == ('a', 'b', 'm')
    np.testing.assert_array_equal(sample.position, [2.0, 1.0, 3.0])
    np.testing.assert_array_equal(sample.effort, [5.0, 4.0, np.nan])
    assert sample.frame_id == 'base_link'
    assert sample.time_ns == r.now_ns - 10_000_000


def test_without_the_filter_in_the_order_of_the_interfaces(rig):
    """
    Unfiltered, each owner of a position, velocity or effort is published, sensors and gpios too.

    joint_state_broadcaster.cpp, init_joint_data (UrdfJointsFilter tests).
    """
    r = rig({'b': JointType.REVOLUTE, 'a': JointType.REVOLUTE})
    r.hardware.given_states.update({'valve/position': 0.5, 'valve/flow': 2.0, 'imu/tilt': 0.1})
    states = broadcaster(r, use_urdf_to_filter=False)
    r.step()
    (sample,) = samples(states)
    assert sample.names == ('b', 'a', 'valve')
    np.testing.assert_array_equal(sample.position, [0.0, 0.0, 0.5])
    assert np.isnan(sample.velocity[2])
    assert sample.dynamic[2:] == (
        ('valve', ('position', 'flow'), (0.5, 2.0)), ('imu', ('tilt',), (0.1,)))


@pytest.mark.parametrize(('rate', 'count'), [(50, 50), (25.0, 25), (100, 100), (0, 0), (-1, 0)])
def test_publish_rate_is_exact(rig, rate, count):
    """A16, M6, M7: samples of one second, equally spaced in simulated time; 0 is never."""
    r = rig()
    states = broadcaster(r, publish_rate=rate)
    r.step(100)
    stamps = [sample.time_ns for sample in samples(states)]
    assert len(stamps) == count
    assert len(set(np.diff(stamps))) <= 1


def test_without_publish_rate_every_update(rig):
    """M2: the rate is the controller's update rate."""
    r = rig()
    states = broadcaster(r, update_rate=20)
    r.step(100)
    assert len(samples(states)) == 20


def test_joints_and_interfaces_restrict_together(rig):
    """M2, M3, M4: only those joints, in that order; interfaces not asked for are NaN."""
    r = rig()
    states = broadcaster(r, joints=['b', 'a'], interfaces=['position'])
    r.hardware.state.position[:] = [1.0, 2.0]
    r.step()
    (sample,) = samples(states)
    assert sample.names == ('b', 'a')
    np.testing.assert_array_equal(sample.position, [2.0, 1.0])
    assert np.isnan(sample.velocity).all()
    assert sample.dynamic == (('b', ('position',), (2.0,)), ('a', ('position',), (1.0,)))


def test_only_one_of_both_does_not_restrict(rig):
    """M2: joints without interfaces restrict nothing, and a warning tells."""
    r = rig()
    states = broadcaster(r, joints=['b'])
    r.step()
    assert samples(states)[0].names == ('a', 'b')
    assert any('only together' in text for text in r.texts())


def test_missing_interface_fails_activation(rig):
    """M5: an interface that was asked for must exist."""
    r = rig()
    r.load('states', BROADCASTER, joints=['a'], interfaces=['torque'])
    result = r.manager.switch(['states'])
    assert not result.ok
    assert 'a/torque' in result.message


def test_joints_without_urdf_are_left_out(rig):
    """M2: use_urdf_to_filter leaves joints out that the URDF does not have."""
    for parameters, names in (({}, ('a',)), ({'use_urdf_to_filter': False}, ('a', 'b'))):
        r = rig()
        del r.manager.context.model.joints['b']
        states = broadcaster(r, **parameters)
        r.step()
        assert samples(states)[0].names == names


def test_extra_joints(rig):
    """M2, M6: names alone with zeros, or blocks with values; at the end."""
    r = rig()
    states = broadcaster(r, extra_joints=['x', {'name': 'y', 'position': 0.5, 'effort': 2.0}])
    r.step()
    (sample,) = samples(states)
    assert sample.names == ('a', 'b', 'x', 'y')
    np.testing.assert_array_equal(sample.position[2:], [0.0, 0.5])
    np.testing.assert_array_equal(sample.effort[2:], [0.0, 2.0])
    assert sample.dynamic[2] == ('x', ('position', 'velocity', 'effort'), (0.0, 0.0, 0.0))


@pytest.mark.parametrize('restriction', [{}, {'joints': ['a'], 'interfaces': ['position']}])
def test_extra_joints_that_are_there_already_are_skipped(rig, restriction):
    """
    An extra joint that the hardware or an earlier entry has adds nothing.

    joint_state_broadcaster.cpp, init_joint_data.
    """
    r = rig()
    states = broadcaster(r, extra_joints=['a', 'x', 'x'], **restriction)
    r.hardware.state.position[:] = [1.0, 2.0]
    r.step()
    (sample,) = samples(states)
    assert sample.names == (('a', 'x') if restriction else ('a', 'b', 'x'))
    assert sample.position[0] == 1.0
    assert [owner for owner, _, _ in sample.dynamic] == list(sample.names)


def test_interface_map(rig):
    """M2: another interface fills an array, and has the array's name in dynamic_joint_states."""
    r = rig()
    states = broadcaster(r, map_interface_to_joint_state={'effort': 'acceleration'})
    r.hardware.state.acceleration[:] = [7.0, 8.0]
    r.step()
    (sample,) = samples(states)
    np.testing.assert_array_equal(sample.effort, [7.0, 8.0])
    assert sample.dynamic[0] == ('a', ('position', 'velocity', 'effort'), (0.0, 0.0, 7.0))


def test_interface_map_takes_the_interface_away_from_its_own_array(rig):
    """
    A standard interface that is mapped to another array is missing in its own.

    joint_state_broadcaster.cpp, on_configure: each interface has a single name.
    """
    r = rig()
    states = broadcaster(r, map_interface_to_joint_state={'effort': 'velocity'})
    r.hardware.state.velocity[:] = [7.0, 8.0]
    r.step()
    (sample,) = samples(states)
    np.testing.assert_array_equal(sample.effort, [7.0, 8.0])
    assert np.isnan(sample.velocity).all()


def test_interface_map_of_any_name(rig):
    """Any interface can be mapped; its owner is published then (init_joint_data)."""
    r = rig()
    r.hardware.given_states.update({'valve/flow': 3.0})
    states = broadcaster(
        r, map_interface_to_joint_state={'velocity': 'flow'}, use_urdf_to_filter=False)
    r.step()
    (sample,) = samples(states)
    assert sample.names == ('a', 'b', 'valve')
    np.testing.assert_array_equal(sample.velocity, [0.0, 0.0, 3.0])


def test_interface_map_without_effect(rig):
    """
    A mapping is ignored, with a warning, where its standard interface is asked for.

    joint_state_broadcaster.cpp, on_configure.
    """
    r = rig()
    states = broadcaster(r, joints=['a'], interfaces=['effort', 'acceleration'],
                         map_interface_to_joint_state={'effort': 'acceleration'})
    r.hardware.state.acceleration[:] = 7.0
    r.hardware.state.effort[:] = 1.0
    r.step()
    (sample,) = samples(states)
    np.testing.assert_array_equal(sample.effort, [1.0])
    assert sample.dynamic == (('a', ('effort', 'acceleration'), (1.0, 7.0)),)
    assert any('map_interface_to_joint_state.effort' in text for text in r.texts())


def test_dynamic_joint_states(rig):
    """M1, M2: every interface of every joint."""
    r = rig()
    states = broadcaster(r)
    r.step()
    joint, names, values = samples(states)[0].dynamic[1]
    assert (joint, names) == ('b', ('position', 'velocity', 'acceleration', 'effort'))
    assert len(values) == 4


def test_the_layout_follows_the_interfaces_at_activation(rig, monkeypatch):
    """Another activation publishes the interfaces of that time (on_activate)."""
    r = rig()
    states = broadcaster(r)
    r.manager.switch(deactivate=['states'])
    monkeypatch.setattr(type(r.hardware), 'state_interfaces', {'b': ('position',)})
    assert r.manager.switch(['states']).ok
    r.step()
    assert samples(states)[-1].names == ('b',)
    assert samples(states) == []


def test_without_state_interfaces_activation_fails(rig, monkeypatch):
    """A broadcaster with nothing to publish does not become active (init_joint_data)."""
    r = rig()
    monkeypatch.setattr(type(r.hardware), 'state_interfaces', {})
    r.load('states', BROADCASTER)
    result = r.manager.switch(['states'])
    assert not result.ok
    assert 'no state interfaces' in result.message


def test_states_of_controllers_are_not_needed(rig):
    """A broadcaster of everything becomes active beside a controller that exports states."""
    r = rig()
    r.load('loop', 'pid_controller/PidController', dof_names=['a'], command_interface='velocity',
           reference_and_state_interfaces=['position'], gains={'a': {'p': 1.0}})
    states = broadcaster(r)
    r.step()
    assert samples(states)[0].names == ('a', 'b')


def test_nothing_is_claimed(rig):
    """A broadcaster claims no command interface."""
    r = rig()
    broadcaster(r)
    assert r.hardware.claimed == {}


def test_listener_is_called(rig):
    """The one who publishes is called for every sample."""
    r = rig()
    calls = []
    broadcaster(r, publish_rate=50).listen(lambda: calls.append(1))
    r.step(10)
    assert len(calls) == 5


def test_no_update_is_made_for_samples_that_nobody_wants(rig):
    """Only where somebody listens a sample is a reason to make an update."""
    states = broadcaster(rig(), publish_rate=50)
    assert states.next_update(0) == NEVER_NS
    states.listen(lambda: None)
    assert states.next_update(0) < NEVER_NS
    states.listen(None)
    assert states.next_update(0) == NEVER_NS


def test_calm_listeners_get_fewer_samples_of_an_arm_at_rest(rig, monkeypatch):
    """Every second update is left out, as long as no drive moves and no other listener came."""
    monkeypatch.setattr('armsim_ros.control.broadcaster.CALM_RATE', 50.0)
    r = rig()
    states = broadcaster(r, publish_rate=100)
    counts = []
    for calm, resting in ((True, True), (True, False), (True, True), (False, True)):
        states.calm = calm
        monkeypatch.setattr(type(r.hardware), 'resting', resting)
        r.step(2)
        samples(states)
        r.step(10)
        counts.append(len(samples(states)))
    assert counts == [5, 10, 5, 10]


def test_a_sample_is_not_taken_twice_because_its_listener_is_not_calm_any_more(rig, monkeypatch):
    """The rates take turns without two samples of a time."""
    r = rig()
    states = broadcaster(r, publish_rate=100)
    monkeypatch.setattr(type(r.hardware), 'resting', True)
    r.step(2)
    samples(states)
    time_ns = r.now_ns
    for calm in (True, False):
        states.calm = calm
        states.update(time_ns, 0.01)
    assert [sample.time_ns for sample in samples(states)] == [time_ns]


def test_a_rate_that_is_slow_already_stays_as_it_is(rig, monkeypatch):
    """Calm listeners are no reason for more samples."""
    r = rig()
    states = broadcaster(r, publish_rate=50)
    states.calm = True
    monkeypatch.setattr(type(r.hardware), 'resting', True)
    r.step(10)
    assert len(samples(states)) == 5


def test_rate_starts_anew_when_time_jumps_back():
    """A reset of simulated time does not silence what is published at a rate."""
    rate = Rate(10.0)
    assert [rate.due(t) for t in (1_000_000_000, 1_050_000_000, 1_100_000_000)] == [1, 0, 1]
    assert [rate.due(t) for t in (0, 50_000_000, 100_000_000)] == [1, 0, 1]


def test_rate_does_not_make_up_for_what_was_missed():
    """After a gap there is one, not many."""
    rate = Rate(10.0)
    assert [rate.due(t) for t in (0, 950_000_000, 960_000_000, 1_000_000_000)] == [1, 1, 0, 1]


def test_rate_keeps_its_mean_between_ticks():
    """A rate that does not divide the updates is kept on average."""
    rate = Rate(30.0)
    assert sum(rate.due(t * 1_000_000) for t in range(10_000)) == 300


def test_rates_that_are_aligned_are_due_at_the_same_times():
    """Whenever it was asked first, it is due at multiples of the period of time itself."""
    rate = Rate(50.0, aligned=True)
    start = 1_700_000_000_013_000_000
    due = [t for t in range(0, 50_000_000, 1_000_000) if rate.due(start + t)]
    assert due == [0, 7_000_000, 27_000_000, 47_000_000]
