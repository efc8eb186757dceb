# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Chains: who may start and stop, in which order, and what reaches the joints."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.control.controller import LifecycleState
from armsim_ros.errors import ControllerError

BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'
PID = 'pid_controller/PidController'
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
FORWARD = 'forward_command_controller/ForwardCommandController'
BOTH = ['a', 'b']


@pytest.fixture
def chain(rig):
    """Return joints with a trajectory controller that writes to a PID controller's references."""
    made = rig()
    # The preceding one is loaded first: the order of loading must not matter.
    made.manager.load(_settings('arm', TRAJECTORY, joints=BOTH,
                                command_joints=['loop/a', 'loop/b']))
    made.manager.load(_settings(
        'loop', PID, dof_names=BOTH, command_interface='velocity',
        reference_and_state_interfaces=['position'],
        gains={name: {'p': 20.0} for name in BOTH}))
    for name in ('arm', 'loop'):
        made.manager.configure(name)
    return made


def _settings(name, type, **parameters):  # noqa: A002
    return SimpleNamespace(name=name, type=type, parameters=parameters)


def _info(made, name):
    return next(one for one in made.manager.list_controllers() if one.name == name)


def _states(made):
    return {one.name: one.state for one in made.manager.list_controllers()}


def test_trajectory_through_a_chain(chain, trajectory):
    """The references of the preceding controller move the joints in the same cycle."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    chain.step()
    arm = chain.manager.controllers['arm']
    assert arm.send_goal(trajectory((1.0, [0.5, -0.5]))).accepted
    chain.run(2.0)
    np.testing.assert_allclose(chain.hardware.state.position, [0.5, -0.5], atol=5e-3)
    references = [chain.hardware.references[f'loop/{name}/position'] for name in BOTH]
    np.testing.assert_allclose(references, [0.5, -0.5], atol=1e-9)


def test_same_cycle(chain, trajectory):
    """What the preceding controller writes in an update is followed in that update."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    chain.step()
    chain.manager.controllers['arm'].send_goal(trajectory((1.0, [0.5, 0.0])))
    for _ in range(20):
        before = chain.hardware.state.position[0]
        chain.step()
        wanted = chain.hardware.references['loop/a/position']
        assert chain.hardware.command.velocity[0] == pytest.approx(20.0 * (wanted - before))


def test_preceding_alone_is_refused(chain):
    """A controller that writes to another one's references does not start without it."""
    result = chain.manager.switch(activate=['arm'])
    assert not result.ok
    assert "'arm' writes to references of 'loop', which is not active" in result.message
    assert set(_states(chain).values()) == {'inactive'}


def test_follower_alone_runs_unchained(chain):
    """A following controller may run alone, and takes its own topic then."""
    assert chain.manager.switch(activate=['loop']).ok
    chain.step()
    assert not _info(chain, 'loop').chained
    assert chain.manager.controllers['loop'].receive(BOTH, [0.2, 0.1], []) == ''
    chain.run(1.0)
    np.testing.assert_allclose(chain.hardware.state.position, [0.2, 0.1], atol=1e-3)


def test_own_topic_is_ignored_while_chained(chain):
    """What comes from the topic changes nothing while another controller writes; it says why."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    chain.step()
    reason = chain.manager.controllers['loop'].receive(BOTH, [1.0, 1.0], [])
    chain.run(0.5)
    assert 'another controller' in reason
    assert any('another controller' in text for text in chain.texts())
    np.testing.assert_allclose(chain.hardware.state.position, 0.0, atol=1e-9)


def test_used_follower_stays(chain):
    """A following controller that is still used cannot be deactivated by itself."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    result = chain.manager.switch(deactivate=['loop'])
    assert not result.ok
    assert "'arm' writes to its references" in result.message
    assert set(_states(chain).values()) == {'active'}


