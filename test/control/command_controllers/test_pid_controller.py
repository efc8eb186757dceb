# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The PID controller: references, measured states, feed-forward, what it refuses."""

import math

import numpy as np
import pytest

from armsim_ros.errors import ControllerError

PID = 'pid_controller/PidController'
BOTH = ['a', 'b']


@pytest.fixture
def loop(rig):
    """Return joints with an active PID controller, by what differs from the usual one."""

    def make(p=20.0, more=(), **parameters):
        made = rig()
        gains = {name: {'p': p, **dict(more)} for name in BOTH}
        controller = made.load('loop', PID, **{
            'dof_names': BOTH, 'command_interface': 'velocity',
            'reference_and_state_interfaces': ['position'], 'gains': gains, **parameters})
        assert made.manager.switch(activate=['loop']).ok
        made.step()
        return made, controller

    return make


def test_follows_references_by_name(loop):
    """References come in any order; those that are not named stay as they are."""
    made, controller = loop()
    assert controller.receive(['b', 'a'], [0.2, 0.1], []) == ''
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.1, 0.2], atol=1e-3)
    assert controller.receive(['b'], [0.3], []) == ''
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.1, 0.3], atol=1e-3)


def test_references_between_two_updates(loop):
    """Each message counts, also where another one comes before the next update."""
    made, controller = loop()
    assert controller.receive(['a'], [0.1], []) == ''
    assert controller.receive(['b'], [0.2], []) == ''
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.1, 0.2], atol=1e-3)


def test_names_may_be_left_away(loop):
    """Without names the values are in the order of the degrees of freedom."""
    made, controller = loop()
    assert controller.receive([], [0.1, 0.2], []) == ''
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.1, 0.2], atol=1e-3)


def test_first_setpoint(loop):
    """It holds what is measured until a reference comes, or commands nothing at all."""
    made, _ = loop()
    made.hardware.state.position[0] += 0.1
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, 0.0, atol=1e-3)
    made, _ = loop(set_current_state_as_first_setpoint=False)
    made.hardware.state.position[0] += 0.1
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.1, 0.0], atol=1e-3)


def test_the_first_setpoint_is_at_rest(loop):
    """
    The first reference of a velocity is 0, whatever the joint's velocity at the activation.

    pid_controller/src/pid_controller.cpp: PidController::on_activate takes the measured velocity.
    """
    made, controller = loop(reference_and_state_interfaces=['position', 'velocity'])
    assert made.manager.switch(deactivate=['loop']).ok
    made.hardware.state.position[:] = [0.1, 0.2]
    made.hardware.state.velocity[:] = 0.5
    assert made.manager.switch(activate=['loop']).ok
    made.step()
    np.testing.assert_allclose(controller.snapshot().reference, [[0.1, 0.2], [0.0, 0.0]])


def test_derivative_of_the_error(loop):
    """With two interfaces the derivative comes from them, with one from the error."""
    for interfaces in (['position'], ['position', 'velocity']):
        made, controller = loop(p=0.0, more={'d': 1.0}, reference_and_state_interfaces=interfaces,
                                command_interface='effort')
        made.hardware.state.velocity[:] = 0.5
        made.hardware.state.position[:] = 0.005
        made.step()
        assert controller.snapshot().error[1, 0] == pytest.approx(-0.5)
        assert made.hardware.command.effort[0] == pytest.approx(-0.5)


@pytest.mark.parametrize('by', ['service', 'parameter'])
def test_feedforward(loop, by):
    """The reference's own part is added when the service or the parameter says so."""
    made, controller = loop(p=0.0, more={'feedforward_gain': 2.0})
    controller.receive(BOTH, [0.1, 0.2], [])
    made.step()
    np.testing.assert_allclose(controller.snapshot().output, 0.0)
    if by == 'service':
        controller.set_feedforward(True)
    else:
        controller.set_parameters({'enable_feedforward': True})
    made.step()
    np.testing.assert_allclose(controller.snapshot().output, [0.2, 0.4])


def test_the_last_writer_of_the_feedforward_wins(loop):
    """
    The service switches off what the parameter switched on; a change of parameters resets it.

    pid_controller.cpp: update_parameters and the service write the same flag.
    """
    made, controller = loop(p=0.0, more={'feedforward_gain': 2.0}, enable_feedforward=True)
    controller.receive(BOTH, [0.1, 0.2], [])
    outputs = []
    for write in (lambda: None, lambda: controller.set_feedforward(False),
                  lambda: controller.set_parameters({'gains.a.d': 0.0})):
        write()
        made.step()
        outputs.append(controller.snapshot().output[1])
    np.testing.assert_allclose(outputs, [0.4, 0.0, 0.4])


def test_wraparound(loop):
    """Where angles wrap around, the shorter way is taken."""
    made, controller = loop(p=1.0, more={'angle_wraparound': True})
    controller.receive(BOTH, [math.tau - 0.1, 0.1], [])
    made.step()
    np.testing.assert_allclose(controller.snapshot().output, [-0.1, 0.1], atol=1e-9)


def test_external_measurement(loop):
    """States from a topic close the loop; before the first one nothing is commanded."""
    made, controller = loop(p=1.0, use_external_measured_states=True)
    assert controller.required_state_interfaces == ()
    controller.receive(BOTH, [0.5, 0.5], [])
    made.step()
    assert np.isnan(controller.snapshot().output).all()
    assert controller.measure(BOTH, [0.2, 0.4], []) == ''
    made.step()
    np.testing.assert_allclose(controller.snapshot().output, [0.3, 0.1])


