# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The admittance controller: references pass, but for how far the arm yields to forces.

``receive`` and ``snapshot`` may be called from any thread; all else belongs to the control loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.command_controllers import (
    AdmittanceControllerParameters,
    AdmittanceSettings,
)
from armsim_ros.control.command_controllers.admittance_rule import (
    AdmittanceRule,
    damping_of,
    LinkMotion,
)
from armsim_ros.control.command_controllers.chainable_controller import ChainableController
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.controller import LifecycleState
from armsim_ros.control.hardware_interface import ACCELERATION, JointProperties, POSITION, VELOCITY
from armsim_ros.errors import ControllerError


@dataclass(frozen=True, slots=True, eq=False)
class AdmittanceSnapshot:
    """
    What the controller did in an update [ns]; arrays as in :class:`AdmittanceRule`.

    :param damping: (6,) of the control frame's axes [N*s/m, N*m*s/rad].
    """

    time_ns: int
    parameters: AdmittanceControllerParameters
    admittance: AdmittanceSettings
    damping: Vector
    control_rotation: Matrix
    sensor_at_reference: Matrix
    wrench: Vector
    yielded: Vector
    twist: Vector
    twist_rate: Vector
    offset: Vector
    velocity: Vector
    acceleration: Vector


class AdmittanceController(ChainableController[AdmittanceControllerParameters]):
    """``admittance_controller/AdmittanceController``."""

    parameters_class: ClassVar[type[Settings]] = AdmittanceControllerParameters

    _rule: AdmittanceRule | None = None
    _snapshot: AdmittanceSnapshot | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The controlled joints."""
        return self.parameters.joints

    @property
    def references(self) -> tuple[tuple[str, str], ...]:
        """Each exported interface of each joint, interface by interface."""
        kinds = self.parameters.chainable_command_interfaces
        return tuple((joint, kind) for kind in kinds for joint in self.joints)

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Every command interface of every joint, interface by interface."""
        return tuple('/'.join(target) for target in self._targets)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """States of the joints, and what the sensor measures."""
        kinds = self.parameters.state_interfaces
        of_joints = tuple(f'{joint}/{kind}' for kind in kinds for joint in self.joints)
        return (*of_joints, *self._measured)

    def configure(self) -> None:
        """Check that everything is named that is needed, and that the robot has it."""
        self._motion(self.parameters)
        self._limits = JointProperties.of(self.joints, self.context.model)

    def check_parameters(self, parameters: AdmittanceControllerParameters) -> None:
        """Refuse, once configured, parameters with which it could not be configured."""
        if self.state is not LifecycleState.UNCONFIGURED:
            self._motion(parameters)

    def begin(self, time_ns: int) -> Vector:
        """Take the joints over where they are commanded, else where they are."""
        context, count = self.context, len(self.joints)
        hardware = context.hardware
        self._settled = self.parameters
        self._output = CommandTargets(self._targets, hardware)
        self._output.take_over()
        index = [hardware.index[name] for name in self.joints]
        standing, measured = hardware.command.position[index], hardware.state.position[index]
        self._held: Vector = np.where(np.isfinite(standing), standing, measured)
        self._snapshot = None
        self._added_wrench: Vector = np.zeros(6)
        self._rule = AdmittanceRule(
            self._motion(self._settled), self._limits.lower, self._limits.upper)
        kinds = self.parameters.chainable_command_interfaces
        rows = [self._held if kind == POSITION else np.zeros(count) for kind in kinds]
        return np.concatenate([np.empty(0), *rows])

    def deactivate(self, time_ns: int) -> None:
        """Stop velocities; positions stay."""
        self._output.stop()
        self._rule = None

    def receive(self, positions: Sequence[float], velocities: Sequence[float]) -> str:
        """
        Take references from the topic; those of interfaces that are not exported are ignored.

        :param positions: a value per joint, NaN where it stays, or empty [rad or m].
        :param velocities: likewise [rad/s or m/s].
        :returns: why they were dropped, '' where they were taken.
        """
        count, kinds = len(self.joints), self.parameters.chainable_command_interfaces
        found = np.full((len(kinds), count), np.nan)
        for kind, values in ((POSITION, positions), (VELOCITY, velocities)):
            if len(values) == 0 or kind not in kinds:
                continue
            if len(values) != count or np.isinf(values).any():
                return self.drop(f'{kind} {list(values)}; expected one finite value or NaN for '
                                 f'each of {", ".join(self.joints)}')
            found[kinds.index(kind)] = values
        if np.isnan(found).all():
            return self.drop(f'no value for {" or ".join(kinds)}')
        return self.offer(np.asarray(found.ravel()))

    def receive_wrench(self, frame: str, wrench: Sequence[float]) -> str:
        """
        Add a wrench to what the sensor measures, until the next wrench or deactivation.

        :param frame: that of the sensor, or ''.
        :param wrench: (6,) force and torque [N, N*m].
        :returns: why it was dropped, '' where it was taken.
        """
        sensor = self.parameters.ft_sensor.frame.id
        if frame not in ('', sensor):
            return self.drop(f"wrench in frame '{frame}'; expected '{sensor}'")
        if not np.isfinite(wrench).all():
            return self.drop(f'wrench {list(wrench)}; expected finite numbers')
        if self.active:
            self._added_wrench = np.array(wrench, dtype=np.float64)
        return ''

    def follow(self, references: Vector, time_ns: int, period: float) -> None:
        """Yield to what is measured, and command the references with it."""
        rule = self._rule
        if rule is None:
            raise ControllerError(f"'{self.name}' was not activated")
        parameters = self.parameters
        if (parameters.enable_parameter_update_without_reactivation
                and parameters is not self._settled):
            self._settled, rule.links = parameters, self._motion(parameters)
        admittance = self._settled.admittance
        assert admittance is not None  # configure has refused it
        kinds: tuple[str, ...] = parameters.chainable_command_interfaces
        rows = dict(zip(kinds, references.reshape(-1, len(self.joints)), strict=True))
        position = rows.get(POSITION, self._held)
        measured = self.context.hardware.read_states(self._measured)
        if np.isnan(measured).any():  # the filter would never forget it
            measured = np.zeros_like(measured)
        rule.step(self._settled, admittance, position, measured + self._added_wrench, period)
        requested = {
            POSITION: position + rule.offset,
            VELOCITY: rows.get(VELOCITY, np.zeros_like(position)) + rule.velocity,
            ACCELERATION: rule.acceleration,
        }
        command = np.concatenate([requested[kind] for kind in parameters.command_interfaces])
        self._output.write(command)
        self._snapshot = AdmittanceSnapshot(
            time_ns, self._settled, admittance, damping_of(admittance), rule.control_rotation,
            rule.sensor_at_reference, rule.wrench, rule.yielded.copy(), rule.twist,
            rule.twist_rate, rule.offset, rule.velocity, rule.acceleration)

    def snapshot(self) -> AdmittanceSnapshot | None:
        """Return what the last update did, None before the first."""
        return self._snapshot

    def _motion(self, parameters: AdmittanceControllerParameters) -> LinkMotion:
        """
        Return the frames that parameters name.

        :raises ControllerError: a parameter is missing, or the robot lacks what it names.
        """
        model = self.context.model
        if parameters.missing:
            raise ControllerError(f"parameter '{parameters.missing}' of '{self.name}' is missing")
        if model is None:
            raise ControllerError(f"'{self.name}' needs the robot's description")
        return LinkMotion(model, parameters.joints, parameters.kinematics.base, (
            parameters.ft_sensor.frame.id, parameters.control.frame.id,
            parameters.fixed_world_frame.frame.id, parameters.gravity_compensation.frame.id))

    @property
    def _targets(self) -> list[tuple[str, str]]:
        joints = self.parameters.command_joints or self.joints
        return [(joint, kind) for kind in self.parameters.command_interfaces for joint in joints]

    @property
    def _measured(self) -> tuple[str, ...]:
        name = self.parameters.ft_sensor.name
        return tuple(f'{name}/{kind}.{axis}' for kind in ('force', 'torque') for axis in 'xyz')
