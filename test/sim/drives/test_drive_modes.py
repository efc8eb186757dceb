# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the drives do with the interfaces that controllers claim."""

from dataclasses import replace

import numpy as np
import pytest

from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import JointLimits, JointType, Mimic
from armsim_ros.sim.drives.reference import fingers_driven
from armsim_ros.sim.simulation import Simulation


def run(simulation, steps):
    """Step with the present commands."""
    for _ in range(steps):
        simulation.write()
        simulation.step()


@pytest.mark.parametrize(
    'claimed',
    [{'acceleration'}, {'velocity', 'effort'}, {'position', 'acceleration'}],
)
def test_refuses_interfaces_that_do_not_go_together(simulation, claim, claimed):
    """An impossible claim names joint and legal sets, and leaves the modes as they were."""
    with pytest.raises(SimulationError, match=r"'shoulder'.*\[position, velocity\]"):
        claim(simulation, *claimed)
    simulation.command.position[:] = 0.1
    run(simulation, 300)
    np.testing.assert_allclose(simulation.state.position, 0.1, atol=1e-3)


def test_refuses_a_claim_of_an_unknown_joint(simulation):
    """A claim of a joint that is not there names the nearest one."""
    with pytest.raises(SimulationError, match='shoulder'):
        simulation.perform_command_mode_switch({'shoulders': frozenset({'position'})})


def test_ignores_commands_of_unclaimed_joints(arm):
    """A command that nobody claimed moves nothing."""
    simulation = Simulation(arm)
    simulation.command.position[:] = 1.0
    run(simulation, 100)
    np.testing.assert_allclose(simulation.state.position, 0.0, atol=1e-9)


def test_nan_leaves_a_joint_where_it_is(simulation):
    """NaN in a claimed position is no command."""
    simulation.command.position[:] = (0.2, np.nan, 0.2)
    run(simulation, 500)
    np.testing.assert_allclose(simulation.state.position, (0.2, 0.0, 0.2), atol=1e-4)


def test_holds_the_last_command_when_released(simulation):
    """C7: after a controller has left, the joints stay at its last command."""
    simulation.command.position[:] = 0.2
    run(simulation, 5)
    simulation.perform_command_mode_switch({})
    np.testing.assert_allclose(simulation.command.position, 0.2)
    run(simulation, 600)
    np.testing.assert_allclose(simulation.state.position, 0.2, atol=1e-4)


def test_a_position_command_is_forgotten_once_something_else_drives(simulation, claim):
    """C3: a controller that comes back after another one finds no stale command."""
    simulation.command.position[:] = 0.2
    run(simulation, 5)
    claim(simulation, 'effort')
    simulation.perform_command_mode_switch({})
    assert np.isnan(simulation.command.position).all()


def test_a_velocity_ends_where_the_reference_is(simulation, claim):
    """Who commands positions after a velocity goes on from the drive's reference."""
    simulation.command.position[:] = 0.2
    run(simulation, 500)
    claim(simulation, 'velocity')
    assert np.isnan(simulation.command.position).all()
    simulation.command.velocity[:] = 0.5
    run(simulation, 100)
    reference = simulation.reference_positions.copy()
    assert reference.min() > 0.22
    simulation.perform_command_mode_switch({})
    np.testing.assert_allclose(simulation.command.position, reference)


def test_velocity_commands_move_at_their_velocity(simulation, claim):
    """A claimed velocity is reached and kept, against gravity too."""
    claim(simulation, 'velocity')
    simulation.command.velocity[:] = (0.5, -0.5, 0.2)
    run(simulation, 500)
    np.testing.assert_allclose(simulation.state.velocity, (0.5, -0.5, 0.2), atol=1e-3)
    simulation.command.velocity[:] = np.nan
    run(simulation, 500)
    np.testing.assert_allclose(simulation.state.velocity, 0.0, atol=1e-3)


def test_velocity_commands_are_bounded(simulation, claim):
    """O6: a velocity beyond the limit is saturated."""
    claim(simulation, 'velocity')
    simulation.command.velocity[:] = (0.0, 0.0, 50.0)
    run(simulation, 300)
    assert simulation.state.velocity[2] == pytest.approx(1.1 * 3.14, rel=1e-3)


def test_a_blocked_velocity_joint_does_not_wind_up(simulation, claim):
    """A joint that was held back resumes its velocity; it does not make up the way."""
    claim(simulation, 'velocity')
    simulation.command.velocity[:] = (0.3, 0.0, 0.0)
    simulation.apply_wrench('upper', torque=(0.0, -33.0, 0.0))
    run(simulation, 150)
    simulation.apply_wrench('upper')
    start = simulation.state.position[0]
    assert start < -0.05
    assert simulation.reference_positions[0] - start < 0.05


def test_effort_commands_are_the_torque_itself(simulation, claim):
    """K4: an effort is applied as it is; with none the arm falls."""
    claim(simulation, 'effort')
    simulation.command.effort[:] = (0.0, 0.0, 0.5)
    run(simulation, 20)
    np.testing.assert_allclose(simulation.state.effort, (0.0, 0.0, 0.5))
    assert simulation.state.velocity[2] > 0.1


