# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small robots for the tests of the physics."""

import numpy as np
import pytest

from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.model.geometry import Box, Cylinder
from armsim_ros.model.robot_model import (
    Inertial,
    Joint,
    JointLimits,
    JointType,
    Link,
    LinkGeometry,
    Mimic,
    RobotModel,
)
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.simulation import Simulation

LENGTH = 0.2


def arm_link(name, mass=0.3):
    """Return a rod along z with a box as its shape."""
    inertia = mass * LENGTH**2 / 12.0
    return Link(
        name,
        Inertial(mass, pose_matrix((0, 0, 0.5 * LENGTH)), np.diag([inertia, inertia, 1e-4])),
        collisions=(LinkGeometry(Cylinder(0.02, 0.16), pose_matrix((0, 0, 0.5 * LENGTH))),),
    )


def revolute(name, parent, child, axis, **changes):
    """Return a joint at the end of its parent."""
    origin = pose_matrix((0, 0, 0.1 if parent == 'base' else LENGTH))
    values = {
        'type': JointType.REVOLUTE,
        'limits': JointLimits(-2.8, 2.8, velocity=3.14, effort=30.0),
        **changes,
    }
    return Joint(name, values.pop('type'), parent, child, origin, np.array(axis, float), **values)


def serial_arm(joints):
    """Return a robot on a pedestal whose joints follow each other."""
    links = {'base': Link('base', collisions=(LinkGeometry(Box((0.1, 0.1, 0.1)), np.eye(4)),))}
    links.update({joint.child: arm_link(joint.child) for joint in joints})
    return RobotModel('tiny', links, {joint.name: joint for joint in joints}, 'base',
                      srdf='<robot name="tiny"/>')


@pytest.fixture
def make_arm():
    """Return a function that makes the three-joint arm, its wrist joint changed."""

    def make(**wrist):
        return serial_arm(
            [
                revolute('shoulder', 'base', 'upper', (0, 1, 0)),
                revolute('elbow', 'upper', 'lower', (1, 0, 0)),
                revolute('wrist', 'lower', 'hand', (0, 1, 0), **wrist),
            ]
        )

    return make


@pytest.fixture
def arm(make_arm):
    """Return an arm of three joints about y, x, y."""
    return make_arm()


@pytest.fixture
def integrating(arm):
    """Return gains of the arm's joints with integral action."""
    usual = SimulationSettings().servo.default_gains.model_dump()
    gains = PidGains(**{**usual, 'i': 5000.0, 'i_clamp_min': -20.0, 'i_clamp_max': 20.0})
    return dict.fromkeys(arm.active_joints, gains)


@pytest.fixture
def mimic_arm(make_arm):
    """Return an arm whose wrist moves half as far as its shoulder, the other way, from 0.3."""
    return make_arm(mimic=Mimic('shoulder', -0.5, 0.3))


@pytest.fixture
def settings():
    """Return default settings."""
    return SimulationSettings()


@pytest.fixture
def simulation(arm, settings):
    """Return the three-joint arm in empty space, all joints claimed by position."""
    simulation = Simulation(arm, settings, WorldSettings(floor=False))
    _claim(simulation, 'position')
    return simulation


@pytest.fixture
def claim():
    """Return a function that claims interfaces of all driven joints."""
    return _claim


@pytest.fixture
def follow():
    """Return a function that commands positions and gives the largest errors against them."""
    return _follow


@pytest.fixture
def quintic():
    """Return a function that gives position and velocity of a quintic from rest to rest."""
    return _quintic


def _claim(simulation, *interfaces):
    """Claim interfaces of all driven joints."""
    simulation.perform_command_mode_switch(
        {name: frozenset(interfaces) for name in simulation.model.active_joints}
    )


def _follow(simulation, position_at, duration, steps=1, velocity_at=None):
    """
    Command positions for a time; return the largest error against them (n,) [rad].

    The command of a period is the position at its end; the error is taken at each end.
    """
    period = steps * simulation.settings.timestep
    worst = np.zeros(len(simulation.joint_names))
    for k in range(round(duration / period)):
        t = (k + 1) * period
        simulation.command.position[:] = position_at(t)
        if velocity_at is not None:
            simulation.feedforward.velocity[:] = velocity_at(t)
        simulation.write(steps)
        for _ in range(steps):
            simulation.step()
        worst = np.maximum(worst, np.abs(simulation.state.position - position_at(t)))
    return worst


def _quintic(start, end, duration):
    """Return position and velocity functions of a quintic from rest to rest."""
    start, distance = np.asarray(start, float), np.asarray(end, float) - np.asarray(start, float)

    def position(t):
        s = np.clip(t / duration, 0.0, 1.0)
        return start + distance * (10 * s**3 - 15 * s**4 + 6 * s**5)

    def velocity(t):
        s = np.clip(t / duration, 0.0, 1.0)
        return distance / duration * 30 * (s**2 - 2 * s**3 + s**4)

    return position, velocity
