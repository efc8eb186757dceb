# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the admittance controller, as admittance_controller declares them."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import ControllerParameters, parameter, Settings

Axes = tuple[float, float, float, float, float, float]
Interface = Literal['position', 'velocity', 'acceleration']
Reference = Literal['position', 'velocity']


class FrameSettings(Settings):
    """A frame."""

    id: str = parameter('', 'link of the robot')


class FramedSettings(Settings):
    """What has a frame."""

    frame: FrameSettings = parameter(FrameSettings(), 'the frame')


class ForceTorqueSettings(FramedSettings):
    """The sensor."""

    name: str = parameter('', 'force-torque sensor with all six interfaces', read_only=True)
    filter_coefficient: float = parameter(
        0.05, 'share of the newest measurement in the filtered value', gt=0.0, le=1.0
    )


class AdmittanceKinematics(Settings):
    """From joints to links."""

    plugin_name: str = parameter(
        '', "has no effect: the robot's own model is used", read_only=True)
    plugin_package: str = parameter(
        '', "has no effect: the robot's own model is used", read_only=True)
    base: str = parameter('', 'link in whose axes forces and motion are given', read_only=True)
    tip: str = parameter('', 'link at the end of the joints', read_only=True)
    alpha: float = parameter(0.01, 'damping of the inverse Jacobian', ge=0.0)


class CentreOfGravity(Settings):
    """What hangs beyond the sensor."""

    pos: tuple[float, float, float] = parameter((0.0, 0.0, 0.0), 'its centre of gravity [m]')
    force: float = parameter(0.0, 'its weight [N]', allow_inf_nan=False)


class GravitySettings(FramedSettings):
    """What the sensor measures of gravity alone; the frame is that of the centre's position."""

    CoG: CentreOfGravity = parameter(CentreOfGravity(), 'what hangs beyond the sensor')


class AdmittanceSettings(Settings):
    """Mass, spring and damper of each axis of the control frame: x, y, z, rx, ry, rz."""

    selected_axes: tuple[bool, bool, bool, bool, bool, bool] = parameter(
        ..., 'where the arm yields')
    mass: Axes = parameter(..., 'mass and inertia, 0.0001 to 1e6 [kg, kg*m^2]')
    damping_ratio: Axes = parameter(..., 'damping / (2 * sqrt(mass * stiffness)), 0 or more')
    stiffness: Axes = parameter(..., 'stiffness, 0 to 1e8 [N/m, N*m/rad]')
    joint_damping: float = parameter(5.0, "damping of the joints' own yielding [1/s]", ge=0.0)

    @field_validator('mass', 'stiffness', 'damping_ratio')
    @classmethod
    def _within(cls, value: Axes) -> Axes:
        if not all(0.0 <= entry < float('inf') for entry in value):
            raise ValueError(f'{list(value)}; allowed: six finite numbers, none below 0')
        return value

    @model_validator(mode='after')
    def _massive(self) -> Self:
        if min(self.mass) < 1e-4 or max(self.mass) > 1e6:
            raise ValueError(f'mass {list(self.mass)}; allowed: 0.0001 to 1e6')
        return self


class AdmittanceControllerParameters(ControllerParameters):
    """
    Parameters of ``admittance_controller/AdmittanceController``.

    What is needed and empty is reported when the controller is configured.
    """

    joints: tuple[str, ...] = parameter((), 'controlled joints', read_only=True)
    command_joints: tuple[str, ...] = parameter(
        (), "joints of following controllers, in joints' order; empty is joints", read_only=True)
    command_interfaces: tuple[Interface, ...] = parameter(
        ('position',), 'interfaces to claim', read_only=True, min_length=1)
    state_interfaces: tuple[Interface, ...] = parameter(
        ('position',), 'interfaces to read', read_only=True, min_length=1)
    chainable_command_interfaces: tuple[Reference, ...] = parameter(
        ('position', 'velocity'), 'references to export', read_only=True)
    kinematics: AdmittanceKinematics = parameter(AdmittanceKinematics(), 'from joints to links')
    ft_sensor: ForceTorqueSettings = parameter(ForceTorqueSettings(), 'the sensor')
    control: FramedSettings = parameter(FramedSettings(), 'the frame in which the arm yields')
    fixed_world_frame: FramedSettings = parameter(
        FramedSettings(), 'gravity points down its z axis')
    gravity_compensation: GravitySettings = parameter(
        GravitySettings(), 'what the sensor measures of gravity alone')
    admittance: AdmittanceSettings | None = parameter(None, 'mass, spring and damper')
    enable_parameter_update_without_reactivation: bool = parameter(
        True, 'take new parameters over while active')
    robot_description: str = parameter('', 'has no effect: the URDF file is read', read_only=True)

    @model_validator(mode='after')
    def _together(self) -> Self:
        if len(self.command_joints) not in (0, len(self.joints)):
            raise ValueError(f'command_joints has {len(self.command_joints)} names and joints '
                             f'{len(self.joints)}')
        if 'position' not in self.state_interfaces:
            raise ValueError('state_interfaces: position is needed')
        return self

    @property
    def missing(self) -> str:
        """The parameter that has to be given and is empty, '' where there is none."""
        needed = {
            'joints': self.joints,
            'ft_sensor.name': self.ft_sensor.name,
            'ft_sensor.frame.id': self.ft_sensor.frame.id,
            'kinematics.base': self.kinematics.base,
            'control.frame.id': self.control.frame.id,
            'fixed_world_frame.frame.id': self.fixed_world_frame.frame.id,
            'gravity_compensation.frame.id': self.gravity_compensation.frame.id,
            'admittance': self.admittance,
        }
        return next((key for key, value in needed.items() if not value), '')
