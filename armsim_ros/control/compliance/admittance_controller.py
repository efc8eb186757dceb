# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The admittance controller of crisp_controllers: its target yields to a measured wrench."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    YieldingSettings,
)
from armsim_ros.control.compliance.cartesian_controller import ComplianceController
from armsim_ros.control.compliance.impedance_law import bounded, pose_error
from armsim_ros.errors import ControllerError
from armsim_ros.model.transforms import matrix_from_axis_angle

_AXES = ('x', 'y', 'z', 'rx', 'ry', 'rz')


class CartesianAdmittanceController(
        ComplianceController[CartesianAdmittanceControllerParameters]):
    """
    ``crisp_controllers/CartesianAdmittanceController``.

    The tip follows a mass on a spring and damper at the target, in the axes of the base frame:
    ``M a = F - D v + K (target - x)``.
    """

    parameters_class: ClassVar[type[Settings]] = CartesianAdmittanceControllerParameters

    def configure(self) -> None:
        """Check the sensor's frame, too."""
        super().configure()
        frame = self.parameters.ft_sensor.frame
        if frame and not self._arm.has(frame):
            raise ControllerError(f"ft_sensor.frame: no link '{frame}'")

    def activate(self, time_ns: int) -> None:
        """Begin at rest, without a wrench."""
        super().activate(time_ns)
        self._inner = self._target.copy()
        self._motion, self._measured = np.zeros(6), np.zeros(6)
        self._yielding_stiffness: Vector | None = None

    def receive_measured(self, wrench: Sequence[float]) -> str:
        """
        Take what the sensor measures, in its own axes (6,) [N, N*m].

        :returns: why it was dropped, '' where it was taken.
        """
        if not np.isfinite(wrench).all():
            return self._drop(self.parameters.ft_sensor.topic, str(list(wrench)))
        values = np.array(wrench, dtype=np.float64)
        return self._post(lambda: setattr(self, '_measured', values))

    def receive_yielding_stiffness(self, values: Sequence[float]) -> str:
        """
        Take the stiffness of the admittance (6,) [N/m, N*m/rad]; too large values are bounded.

        :returns: why it was dropped, '' where it was taken.
        """
        topic = self.parameters.variable_admittance_stiffness.topic
        if len(values) != 6 or not np.isfinite(values).all():
            return self._drop(topic, f'{list(values)}; expected six finite numbers')
        given = np.array(values, dtype=np.float64)
        taken = bounded(given, self.parameters.variable_max_admittance_stiffness)
        self.warn_of_bounds(topic, given, taken)
        return self._post(lambda: setattr(self, '_yielding_stiffness', taken))

    def followed_pose(self, period: float) -> Matrix:
        """Return where the mass is after the period (4, 4)."""
        parameters, inner = self.parameters, self._inner
        sensor = self._arm.frame(parameters.ft_sensor.frame)[:3, :3]
        force = np.concatenate((sensor @ self._measured[:3], sensor @ self._measured[3:]))
        stiffness = self._yielding_stiffness
        if stiffness is None:
            stiffness = bounded(_of_axes(parameters.admittance, 'stiffness'),
                                parameters.variable_max_admittance_stiffness)
        force += stiffness * pose_error(self._desired, inner)
        force -= _of_axes(parameters.admittance, 'damping') * self._motion
        self._motion = self._motion + period * force / _of_axes(parameters.admittance, 'mass')
        inner[:3, 3] += period * self._motion[:3]
        speed = float(np.linalg.norm(self._motion[3:]))
        if speed > 1e-12:
            inner[:3, :3] = matrix_from_axis_angle(
                self._motion[3:] / speed, period * speed) @ inner[:3, :3]
        return inner


def _of_axes(settings: YieldingSettings, kind: str) -> Vector:
    return np.array([getattr(settings, f'{kind}_{axis}') for axis in _AXES])
