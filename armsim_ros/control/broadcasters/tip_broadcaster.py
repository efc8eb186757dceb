# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The broadcasters of crisp_controllers: where a link is, and how it moves."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.compliance import (
    CrispPoseBroadcasterParameters,
    CrispTwistBroadcasterParameters,
    TipBroadcasterParameters,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.broadcasters.broadcaster import Broadcaster
from armsim_ros.control.broadcasters.sensor_broadcaster import SensorSample
from armsim_ros.model.transforms import quat_xyzw_from_matrix


class TipBroadcaster(Broadcaster[TipBroadcasterParameters, SensorSample]):
    """Samples a link from the states of the joints before it."""

    #: Which states of the joints it reads.
    kinds: ClassVar[tuple[str, ...]] = ('position',)

    @property
    def joints(self) -> tuple[str, ...]:
        """None: it commands nothing."""
        return ()

    @property
    def publish_rate(self) -> float:
        """Samples a second; infinite is each update [Hz]."""
        return self.parameters.publish_frequency or math.inf

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """States of the joints."""
        return tuple(f'{joint}/{kind}' for joint in self.parameters.joints
                     for kind in self.kinds)

    def configure(self) -> None:
        """Check that joints and links are those of the robot."""
        parameters, model = self.parameters, self.context.model
        self._arm = ArmDynamics.of_controller(self.name, model, parameters)
        self._samples.clear()

    def _move(self) -> None:
        hardware = self.context.hardware
        index = [hardware.index[name] for name in self.parameters.joints]
        self._arm.move(hardware.state.position[index], hardware.state.velocity[index])


class PoseBroadcaster(TipBroadcaster):
    """``crisp_controllers/PoseBroadcaster``: x, y, z and a quaternion x, y, z, w."""

    parameters_class: ClassVar[type[Settings]] = CrispPoseBroadcasterParameters

    def read(self, time_ns: int) -> SensorSample:
        """Return the pose in the base frame now [ns]."""
        self._move()
        pose = self._arm.pose
        return SensorSample(
            time_ns, np.concatenate((pose[:3, 3], quat_xyzw_from_matrix(pose[:3, :3]))))


class TwistBroadcaster(TipBroadcaster):
    """``crisp_controllers/TwistBroadcaster``: linear and angular velocity in the link's axes."""

    parameters_class: ClassVar[type[Settings]] = CrispTwistBroadcasterParameters
    kinds: ClassVar[tuple[str, ...]] = ('position', 'velocity')

    def read(self, time_ns: int) -> SensorSample:
        """Return the velocities now [ns]."""
        self._move()
        hardware, turn = self.context.hardware, self._arm.pose[:3, :3].T
        velocities = hardware.state.velocity[
            [hardware.index[name] for name in self.parameters.joints]]
        twist = self._arm.jacobian() @ velocities
        return SensorSample(time_ns, np.concatenate((turn @ twist[:3], turn @ twist[3:])))
