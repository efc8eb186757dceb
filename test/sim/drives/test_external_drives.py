# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints of mock components and of vendors' drivers, whose URDFs often have placeholders."""

from dataclasses import replace

import numpy as np
import pytest

from armsim_ros.config.simulation import JointServoSettings, SimulationSettings
from armsim_ros.model.robot_model import HardwareJoint, HardwareSystem, JointLimits
from armsim_ros.sim.simulation import Simulation

MOCK, VENDOR = 'mock_components/GenericSystem', 'franka_hardware/FrankaHardwareInterface'
CLASSIC = 'gazebo_ros2_control/GazeboSystem'
SIMULATORS = ('gz_ros2_control/GazeboSimSystem', 'ign_ros2_control/IgnitionSystem',
              'mujoco_ros2_control/MujocoSystem')


@pytest.fixture
def driven(arm):
    """Return a function that gives the arm a hardware plugin and one effort limit."""
    def make(plugin, effort=30.0):
        joints = {name: replace(joint, limits=JointLimits(-2.8, 2.8, velocity=3.14, effort=effort))
                  for name, joint in arm.joints.items()}
        hardware = HardwareSystem('hw', 'system', plugin, tuple(
            HardwareJoint(name, ('position', 'effort'), ('position', 'velocity'))
            for name in joints))
        return replace(arm, joints=joints, hardware=(hardware,))

    return make


def run(simulation, seconds):
    """Step with the present commands; return how far the joints moved from where they were."""
    before = simulation.state.position.copy()
    for _ in range(round(seconds / simulation.settings.timestep)):
        simulation.write()
        simulation.step()
    return np.abs(simulation.state.position - before).max()


@pytest.mark.parametrize('plugin', [MOCK, VENDOR, CLASSIC])
def test_a_placeholder_effort_holds_the_robot(driven, claim, plugin):
    """
    A drive holds and moves the robot though the URDF's effort limit is a placeholder.

    So does Gazebo Classic, which sets positions (gazebo_system.cpp: write).
    """
    simulation = Simulation(driven(plugin, effort=0.01))
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 0.3, -0.4)
    run(simulation, 2.0)
    np.testing.assert_allclose(simulation.state.position, (1.2, 0.3, -0.4), atol=1e-3)


def test_friction_above_the_effort_limit_does_not_stop_a_joint(driven, claim):
    """Hardware that follows positions does so whatever dry friction the URDF gives a joint."""
    arm = driven(MOCK)
    model = replace(arm, joints={name: replace(joint, friction=100.0)
                                 for name, joint in arm.joints.items()})
    simulation = Simulation(model)
    assert "joint 'elbow': the URDF's effort limit 30 cannot move the robot, whose weight and "\
           'friction need' in '\n'.join(simulation.warnings)
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 0.3, -0.4)
    run(simulation, 2.0)
    np.testing.assert_allclose(simulation.state.position, (1.2, 0.3, -0.4), atol=1e-3)


@pytest.fixture
def turned():
    """Return a function that has the arm's first joint turn about a vertical axis."""
    def make(model, effort):
        shoulder = model.joints['shoulder']
        limits = replace(shoulder.limits, effort=effort)
        return replace(model, joints={**model.joints, 'shoulder': replace(
            shoulder, axis=np.array((0.0, 0.0, 1.0)), limits=limits)})

    return make


def test_a_placeholder_effort_moves_a_joint_without_weight(driven, turned, claim):
    """A joint about a vertical axis, which bears no weight, arrives with mock hardware."""
    simulation = Simulation(turned(driven(MOCK), effort=0.01))
    assert "joint 'shoulder': the URDF's effort limit 0.01 cannot move the robot, whose weight "\
           'and acceleration need' in '\n'.join(simulation.warnings)
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 1.5, -0.4)
    run(simulation, 1.0)
    np.testing.assert_allclose(simulation.state.position, (1.2, 1.5, -0.4), atol=1e-3)
    assert run(simulation, 1.0) < 1e-3


def test_a_placeholder_effort_is_reported(driven):
    """One line a joint names the joint, the declared limit and the drive's."""
    lines = [line for line in Simulation(driven(MOCK, effort=0.01)).warnings if 'effort' in line]
    assert [line.split("'")[1] for line in lines] == ['shoulder', 'elbow', 'wrist']
    assert all('effort limit 0.01 cannot hold the robot' in line for line in lines)


@pytest.mark.parametrize('plugin', SIMULATORS)
def test_a_simulators_effort_limit_counts(driven, claim, plugin):
    """A simulator's plugin reads the effort limit, so an arm that is too weak sags there."""
    simulation = Simulation(driven(plugin, effort=0.01))
    assert not [line for line in simulation.warnings if 'effort' in line]
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 0.3, -0.4)
    run(simulation, 2.0)
    assert np.abs(simulation.state.position - (1.2, 0.3, -0.4)).max() > 0.1


