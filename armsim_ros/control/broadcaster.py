# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Broadcasters sample states at a rate of simulated time for others to publish.

The control loop's thread samples; a single thread takes the samples, in order, with ``poll``.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
import math
from typing import ClassVar, Generic, TypeVar

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.broadcasters import (
    BroadcasterParameters,
    ForceTorqueSensorBroadcasterParameters,
    IMUSensorBroadcasterParameters,
    PoseBroadcasterParameters,
    SpeedScalingStateBroadcasterParameters,
    StateInterfacesBroadcasterParameters,
)
from armsim_ros.config.controllers.compliance import (
    CrispPoseBroadcasterParameters,
    CrispTwistBroadcasterParameters,
    TipBroadcasterParameters,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.controller import Controller, NEVER_NS, ParametersT, Rate
from armsim_ros.errors import ControllerError
from armsim_ros.model.transforms import quat_xyzw_from_matrix

SampleT = TypeVar('SampleT')

CAPACITY = 256
"""So many samples wait for their reader; then the oldest are dropped."""


CALM_RATE = 100.0
"""So many samples a second of hardware at rest are enough for calm listeners [Hz]."""


class Broadcaster(Controller[ParametersT], Generic[ParametersT, SampleT]):
    """Commands nothing, and takes a sample whenever a sample is due."""

    only_reads: ClassVar[bool] = True

    def on_init(self) -> None:
        """Begin without samples."""
        self._listener: Callable[[], object] | None = None
        self._samples: deque[SampleT] = deque(maxlen=CAPACITY)
        self._rate = self._calm_rate = Rate(0.0)
        self._calm = False
        self._last_due_ns = -1

    @property
    @abstractmethod
    def publish_rate(self) -> float:
        """Samples a second; infinite is each update, 0 is none [Hz]."""

    @abstractmethod
    def read(self, time_ns: int) -> SampleT:
        """Return a sample of now [ns]."""

    def activate(self, time_ns: int) -> None:
        """Begin a new rhythm: that of everything else with this rate."""
        rate = self.publish_rate
        self._rate = Rate(rate, aligned=True)
        self._calm_rate = Rate(min(rate, CALM_RATE), aligned=True)
        self._last_due_ns = -1

    def deactivate(self, time_ns: int) -> None:
        """Sample no more; what was sampled can still be taken."""
        self.time_ns = time_ns

    def update(self, time_ns: int, period: float) -> None:
        """Take a sample if it is due."""
        if self._rate_of_now.due(time_ns) and time_ns != self._last_due_ns:
            self._last_due_ns = time_ns
            self.sample(time_ns)

    def sample(self, time_ns: int) -> None:
        """Take a sample now [ns]; only in the control loop's thread."""
        self.time_ns = time_ns
        self._samples.append(self.read(time_ns))
        if self._listener is not None:
            self._listener()

    @property
    def calm(self) -> bool:
        """Whether hardware at rest is sampled at ``CALM_RATE`` at most; from any thread."""
        return self._calm

    @calm.setter
    def calm(self, calm: bool) -> None:
        if calm is not self._calm:
            self._calm = calm
            self.context.wake()

    @property
    def _rate_of_now(self) -> Rate:
        return self._calm_rate if self._calm and self.context.hardware.resting else self._rate

    def listen(self, listener: Callable[[], object] | None) -> None:
        """
        Have a function called, in the control loop's thread, when there is a sample.

        Without a listener no update is made for a sample; those that are made take it.
        """
        self._listener = listener
        self.context.wake()

    def next_update(self, time_ns: int) -> int:
        """Return when the next sample is due for the listener [ns]."""
        due_ns = self._rate_of_now.next_due_ns(time_ns) if self._listener is not None else None
        return NEVER_NS if due_ns is None else due_ns

    def poll(self) -> SampleT | None:
        """Return the oldest sample that was not taken, or None."""
        try:
            return self._samples.popleft()
        except IndexError:
            return None


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
        return self.parameters.states

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
        values = self.context.hardware.read_states(self.interfaces)
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
            self.events.warn(
                self.time_ns, 'sensor_filter_chain has no effect: wrench_filtered is wrench')

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
        self.context.hardware.given_states.setdefault(self.parameters.states[0], 1.0)

    def _shown(self, values: Vector) -> Vector:
        return 100.0 * values


class StateInterfacesBroadcaster(SensorBroadcaster):
    """``state_interfaces_broadcaster/StateInterfacesBroadcaster``."""

    parameters_class: ClassVar[type[Settings]] = StateInterfacesBroadcasterParameters


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
