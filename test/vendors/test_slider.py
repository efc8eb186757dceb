# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
An arm whose motions have the pace of a speed slider, pause, and may be those of a script.

As ur_robot_driver: ``hardware_interface.cpp`` (read: speed_scaling_combined, PausingState) and
``scaled_joint_trajectory_controller``.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from ur_arm import ARM, JOINTS, PACE, positions, SCALED, swing

from armsim_ros.control.mailbox import GoalStatus


def path(sim, controller):
    """Return how long a motion takes [s], and where the joints were in each of its steps."""
    goal, start, found = swing(sim, controller), sim.time, []
    while not goal.done:
        sim.step()
        found.append(positions(sim))
    assert goal.status is GoalStatus.SUCCEEDED, goal.result
    return sim.time - start, np.array(found)


def farthest(found, wanted):
    """Return how far a path is from the nearest points of another [rad]."""
    return max(np.abs(wanted - point).max(axis=1).min() for point in found)


def test_half_the_slider_takes_twice_the_time_on_the_same_path(sim):
    """HW-C3: The scaled controller's time goes at the pace of the slider; another ignores it."""
    assert sim.manager.switch([SCALED], [ARM]).ok
    sim.step(20)
    full, wanted = path(sim, SCALED)
    assert sim.manager.arm.set_slider(0.5) == ''
    half, found = path(sim, SCALED)
    assert half / full == pytest.approx(2.0, abs=0.02)
    assert farthest(found[::10], wanted) < 1e-3
    assert sim.manager.switch([ARM], [SCALED]).ok
    sim.step(20)
    assert path(sim, ARM)[0] == pytest.approx(full, abs=0.02)


def test_the_passthrough_controller_moves_the_arm_at_its_pace(sim):
    """
    HW-C3: A client's trajectory takes twice the time at half the slider; both cannot be active.

    As ``passthrough_trajectory_controller.cpp`` of ur_controllers (update).
    """
    sim.manager.load(SimpleNamespace(
        name='passthrough', type='ur_controllers/PassthroughTrajectoryController', parameters={
            'tf_prefix': '', 'joints': JOINTS, 'state_interfaces': ['position', 'velocity'],
            'speed_scaling_interface_name': PACE}))
    sim.manager.configure('passthrough')
    assert not sim.manager.switch(['passthrough']).ok
    assert sim.manager.switch(['passthrough'], [ARM]).ok
    assert sim.manager.arm.set_slider(0.5) == ''
    sim.step(20)
    begin, goal = sim.time, swing(sim, 'passthrough')
    sim.run_until(lambda: goal.done)
    assert goal.status is GoalStatus.SUCCEEDED
    assert sim.time - begin == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize('fraction', [0.0, 0.009, 1.01, float('nan')])
def test_a_slider_outside_of_its_range_is_refused(sim, fraction):
    """HW-C3: A refused fraction names the range and changes nothing."""
    assert '0.01 to 1.0' in sim.manager.arm.set_slider(fraction)
    assert sim.manager.hardware.given_states[PACE] == 1.0


def test_a_pause_lets_the_goal_wait(sim):
    """
    A pause stops the trajectory on its path at once; play lets it go on within a second.

    HW-C4.
    """
    assert sim.manager.switch([SCALED], [ARM]).ok
    sim.step(20)
    _, wanted = path(sim, SCALED)
    goal = swing(sim, SCALED)
    sim.run_until(sim.time + 0.5)
    assert sim.manager.arm.pause() == ''
    sim.run_until(sim.time + 0.5)
    rest = positions(sim)
    sim.run_until(sim.time + 2.0)
    assert not goal.done
    assert np.abs(positions(sim) - rest).max() < 1e-3
    assert sim.manager.hardware.given_states[PACE] == 0.0
    assert sim.manager.arm.play() == ''
    sim.run_until(sim.time + 1.0)
    assert sim.manager.hardware.given_states[PACE] == 1.0
    sim.run_until(lambda: goal.done)
    assert goal.status is GoalStatus.SUCCEEDED
    assert farthest([rest], wanted) < 0.02


def test_a_stop_ends_a_motion_of_a_script(sim):
    """
    A script moves the arm without its controllers; a stop brakes that motion, too.

    HW-C8, HW-B3.
    """
    arm, start = sim.manager.arm, positions(sim)
    arm.stop_program()
    sim.step(20)
    sim.manager.stops.move(list(start + 0.5), 1.0, 1.4)
    sim.run_until(sim.time + 0.6)
    moved = positions(sim)
    sim.protective_stop()
    sim.run_until(sim.time + 0.5)
    rest = positions(sim)
    sim.run_until(sim.time + 1.0)
    assert np.abs(positions(sim) - rest).max() < 1e-3
    assert (rest - moved).min() > 1e-3
    assert (start + 0.5 - rest).min() > 0.05
    sim.run_until(sim.time + 4.0)
    sim.clear_stop()
    sim.step(20)
    sim.manager.stops.move(list(start), 1.0, 1.4)
    sim.run_until(lambda: sim.manager.stops.at_rest)
    sim.run_until(sim.time + 0.1)
    assert np.abs(positions(sim) - start).max() < 1e-3


def test_a_motion_of_a_script_is_fed_forward(sim):
    """Velocity and acceleration that the drives get are those of the commanded positions."""
    hardware = sim.manager.hardware
    period = 1.0 / sim.settings.controller_manager.update_rate
    sim.manager.arm.stop_program()
    sim.step(20)
    sim.manager.stops.move(list(positions(sim) + 0.5), 1.0, 1.4)
    rows = []
    while not sim.manager.stops.at_rest:
        sim.run_until(sim.time + period)
        rows.append((hardware.command.position.copy(), hardware.feedforward.velocity.copy(),
                     hardware.feedforward.acceleration.copy()))
    position, velocity, acceleration = map(np.array, zip(*rows, strict=True))
    np.testing.assert_allclose(np.gradient(position, period, axis=0)[1:-1], velocity[1:-1],
                               atol=1e-3)
    np.testing.assert_allclose(np.gradient(velocity, period, axis=0)[1:-1], acceleration[1:-1],
                               atol=0.02)