def test_sufficient_effort_limits_stay(driven):
    """An effort limit that holds the robot is the drive's, also with a vendor's hardware."""
    simulation = Simulation(driven(VENDOR))
    assert not [line for line in simulation.warnings if 'effort' in line]
    assert {joint.limits.effort for joint in simulation.model.joints.values()} == {30.0}


def test_a_vendors_effort_interface_compensates_gravity(driven, claim):
    """With a vendor's hardware, zero effort leaves a tilted arm where it is."""
    simulation = Simulation(driven(VENDOR))
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 0.3, -0.4)
    run(simulation, 2.0)
    claim(simulation, 'effort')
    simulation.command.effort[:] = 0.0
    assert run(simulation, 1.0) < 1e-3


@pytest.mark.parametrize('plugin', [SIMULATORS[0], CLASSIC])
def test_a_simulators_effort_interface_is_the_torque_itself(driven, claim, plugin):
    """With a simulator's plugin, zero effort lets a tilted arm fall."""
    simulation = Simulation(driven(plugin))
    claim(simulation, 'position')
    simulation.command.position[:] = (1.2, 0.3, -0.4)
    run(simulation, 2.0)
    claim(simulation, 'effort')
    simulation.command.effort[:] = 0.0
    assert run(simulation, 1.0) > 0.1


def test_a_heavy_arm_does_not_fall(arm, claim):
    """With default gains, an arm of 900 kg comes back to its pose after a saturated step."""
    heavy = replace(arm, links={name: link if link.inertial is None else replace(
        link, inertial=replace(link.inertial, mass=1000.0 * link.inertial.mass,
                               inertia=1000.0 * link.inertial.inertia))
        for name, link in arm.links.items()}, joints={
            name: replace(joint, limits=replace(joint.limits, effort=9000.0))
            for name, joint in arm.joints.items()})
    simulation = Simulation(heavy)
    claim(simulation, 'position')
    simulation.command.position[:] = (0.3, 0.3, -0.4)
    run(simulation, 4.0)
    np.testing.assert_allclose(simulation.state.position, (0.3, 0.3, -0.4), atol=1e-3)


def with_loose_wrist(model):
    """Return a robot whose wrist has states, but no command interface."""
    (system,) = model.hardware
    joints = tuple(replace(joint, commands=()) if joint.name == 'wrist' else joint
                   for joint in system.joints)
    return replace(model, hardware=(replace(system, joints=joints),))


@pytest.mark.parametrize('plugin', SIMULATORS)
@pytest.mark.parametrize('gravity_compensation', [None, True])
def test_a_simulated_joint_without_a_command_swings_freely(driven, plugin, gravity_compensation):
    """It falls like a rod, as is_actuated has it in gz_system.cpp (initSim, write)."""
    servo = JointServoSettings(gravity_compensation=gravity_compensation)
    settings = SimulationSettings(servo=servo, initial_positions={'wrist': np.pi / 2})
    simulation = Simulation(with_loose_wrist(driven(plugin)), settings)
    simulation.perform_command_mode_switch(
        {name: frozenset({'position'}) for name in ('shoulder', 'elbow')})
    simulation.command.position[:2] = 0.0
    run(simulation, 0.02)
    length, mass = 0.2, 0.3
    inertia = mass * length**2 / 3.0 + settings.armature
    fall = -settings.gravity[2] * mass * 0.5 * length / inertia
    assert simulation.state.velocity[2] == pytest.approx(0.02 * fall, rel=0.01)
    assert simulation.state.effort[2] == 0.0
    np.testing.assert_allclose(simulation.state.position[:2], 0.0, atol=2e-4)


def test_a_reset_leaves_a_joint_without_a_command_free(driven):
    """It falls again from where it started, also without any command."""
    settings = SimulationSettings(initial_positions={'wrist': np.pi / 2})
    simulation = Simulation(with_loose_wrist(driven(SIMULATORS[0])), settings)
    first = run(simulation, 0.1)
    simulation.reset()
    assert run(simulation, 0.1) == first > 0.01


def test_a_mock_joint_without_a_command_stays(driven):
    """Mock components leave the state of such a joint at its initial value."""
    settings = SimulationSettings(initial_positions={'wrist': np.pi / 2})
    assert run(Simulation(with_loose_wrist(driven(MOCK)), settings), 0.1) < 1e-6


def test_a_joint_that_no_tag_names_stays(driven):
    """Grippers and mounts that ``<ros2_control>`` leaves out do not hang."""
    model = driven(SIMULATORS[0])
    (system,) = model.hardware
    model = replace(model, hardware=(replace(system, joints=system.joints[:2]),))
    settings = SimulationSettings(initial_positions={'wrist': np.pi / 2})
    assert run(Simulation(model, settings), 0.1) < 1e-6