def test_an_integral_does_not_act_beside_an_effort(arm, claim, integrating):
    """K4: what a joint that held without an effort wound up against a push is no part of one."""
    simulation = Simulation(arm, gains=integrating)
    claim(simulation, 'effort')
    simulation.apply_wrench('upper', torque=(0.0, 5.0, 0.0))
    run(simulation, 1000)
    simulation.apply_wrench('upper')
    simulation.command.effort[:] = (0.0, 0.0, 0.5)
    run(simulation, 5)
    np.testing.assert_allclose(simulation.state.effort, (0.0, 0.0, 0.5))


def test_efforts_are_clamped(simulation, claim):
    """O6: an effort beyond the limit is saturated."""
    claim(simulation, 'effort')
    simulation.command.effort[:] = (99.0, -99.0, 0.0)
    run(simulation, 1)
    np.testing.assert_allclose(simulation.state.effort, (30.0, -30.0, 0.0))


def test_an_effort_beside_a_position_is_added(simulation, claim):
    """K5: with position and effort claimed the effort acts on top of the drive."""
    claim(simulation, 'position', 'effort')
    simulation.command.position[:] = 0.0
    simulation.command.effort[:] = (2.0, 0.0, 0.0)
    run(simulation, 1500)
    assert simulation.state.position[0] == pytest.approx(2.0 / 1000.0, rel=0.05)


def test_a_position_takes_over_from_a_falling_joint(simulation, claim):
    """A switch from effort to position catches the joint where it is at that moment."""
    claim(simulation, 'effort')
    simulation.command.effort[:] = (1.0, 0.0, 0.0)
    run(simulation, 100)
    claim(simulation, 'position')
    caught = simulation.state.position[0]
    run(simulation, 800)
    assert simulation.state.position[0] == pytest.approx(caught, abs=0.02)


def test_a_limit_of_zero_is_no_limit(make_arm, claim):
    """Velocity and effort limits of 0 are taken as not given."""
    simulation = Simulation(make_arm(limits=JointLimits(-1, 1, velocity=0.0, effort=0.0)))
    claim(simulation, 'position')
    simulation.command.position[2] = 0.5
    run(simulation, 100)
    assert simulation.state.position[2] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(('follower', 'fingers'), [
    (None, 1.0), (JointType.REVOLUTE, 1.0), (JointType.PRISMATIC, 3.0)])
def test_a_slide_drives_itself_and_the_slides_that_follow_it(arm, follower, fingers):
    """A joint that turns has no finger, whatever follows it."""
    joints = dict(arm.joints)
    joints['elbow'] = replace(joints['elbow'], type=JointType.PRISMATIC)
    if follower is not None:
        joints['wrist'] = replace(
            joints['wrist'], type=follower, mimic=Mimic('elbow', -2.0, 0.0))
    model = replace(arm, joints=joints)
    driven = dict(zip(model.active_joints, fingers_driven(model).tolist(), strict=True))
    assert (driven['shoulder'], driven['elbow']) == (1.0, fingers)


def test_a_mimic_joint_follows(mimic_arm, claim, follow, quintic):
    """G7: a mimic joint moves by multiplier and offset, its driver keeps its accuracy."""
    simulation = Simulation(mimic_arm)
    claim(simulation, 'position')
    assert simulation.command_interfaces['wrist'] == ()
    position, _ = quintic((0.0, 0.0, 0.3), (0.8, 0.5, -0.1), 1.0)
    assert follow(simulation, position, 1.2).max() < 1e-3


def test_a_mimic_joint_has_the_range_of_its_driver(mimic_arm, claim, follow, quintic):
    """
    Its own limits stop neither joint, as only active joints are bounded.

    Upstream: robot_state.cpp, satisfiesBounds.
    """
    wrist = mimic_arm.joints['wrist']
    narrow = replace(wrist, limits=replace(wrist.limits, lower=0.2, upper=0.4))
    simulation = Simulation(replace(mimic_arm, joints={**mimic_arm.joints, 'wrist': narrow}))
    claim(simulation, 'position')
    position, _ = quintic((0.0, 0.0, 0.3), (0.8, 0.5, -0.1), 1.0)
    assert follow(simulation, position, 1.2).max() < 1e-3


def test_a_mimic_joint_cannot_be_claimed(mimic_arm):
    """G7: a claim of a mimic joint says which joint it follows."""
    with pytest.raises(SimulationError, match="follows 'shoulder'"):
        Simulation(mimic_arm).perform_command_mode_switch({'wrist': frozenset({'position'})})


def test_effort_that_is_not_given_holds(simulation, claim):
    """A joint whose effort is claimed and NaN is held against gravity, also after an effort."""
    claim(simulation, 'effort')
    start = simulation.state.position.copy()
    simulation.command.effort[:] = np.nan
    run(simulation, 300)
    np.testing.assert_allclose(simulation.state.position, start, atol=1e-3)
    simulation.command.effort[:] = 0.5
    run(simulation, 100)
    simulation.command.effort[:] = np.nan
    run(simulation, 500)
    held = simulation.state.position.copy()
    assert np.abs(held - start).max() > 0.01
    run(simulation, 300)
    np.testing.assert_allclose(simulation.state.position, held, atol=1e-3)
