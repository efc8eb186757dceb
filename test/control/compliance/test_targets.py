# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Targets that are dropped, parameters that are refused, warnings about gravity."""


import numpy as np
import pytest

from armsim_ros.config.prefix import prefixed_settings
from armsim_ros.errors import ControllerError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.stack import ArmSim

UP = (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(('send', 'words'), [
    (lambda c: c.receive_pose('', (np.nan, 0.0, 0.5), UP), 'nan'),
    (lambda c: c.receive_pose('', (0.3, 0.0, 0.5), (0.0,) * 4), 'quaternion'),
    (lambda c: c.receive_pose('kitchen', (0.3, 0.0, 0.5), UP), "'kitchen'"),
    (lambda c: c.receive_joints((), (0.0, 1.0), ()), 'positions'),
    (lambda c: c.receive_joints(('elbow',), (0.0,), ()), 'elbow'),
    (lambda c: c.receive_joints((), (), (np.inf,) * 7), 'velocities'),
    (lambda c: c.receive_wrench((np.nan,) * 6), 'nan'),
    (lambda c: c.receive_stiffness((1.0, 2.0)), 'six'),
])
def test_wrong_targets_are_dropped_and_named(compliant, send, words):
    """The arm stays where it is, and a warning names what was wrong."""
    arm = compliant()
    place = arm.place
    assert words in send(arm.controller)
    arm.run(0.2)
    assert len(arm.events) == 1
    assert words in arm.events[0]
    assert np.linalg.norm(arm.place - place) < 0.002


@pytest.mark.parametrize('values', [(100.0,) * 5, (100.0,) * 7, (np.inf,) * 6])
def test_a_stiffness_to_yield_with_has_six_finite_numbers(compliant, values):
    """Anything else is dropped, and named."""
    controller = compliant('cartesian_admittance_controller').controller
    assert 'six finite numbers' in controller.receive_yielding_stiffness(values)
    assert controller.receive_yielding_stiffness((100.0,) * 6) == ''


def test_a_target_in_the_frame_of_a_link(compliant):
    """It is taken where the link is then: a way in the hand's own axes."""
    arm = compliant()
    place, turn = arm.place, arm.tip[:3, :3]
    assert arm.controller.receive_pose('panda_hand_tcp', (0.0, 0.0, 0.05), UP) == ''
    arm.run(3.0)
    np.testing.assert_allclose(arm.place - place, 0.05 * turn[:, 2], atol=0.004)


def test_an_inactive_controller_takes_no_targets(panda, load):
    """Without a word: it may be one of several that hear the same topic."""
    controller = load(ArmSim(panda).managers['panda'], 'cartesian_impedance_controller')
    assert controller.receive_wrench((0.0,) * 6)
    assert controller.poll_events() == []


def test_too_large_stiffness_is_bounded(compliant):
    """What the topic sends beyond variable_max_stiffness takes effect as that, with a warning."""
    arm = compliant()
    assert arm.controller.receive_stiffness((2000.0, 500.0, 500.0, 30.0, 30.0, 30.0)) == ''
    arm.run(0.1)
    assert '900' in arm.events[0]
    assert arm.controller._gains.stiffness.tolist() == [900.0, 500.0, 500.0, 30.0, 30.0, 30.0]


@pytest.mark.parametrize(('name', 'value', 'words'), [
    ('task.k_pos_x', 5001.0, '5000'),
    ('nullspace.regularization', 1.0, '0.0001'),
    ('nullspace.projector_type', 'kinetic', 'kinematic'),
    ('task.k_pos', 1.0, 'k_pos'),
    ('end_effector_frame', 'panda_link8', 'read-only'),
])
def test_parameters_out_of_bounds_are_refused(panda, load, name, value, words):
    """The bound, the allowed words or the name is in the message."""
    controller = load(ArmSim(panda).managers['panda'], 'cartesian_impedance_controller')
    with pytest.raises(ControllerError, match=words):
        controller.set_parameters({name: value})


def test_every_joint_has_a_weight(panda, load):
    """Clients read all parameters before they set them."""
    controller = load(ArmSim(panda).managers['panda'], 'joint_impedance_controller')
    controller.set_parameters({'nullspace.weights.panda_joint3.value': 8.0})
    weights = controller.parameters.nullspace.weights
    assert [weight.value for weight in weights.values()] == [1.0, 1.0, 8.0, 1.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(('parameters', 'words'), [
    ({'end_effector_frame': 'panda_hnad'}, 'panda_hand'),
    ({'joints': ['panda_joint8']}, 'panda_joint8'),
    ({'joints': ['panda_finger_joint1']}, 'does not move'),
    ({'end_effector_frame': ''}, 'missing'),
])
def test_names_are_checked_when_it_is_configured(panda, load, parameters, words):
    """A link or joint that the robot lacks is named."""
    with pytest.raises(ControllerError, match=words):
        load(ArmSim(panda).managers['panda'], 'cartesian_impedance_controller', **parameters)


def test_gravity_that_is_compensated_twice_is_a_warning(compliant):
    """It names both settings."""
    arm = compliant(use_gravity_compensation=True)
    arm.run(0.02)
    (text,) = arm.events
    assert 'servo.gravity_compensation' in text
    assert 'use_gravity_compensation' in text


def test_gravity_that_nobody_compensates(panda, load):
    """The arm sinks, after a warning; with the controller's own compensation it stays."""
    heavy = load_cell('panda', overrides={'simulation.servo.gravity_compensation': False})
    sunk = []
    for own in (False, True):
        sim = ArmSim(heavy)
        manager = sim.managers['panda']
        load(manager, 'cartesian_impedance_controller', use_gravity_compensation=own)
        before = sim.simulation.link_pose('panda_hand_tcp')[2, 3]
        manager.switch(activate=['cartesian_impedance_controller'],
                       deactivate=['panda_arm_controller'])
        for _ in range(250):
            sim.step()
        sunk.append(before - sim.simulation.link_pose('panda_hand_tcp')[2, 3])
        warned = any('sinks' in event.text for event in manager.poll_events())
        assert warned is not own
    assert sunk[0] > 0.01
    assert abs(sunk[1]) < 0.002


def test_broadcasters_sample_the_tip(panda, load):
    """The pose in the base frame, the velocities in the tip's own axes."""
    sim = ArmSim(panda)
    manager = sim.managers['panda']
    pose, twist = (load(manager, f'{kind}_broadcaster') for kind in ('pose', 'twist'))
    assert manager.switch(activate=['pose_broadcaster', 'twist_broadcaster']).ok
    state = sim.simulation.state
    state.velocity[:7] = np.linspace(-0.3, 0.3, 7)
    frame = sim.simulation.link_pose('panda_hand_tcp')
    for broadcaster in (pose, twist):
        broadcaster.sample(sim.loop.clock.now_ns if hasattr(sim.loop, 'clock') else 0)
    np.testing.assert_allclose(pose.poll().values[:3], frame[:3, 3], atol=1e-6)
    found, step = twist.poll().values, 1e-6
    model = pose._arm
    model.move(state.position[:7] + step * state.velocity[:7], state.velocity[:7])
    moved = (model.pose[:3, 3] - frame[:3, 3]) / step
    np.testing.assert_allclose(found[:3], frame[:3, :3].T @ moved, atol=1e-4)


def test_a_prefix_renames_links_joints_and_weights(panda, load):
    """Two such arms in a cell keep their names apart."""
    settings = panda.robots[0].settings
    controller = load(ArmSim(panda).managers['panda'], 'joint_impedance_controller')
    entry = settings.controllers[0].model_copy(
        update={'name': controller.name, 'type': controller.type, 'parameters':
                controller.parameters})
    renamed = prefixed_settings(
        settings.model_copy(update={'controllers': (entry,)}), 'left_', 'left')
    parameters = renamed.controllers[0].parameters
    assert parameters.joints[0] == 'left_panda_joint1'
    assert parameters.end_effector_frame == 'left_panda_hand_tcp'
    assert list(parameters.nullspace.weights) == list(parameters.joints)
