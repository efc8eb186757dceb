# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Broadcasters of sensors, and of where a link is and how it moves (crisp_controllers)."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.broadcasters import (
    BroadcasterParameters,
    ForceTorqueSensorBroadcasterParameters,
    IMUSensorBroadcasterParameters,
    PoseBroadcasterParameters,
    SpeedScalingStateBroadcasterParameters,
)
from armsim_ros.config.controllers.compliance import (
    CrispPoseBroadcasterParameters,
    CrispTwistBroadcasterParameters,
    TipBroadcasterParameters,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.broadcasters.broadcaster import Broadcaster
from armsim_ros.errors import ControllerError
from armsim_ros.model.transforms import quat_xyzw_from_matrix


@dataclass(frozen=True, slots=True, eq=False)
class SensorSample:
    """
    What was read at a time [ns].

    :param values: a value per interface, NaN for those that have none.
    """

    time_ns: int
    values: Vector


class SensorBroadcaster(Broadcaster[BroadcasterParameters, SensorSample]):
    """Samples the states that its parameters name."""

    @property
    def publish_rate(self) -> float:
        """Samples a second; infinite is each update [Hz]."""
        return self.parameters.publish_rate or math.inf

    @property
    def interfaces(self) -> tuple[str, ...]:
        """State interface of each value of a sample, '' for those that have none."""
        return self.parameters.interfaces

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Those that the parameters name."""
        return tuple(name for name in self.interfaces if name)

    def configure(self) -> None:
        """Look whether everything is named that is needed."""
        if self.parameters.missing:
            raise ControllerError(
                f"parameter '{self.parameters.missing}' of '{self.name}' is empty")
        self._samples.clear()

    def read(self, time_ns: int) -> SensorSample:
        """Return what is published of now [ns]."""
        states = self.context.hardware.other_states
        values = np.array([states[name] if name else math.nan for name in self.interfaces])
        return SensorSample(time_ns, self._shown(values))

    def _shown(self, values: Vector) -> Vector:
        """Return what is published for what was read."""
        return values


class ForceTorqueSensorBroadcaster(SensorBroadcaster):
    """``force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster``."""

    parameters_class: ClassVar[type[Settings]] = ForceTorqueSensorBroadcasterParameters
    chainable: ClassVar[bool] = True

    def configure(self) -> None:
        """Check that everything is named, and report what has no effect; nothing is tared."""
        super().configure()
        self._zero, self._taring = np.zeros(6), False
        if self._own.sensor_filter_chain:
            self.events.add(self.time_ns, 'warning', 'warning',
                            'sensor_filter_chain has no effect: wrench_filtered is wrench')

    @property
    def _own(self) -> ForceTorqueSensorBroadcasterParameters:
        parameters = self.parameters
        assert isinstance(parameters, ForceTorqueSensorBroadcasterParameters)
        return parameters

    def _shown(self, values: Vector) -> Vector:
        offset, factor = self._own.offset, self._own.multiplier
        axes = [(kind, axis) for kind in ('force', 'torque') for axis in 'xyz']
        added = np.array([getattr(getattr(offset, kind), axis) for kind, axis in axes])
        times = np.array([getattr(getattr(factor, kind), axis) for kind, axis in axes])
        values = values + added
        if self._taring:
            self._zero, self._taring = np.nan_to_num(values), False
        return np.asarray((values - self._zero) * times)

    def tare(self) -> str:
        """
        Have the load of the next sample shown as 0, until it is configured again; from any thread.

        :returns: why not, '' where it is done.
        """
        if not self.active:
            return 'the controller is not active'
        self._taring = True
        return ''


class IMUSensorBroadcaster(SensorBroadcaster):
    """``imu_sensor_broadcaster/IMUSensorBroadcaster``."""

    parameters_class: ClassVar[type[Settings]] = IMUSensorBroadcasterParameters


class PoseBroadcaster(SensorBroadcaster):
    """``pose_broadcaster/PoseBroadcaster``."""

    parameters_class: ClassVar[type[Settings]] = PoseBroadcasterParameters


class SpeedScalingStateBroadcaster(SensorBroadcaster):
    """``ur_controllers/SpeedScalingStateBroadcaster``: the factor, in percent."""

    parameters_class: ClassVar[type[Settings]] = SpeedScalingStateBroadcasterParameters

    @property
    def publish_rate(self) -> float:
        """Samples a second [Hz]."""
        parameters = self.parameters
        assert isinstance(parameters, SpeedScalingStateBroadcasterParameters)
        return parameters.state_publish_rate

    def configure(self) -> None:
        """Have the factor, whatever the hardware declares."""
        super().configure()
        self.context.hardware.given_states.setdefault(self.parameters.interfaces[0], 1.0)

    def _shown(self, values: Vector) -> Vector:
        return 100.0 * values


class TipBroadcaster(Broadcaster[TipBroadcasterParameters, SensorSample]):
    """Samples a link from the states of the joints before it."""

    #: Which states of the joints it reads.
    kinds: ClassVar[tuple[str, ...]] = ('position',)

    @property
    def publish_rate(self) -> float:
        """Samples a second; infinite is each update [Hz]."""
        return self.parameters.publish_frequency or math.inf

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """States of the joints."""
        return tuple(f'{joint}/{kind}' for joint in self.parameters.joints for kind in self.kinds)

    def configure(self) -> None:
        """Check that joints and links are those of the robot."""
        parameters, model = self.parameters, self.context.model
        self._arm = ArmDynamics.of_controller(self.name, model, parameters)
        self._samples.clear()

    def _move(self) -> None:
        hardware = self.context.hardware
        index = [hardware.index[name] for name in self.parameters.joints]
        self._arm.move(hardware.state.position[index], hardware.state.velocity[index])


class CrispPoseBroadcaster(TipBroadcaster):
    """``crisp_controllers/PoseBroadcaster``: x, y, z and a quaternion x, y, z, w."""

    parameters_class: ClassVar[type[Settings]] = CrispPoseBroadcasterParameters

    def read(self, time_ns: int) -> SensorSample:
        """Return the pose in the base frame now [ns]."""
        self._move()
        pose = self._arm.pose
        return SensorSample(
            time_ns, np.concatenate((pose[:3, 3], quat_xyzw_from_matrix(pose[:3, :3]))))


class CrispTwistBroadcaster(TipBroadcaster):
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