def test_live_gains(loop):
    """New gains count from the next update on."""
    made, controller = loop(p=1.0)
    controller.receive(BOTH, [0.1, 0.1], [])
    made.step()
    before = controller.snapshot()
    controller.set_parameters({'gains.a.p': 3.0})
    made.step()
    after = controller.snapshot()
    np.testing.assert_allclose(after.output, after.error[0] * [3.0, 1.0])
    assert after.output[0] > before.output[0]


@pytest.mark.parametrize(
    ('message', 'word'),
    [
        ((['x'], [0.1], []), "'x'"),
        ((['a', 'a'], [0.1, 0.1], []), 'twice'),
        ((['a'], [0.1, 0.2], []), '2 values for 1 names'),
        (([], [0.1], []), '1 values for 2 names'),
        ((['a'], [math.inf], []), 'inf'),
        ((['a'], [math.nan], []), 'nan'),
        (([], [], []), '0 values'),
    ],
)
def test_garbage(loop, message, word):
    """What is no reference moves nothing, and the reason is said."""
    made, controller = loop()
    assert word in controller.receive(*message)
    made.run(0.2)
    np.testing.assert_allclose(made.hardware.state.position, 0.0, atol=1e-12)
    assert any(word in text for text in made.texts())


def test_a_single_interface_has_no_use_for_derivatives_of_references(loop):
    """pid_controller.cpp, reference_callback: the reference is taken all the same."""
    made, controller = loop()
    assert controller.receive(BOTH, [0.1, 0.2], [0.5, 0.5]) == ''
    made.step()
    np.testing.assert_array_equal(controller.snapshot().reference, [[0.1, 0.2]])


def test_references_with_the_derivatives_of_the_first_names(loop):
    """The others stay as they are (pid_controller.cpp, reset_controller_reference_msg)."""
    made, controller = loop(reference_and_state_interfaces=['position', 'velocity'])
    assert controller.receive(['b', 'a'], [0.2, 0.1], [0.5]) == ''
    made.step()
    np.testing.assert_array_equal(controller.snapshot().reference, [[0.1, 0.2], [0.0, 0.5]])


def test_a_single_interface_takes_no_measured_derivatives(loop):
    """pid_controller.cpp, on_configure: values_dot of a measured state needs two interfaces."""
    made, controller = loop(use_external_measured_states=True)
    made.texts()
    assert 'derivatives' in controller.measure(BOTH, [0.1, 0.2], [0.5, 0.5])
    assert any('derivatives' in text for text in made.texts())


@pytest.mark.parametrize(
    ('changes', 'missing'),
    [
        ({'dof_names': []}, 'dof_names'),
        ({'command_interface': ''}, 'command_interface'),
        ({'reference_and_state_interfaces': []}, 'reference_and_state_interfaces'),
        ({'reference_and_state_dof_names': ['a', 'b']}, 'reference_and_state_dof_names'),
        ({'gains': {'a': {}, 'z': {}}}, "'z'"),
        ({'dof_names': ['a-b'], 'gains': {'a-b': {'activate_state_publisher': True}}}, "'a-b'"),
    ],
)
def test_missing_parameters(rig, changes, missing):
    """What is needed and missing, or fits nothing, is named."""
    good = {'dof_names': ['a'], 'command_interface': 'effort', 'gains': {'a': {'p': 1.0}},
            'reference_and_state_interfaces': ['position']}
    if changes.get('dof_names') == []:
        good['gains'] = {}
    with pytest.raises(ControllerError, match=missing):
        rig().load('loop', PID, **{**good, **changes})


def test_gains_that_are_not_given_are_zero_and_can_be_set(rig):
    """Each degree of freedom has gains (pid_controller.yaml: gains.__map_dof_names)."""
    made = rig()
    controller = made.load('loop', PID, dof_names=BOTH, command_interface='velocity',
                           reference_and_state_interfaces=['position'], gains={'b': {'p': 20.0}})
    assert made.manager.switch(activate=['loop']).ok
    controller.receive([], [0.1, 0.1], [])
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, [0.0, 0.1], atol=1e-3)
    controller.set_parameters({'gains.a.p': 20.0})
    made.run(1.0)
    np.testing.assert_allclose(made.hardware.state.position, 0.1, atol=1e-3)


def test_the_source_of_states_changes_with_configure(loop):
    """Re-enacts pid_controller.cpp: on_configure subscribes to external measured states."""
    made, controller = loop()
    controller.set_parameters({'use_external_measured_states': True})
    assert controller.required_state_interfaces == ('a/position', 'b/position')
    assert made.manager.switch(deactivate=['loop']).ok
    made.manager.configure('loop')
    assert controller.required_state_interfaces == ()


def test_exported_states(loop):
    """What it measures can be read by others under its name."""
    made, _ = loop()
    made.hardware.state.position[:] = [0.3, 0.4]
    made.step()
    states = [made.hardware.other_states[f'loop/{name}/position'] for name in BOTH]
    np.testing.assert_allclose(states, [0.3, 0.4])


@pytest.mark.parametrize('kept', [True, False])
def test_the_integral_part_may_survive_a_deactivation(loop, kept):
    """save_i_term decides what the next activation begins with (PidROS::reset)."""
    made, controller = loop(p=0.0, more={'i': 1.0, 'save_i_term': kept})
    made.hardware.frozen = True
    controller.receive(['a'], [1.0], [])
    made.run(0.5)
    before = made.hardware.command.velocity[0]
    assert before == pytest.approx(0.5, abs=0.02)
    assert controller.snapshot().integral[0] == pytest.approx(before)
    made.manager.switch(deactivate=['loop'])
    made.manager.switch(activate=['loop'])
    made.step()
    assert made.hardware.command.velocity[0] == pytest.approx(before if kept else 0.0, abs=1e-9)
