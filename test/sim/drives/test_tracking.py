# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How closely the drives follow."""

import numpy as np
import pytest

from armsim_ros.config.simulation import JointServoSettings, SimulationSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.sim.simulation import Simulation

GOAL = (1.0, -0.8, 1.2)


@pytest.mark.parametrize('duration', [2.0, 1.0])
def test_follows_a_free_move(simulation, follow, quintic, duration):
    """A free move is followed to a micrometre's worth of angle at the controllers' full rate."""
    position, _ = quintic(np.zeros(3), GOAL, duration)
    assert follow(simulation, position, duration + 0.2).max() < 1e-6
    np.testing.assert_allclose(simulation.state.position, GOAL, atol=1e-6)


@pytest.mark.parametrize('steps', [2, 10, 20])
def test_follows_slower_controllers_with_their_velocities(simulation, follow, quintic, steps):
    """Commands at 500, 100 and 50 Hz are interpolated: below 1 mrad where velocities come too."""
    position, velocity = quintic(np.zeros(3), GOAL, 1.0)
    worst = follow(simulation, position, 1.2, steps=steps, velocity_at=velocity)
    assert worst.max() < 1e-3


def test_follows_claimed_velocities_between_positions(simulation, claim, follow, quintic):
    """A controller that claims velocities beside positions is followed by both."""
    claim(simulation, 'position', 'velocity')
    position, velocity = quintic(np.zeros(3), GOAL, 1.0)

    def commanded(t):
        simulation.command.velocity[:] = velocity(t)
        return np.zeros(3)

    assert follow(simulation, position, 1.2, steps=20, velocity_at=commanded).max() < 1e-3


def test_follows_slower_controllers_without_velocities(simulation, follow, quintic):
    """Bare positions at 100 Hz are followed below 1 mrad at the ends of the periods."""
    position, _ = quintic(np.zeros(3), GOAL, 1.0)
    assert follow(simulation, position, 1.2, steps=10).max() < 1e-3


def test_follows_a_ramp_at_rated_velocity(simulation, follow):
    """After its corner a ramp at the rated velocity of 3.14 rad/s is followed below 1 mrad."""
    follow(simulation, lambda t: np.full(3, 3.14 * t), 0.2)
    start = 3.14 * 0.2
    worst = follow(simulation, lambda t: np.full(3, start + 3.14 * t), 0.3)
    assert worst.max() < 1e-3


def test_bounds_the_velocity_of_a_step(simulation):
    """O6: a position step moves the reference at the rated velocity plus headroom, not at once."""
    simulation.command.position[:] = 1.0
    fastest = 0.0
    for _ in range(600):
        simulation.write()
        before = simulation.reference_positions
        simulation.step()
        fastest = max(fastest, np.abs(simulation.reference_positions - before).max() / 1e-3)
    assert fastest == pytest.approx(1.1 * 3.14)
    np.testing.assert_allclose(simulation.state.position, 1.0, atol=1e-3)


def test_keeps_the_reference_within_the_position_limits(simulation):
    """O6: a command beyond the limits is followed to the limit."""
    simulation.command.position[:] = 4.0
    for _ in range(50):
        simulation.write()
    for _ in range(1500):
        simulation.step()
    np.testing.assert_allclose(simulation.reference_positions, 2.8)


def test_holds_under_gravity(arm, settings):
    """An arm that nothing claims stays where it started, in the steepest pose too."""
    tilted = settings.model_copy(update={'initial_positions': {'shoulder': 1.5}})
    simulation = Simulation(arm, tilted)
    for _ in range(1000):
        simulation.step()
    np.testing.assert_allclose(simulation.state.position, [1.5, 0, 0], atol=1e-6)


def test_without_feedforward_the_gains_alone_carry_the_arm(arm):
    """With p 1000 and no feed-forward the arm sags by its weight's torque over the gain."""
    settings = SimulationSettings(
        servo=JointServoSettings(feedforward=False), initial_positions={'shoulder': np.pi / 2}
    )
    simulation = Simulation(arm, settings)
    for _ in range(3000):
        simulation.step()
    torque = 9.8 * 0.3 * (0.1 + 0.3 + 0.5)
    assert simulation.state.position[0] - np.pi / 2 == pytest.approx(torque / 1000.0, rel=0.02)


def test_an_unknown_payload_pulls_the_arm_down(simulation):
    """A force that the model does not know moves the arm by about its torque over the gain."""
    simulation.apply_wrench('hand', force=(10.0, 0.0, 0.0))
    for _ in range(2000):
        simulation.step()
    # The hand's centre of mass is 0.5 m above the shoulder, 0.1 m above the wrist.
    assert simulation.state.position[0] == pytest.approx(5.0 / 1000.0, rel=0.1)
    assert simulation.state.position[2] == pytest.approx(1.0 / 1000.0, rel=0.2)


def test_comes_to_rest_after_a_push(simulation):
    """The damping ratio ends a push's swing within half a second, though d is only 0.1."""
    simulation.apply_wrench('hand', force=(50.0, 0.0, 0.0))
    for _ in range(200):
        simulation.step()
    assert np.abs(simulation.state.position).max() > 0.01
    simulation.apply_wrench('hand')
    for _ in range(500):
        simulation.step()
    assert np.abs(simulation.state.position).max() < 1e-4


def test_integral_action_lifts_a_payload(arm, integrating):
    """With an integral gain the sag under an unknown load goes away."""
    simulation = Simulation(arm, gains=integrating)
    simulation.apply_wrench('hand', force=(10.0, 0.0, 0.0))
    for _ in range(4000):
        simulation.step()
    assert np.abs(simulation.state.position).max() < 1e-4


@pytest.mark.parametrize('duration', [1.0, 20.0])
def test_follows_in_spite_of_much_friction(make_arm, claim, follow, quintic, duration):
    """Friction of many times the links' inertia neither drags nor pushes, however slow."""
    simulation = Simulation(make_arm(damping=1.0, friction=10.0))
    claim(simulation, 'position')
    position, _ = quintic(np.zeros(3), 0.2 * np.array(GOAL), duration)
    assert follow(simulation, position, duration + 0.2).max() < 1e-4


def test_follows_in_spite_of_dry_friction_and_damping(make_arm, claim, follow, quintic):
    """Friction and damping of the URDF are fed forward: the error stays below 1 mrad."""
    simulation = Simulation(make_arm(damping=0.5, friction=0.5))
    claim(simulation, 'position')
    position, _ = quintic(np.zeros(3), GOAL, 1.0)
    assert follow(simulation, position, 1.2).max() < 1e-3


def test_dry_friction_holds_against_a_smaller_effort(make_arm):
    """A joint without a drive of positions rests below its friction, and moves above it."""
    simulation = Simulation(make_arm(friction=2.0), world=WorldSettings(floor=False))
    simulation.perform_command_mode_switch({'wrist': frozenset({'effort'})})
    for effort in (1.5, 2.5):
        simulation.command.effort[2] = effort
        simulation.write()
        simulation.step(1000)
        assert (simulation.state.position[2] > 0.01) == (effort > 2.0)


def test_a_step_is_reached_in_spite_of_dry_friction(make_arm, claim):
    """
    A drive of positions overcomes friction also where it starts and ends at once.

    It does so again after an effort has moved the joint.
    """
    simulation = Simulation(make_arm(friction=2.0), world=WorldSettings(floor=False))
    claim(simulation, 'effort')
    simulation.step(10)
    claim(simulation, 'position')
    simulation.command.position[:] = 0.3
    simulation.write()
    simulation.step(2000)
    np.testing.assert_allclose(simulation.state.position, 0.3, atol=1e-4)
