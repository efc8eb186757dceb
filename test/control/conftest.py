# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints without physics, a manager and invented time for the tests of controllers."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.errors import SimulationError
from armsim_ros.model.robot_model import Joint, JointLimits, JointType, RobotModel
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'
PERIOD_NS = 10_000_000
START_NS = 5_000_000_000


class KinematicHardware(HardwareInterface):
    """
    Joints that integrate their commands.

    A position command is reached after one period, or approached by ``gain`` of the rest; a
    velocity command is integrated; an effort command is the acceleration of a unit mass.

    :param mimics: joints that cannot be commanded.
    """

    def __init__(
        self, joints: tuple[str, ...] = ('a', 'b'), mimics: tuple[str, ...] = (), gain: float = 1.0
    ) -> None:
        super().__init__(joints)
        self.mimics = mimics
        self.gain = gain
        self.frozen = False
        self.claimed: Mapping[str, frozenset[str]] = {}
        self.refuse = ''
        self.state.acceleration[:] = 0.0

    @property
    def command_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        kinds = ('position', 'velocity', 'acceleration', 'effort')
        return {name: kinds for name in self.joint_names if name not in self.mimics}

    @property
    def state_interfaces(self) -> Mapping[str, tuple[str, ...]]:
        kinds = ('position', 'velocity', 'acceleration', 'effort')
        return dict.fromkeys(self.joint_names, kinds)

    def perform_command_mode_switch(self, claimed: Mapping[str, frozenset[str]]) -> None:
        if self.refuse:
            raise SimulationError(self.refuse)
        self.claimed = dict(claimed)

    def step(self, period: float) -> None:
        """Move by one period."""
        if self.frozen:
            self.state.velocity[:] = 0.0
            return
        for i, name in enumerate(self.joint_names):
            kinds = self.claimed.get(name, frozenset())
            before = self.state.position[i]
            if 'position' in kinds and not np.isnan(self.command.position[i]):
                self.state.position[i] += self.gain * (self.command.position[i] - before)
            elif 'velocity' in kinds and not np.isnan(self.command.velocity[i]):
                self.state.position[i] += period * self.command.velocity[i]
            elif 'effort' in kinds and not np.isnan(self.command.effort[i]):
                speed = self.state.velocity[i] + period * self.command.effort[i]
                self.state.position[i] += period * speed
            velocity = (self.state.position[i] - before) / period
            self.state.acceleration[i] = (velocity - self.state.velocity[i]) / period
            self.state.velocity[i] = velocity


def robot(joints: dict[str, JointType], velocity: float = 3.0) -> RobotModel:
    """Return a chain of joints with limits of 10 rad and a velocity limit."""
    limits = JointLimits(-10.0, 10.0, velocity, effort=50.0)
    return RobotModel(
        'rig',
        {},
        {
            name: Joint(name, kind, 'base', name, np.eye(4), np.array([0.0, 0.0, 1.0]), limits)
            for name, kind in joints.items()
        },
        'base',
    )


def trajectory(
    *points: tuple[Any, ...], joints: tuple[str, ...] = ('a', 'b'), stamp_ns: int = 0
) -> JointTrajectory:
    """Return a trajectory of points (time, positions, velocities, accelerations, effort)."""
    return JointTrajectory.of_points(
        joints, [p[0] for p in points], [TrajectoryPoint(*p[1:]) for p in points], stamp_ns)


class Rig:
    """One robot with its controllers, stepped at 100 Hz."""

    def __init__(
        self,
        joints: dict[str, JointType] | None = None,
        *,
        gain: float = 1.0,
        mimics: tuple[str, ...] = (),
        velocity: float = 3.0,
        **parameters: Any,
    ) -> None:
        types = joints or {'a': JointType.REVOLUTE, 'b': JointType.REVOLUTE}
        self.hardware = KinematicHardware(tuple(types), mimics, gain)
        self.manager = ControllerManager(
            self.hardware, ControllerManagerParameters(**parameters), robot(types, velocity)
        )
        self.now_ns = START_NS
        self.manager.time_ns = START_NS

    def load(self, name: str, type: str, **parameters: Any) -> Any:  # noqa: A002
        """Load and configure a controller."""
        controller = self.manager.load(
            SimpleNamespace(name=name, type=type, parameters=parameters)
        )
        self.manager.configure(name)
        return controller

    def arm(self, name: str = 'arm', **parameters: Any) -> JointTrajectoryController:
        """Load, configure and activate a trajectory controller for all joints."""
        joints = [n for n in self.hardware.joint_names if n not in self.hardware.mimics]
        controller = self.load(name, TRAJECTORY, **{'joints': joints, **parameters})
        result = self.manager.switch(activate=[name])
        assert result.ok, result.message
        self.step()
        return controller

    def step(self, count: int = 1) -> None:
        """Run so many updates and let the joints move."""
        for _ in range(count):
            self.manager.update(self.now_ns, PERIOD_NS * 1e-9)
            self.hardware.step(PERIOD_NS * 1e-9)
            self.now_ns += PERIOD_NS

    def run(self, seconds: float) -> None:
        """Run for so long."""
        self.step(round(seconds * 1e9 / PERIOD_NS))

    def texts(self) -> list[str]:
        """Return the texts of all events since the last call."""
        return [event.text for event in self.manager.poll_events()]


@pytest.fixture(scope='session', name='rig')
def _rig():
    """Return the class of rigs."""
    return Rig


@pytest.fixture(scope='session', name='trajectory')
def _trajectory():
    """Return the function that makes trajectories."""
    return trajectory


@pytest.fixture(scope='session', name='hardware_class')
def _hardware_class():
    """Return the class of joints without physics."""
    return KinematicHardware


@pytest.fixture(scope='session', name='robot')
def _robot():
    """Return the function that makes robot models."""
    return robot