def test_best_effort_leaves_the_broken_part_out(chain):
    """Without strictness what would break a chain is left out, and the rest is done."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    chain.load('extra', FORWARD, joints=['nowhere'], interface_name='position')
    chain.manager.switch(deactivate=['loop'], strictness=1)
    assert set(_states(chain).values()) == {'active', 'inactive'}
    assert _states(chain)['loop'] == 'active'


def test_order_of_activation(chain, monkeypatch):
    """The following controller starts first and stops last, whatever order is asked for."""
    calls = []
    for name in ('arm', 'loop'):
        controller = chain.manager.controllers[name]
        for verb in ('activate', 'deactivate'):
            original = getattr(controller, verb)

            def noted(time_ns, call=f'{verb} {name}', original=original):
                calls.append(call)
                original(time_ns)

            monkeypatch.setattr(controller, verb, noted)
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    assert chain.manager.switch(deactivate=['loop', 'arm']).ok
    assert calls == ['activate loop', 'activate arm', 'deactivate arm', 'deactivate loop']


def test_chain_can_be_opened_and_closed(chain):
    """When the preceding controller stops, the follower goes on without a step, by itself."""
    assert chain.manager.switch(activate=['loop', 'arm']).ok
    chain.run(0.2)
    assert chain.manager.switch(deactivate=['arm']).ok
    before = chain.hardware.state.position.copy()
    chain.run(0.5)
    np.testing.assert_allclose(chain.hardware.state.position, before, atol=1e-9)
    assert not _info(chain, 'loop').chained
    assert chain.manager.controllers['loop'].receive(BOTH, [0.1, 0.1], []) == ''
    chain.run(1.0)
    assert chain.manager.switch(activate=['arm']).ok
    assert _info(chain, 'loop').chained
    chain.run(0.5)
    np.testing.assert_allclose(chain.hardware.state.position, 0.1, atol=2e-3)


def test_failure_of_the_follower_stops_the_chain(chain, monkeypatch):
    """Where a following controller fails, the preceding one is stopped with it."""
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    monkeypatch.setattr(chain.manager.controllers['loop'], 'follow',
                        lambda *_: (_ for _ in ()).throw(RuntimeError('broken')))
    chain.step(2)
    assert set(_states(chain).values()) == {'inactive'}
    assert any('broken' in text for text in chain.texts())


def test_what_is_listed(chain):
    """list_controllers tells of references, chains and connections as the original does."""
    loop, arm = _info(chain, 'loop'), _info(chain, 'arm')
    assert (loop.chainable, loop.chained, arm.chainable) == (True, False, False)
    assert loop.references == ('a/position', 'b/position') == loop.exported_states
    assert arm.connections == {'loop': ('a/position', 'b/position')}
    assert loop.connections == {}
    assert chain.manager.switch(activate=['arm', 'loop']).ok
    assert _info(chain, 'loop').chained


def test_a_chain_is_listed_from_its_beginning(rig):
    """
    list_controllers has preceding controllers before those that follow, however they were loaded.

    controller_manager.cpp, ControllerManager::configure_controller.
    """
    made = rig()
    made.load('loop', PID, dof_names=['a'], command_interface='velocity',
              reference_and_state_interfaces=['position'], gains={'a': {'p': 20.0}})
    made.load('stream', FORWARD, joints=['loop/a'], interface_name='position')
    assert list(_states(made)) == ['stream', 'loop']


def test_references_among_the_interfaces(chain):
    """References are available while their controller is active, and gone with it."""
    def shown():
        return {one.name: (one.is_available, one.is_claimed)
                for one in chain.manager.list_hardware_interfaces()[0] if '/' in one.name[5:]
                and one.name.startswith('loop/')}

    assert shown() == {'loop/a/position': (False, False), 'loop/b/position': (False, False)}
    chain.manager.switch(activate=['loop'])
    assert shown() == {'loop/a/position': (True, False), 'loop/b/position': (True, False)}
    chain.manager.switch(activate=['arm'])
    assert shown() == {'loop/a/position': (True, True), 'loop/b/position': (True, True)}
    chain.manager.switch(deactivate=['arm', 'loop'])
    chain.manager.unload('loop')
    assert shown() == {}
    assert chain.hardware.references == {}
    result = chain.manager.switch(activate=['arm'])
    assert not result.ok
    assert 'loop/a/position' in result.message


def test_forward_controller_in_a_chain(rig):
    """Commands of a forward controller are references too."""
    made = rig()
    made.load('loop', PID, dof_names=['a'], command_interface='velocity',
              reference_and_state_interfaces=['position'], gains={'a': {'p': 20.0}})
    made.load('stream', FORWARD, joints=['loop/a'], interface_name='position')
    assert made.manager.switch(activate=['stream', 'loop']).ok
    made.step()
    assert made.manager.controllers['stream'].receive([0.3]) == ''
    made.run(1.0)
    assert made.hardware.state.position[0] == pytest.approx(0.3, abs=1e-3)


@pytest.fixture
def reader(rig):
    """Return joints with a controller that reads the states that another exports."""
    made = rig()
    # The reader is loaded first: the order of loading must not matter.
    made.load('outer', PID, dof_names=['b'], command_interface='velocity',
              reference_and_state_dof_names=['inner/a'],
              reference_and_state_interfaces=['position'], gains={'b': {'p': 2.0}})
    made.load('inner', PID, dof_names=['a'], command_interface='velocity',
              reference_and_state_interfaces=['position'], gains={'a': {'p': 2.0}})
    return made


def test_a_reader_starts_with_the_controller_that_exports(reader):
    """
    A controller that reads exported states starts after their controller, and not without it.

    Upstream: controller_manager.cpp, check_following_controllers_for_activate.
    """
    result = reader.manager.switch(activate=['outer'])
    assert not result.ok
    assert "'outer' reads states of 'inner', which is not active" in result.message
    assert reader.manager.switch(activate=['outer', 'inner']).ok
    assert not _info(reader, 'inner').chained
    assert not reader.manager.switch(['outer'], ['outer', 'inner']).ok


def test_a_controller_whose_states_are_read_stays(reader):
    """
    A controller that exports states which are read is not deactivated without the reader.

    Upstream: controller_manager.cpp, check_preceding_controllers_for_deactivate.
    """
    assert reader.manager.switch(activate=['inner', 'outer']).ok
    result = reader.manager.switch(deactivate=['inner'])
    assert not result.ok
    assert "'outer' reads its states" in result.message
    assert set(_states(reader).values()) == {'active'}
    assert reader.manager.switch(deactivate=['inner', 'outer']).ok


def test_exported_states_are_read_in_the_update_that_measures_them(reader):
    """
    A controller is updated after those whose states it reads.

    Upstream: controller_manager.cpp, update_list_with_controller_chain.
    """
    assert list(_states(reader)) == ['inner', 'outer']
    assert reader.manager.switch(activate=['inner', 'outer']).ok
    reader.step()
    reader.hardware.state.position[0] = 0.7
    reader.step()
    assert reader.manager.controllers['outer'].snapshot().feedback[0] == 0.7


def test_a_failure_stops_what_reads_the_states(reader, monkeypatch):
    """
    Where a controller fails, the controllers that read its states are deactivated with it.

    Upstream: controller_manager.cpp, build_controllers_topology_info and get_full_chain_spec.
    """
    assert reader.manager.switch(activate=['inner', 'outer']).ok
    monkeypatch.setattr(reader.manager.controllers['inner'], 'follow',
                        lambda *_: (_ for _ in ()).throw(RuntimeError('broken')))
    reader.step(2)
    assert set(_states(reader).values()) == {'inactive'}


def test_a_broadcaster_of_all_states_holds_no_controller(reader):
    """
    The joint_state_broadcaster publishes what there is; what it reads may be deactivated.

    Upstream: controller_manager.cpp, check_following_controllers_for_activate.
    """
    reader.load('states', BROADCASTER)
    assert reader.manager.switch(activate=['inner', 'states']).ok
    assert reader.manager.switch(deactivate=['inner']).ok
    assert _states(reader)['states'] == 'active'


@pytest.mark.parametrize('names', [['loop/a'], ['loop/a', 'b'], ['a', 'c']])
def test_command_joints_that_fit_nothing(rig, names):
    """Joints of following controllers are given for all joints or none."""
    made = rig()
    with pytest.raises(ControllerError, match='command_joints'):
        made.load('arm', TRAJECTORY, joints=BOTH, command_joints=names)
    assert made.manager.controllers['arm'].state is LifecycleState.UNCONFIGURED
