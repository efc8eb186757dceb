# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers that pass commands on or yield, as their packages declare them."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import (
    configured,
    ControllerParameters,
    fixed,
    parameter,
    Settings,
    unique_names,
)
from armsim_ros.config.controllers.broadcasters import BroadcasterParameters
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.errors import nearest

POSITION = 'position'


class ForwardParameters(ControllerParameters):
    """
    What all of them share; the command timeout is ours.

    A list or name that is needed and empty is reported when the controller is configured.
    """

    command_timeout: float = parameter(
        0.0,
        'silence after which velocity becomes 0 and effort is replaced by holding; 0 is never [s]',
        ge=0.0, allow_inf_nan=False)

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """(joint, interface) of each value of a command."""
        raise NotImplementedError

    @property
    def missing(self) -> str:
        """The parameter that has to be given and is empty, '' where there is none."""
        raise NotImplementedError


class JointGroupParameters(ForwardParameters):
    """Parameters of a group of joints with the interface that the type's name gives."""

    interface: ClassVar[str] = POSITION
    joints: tuple[str, ...] = configured((), 'commanded joints, in the order of the values')

    @field_validator('joints')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return unique_names(value)

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """The group's interface of each joint."""
        return tuple((joint, self.interface) for joint in self.joints)

    @property
    def missing(self) -> str:
        """Name ``joints`` where it is empty."""
        return '' if self.joints else 'joints'


class JointGroupPositionControllerParameters(JointGroupParameters):
    """Parameters of ``position_controllers/JointGroupPositionController``."""

    gains: dict[str, PidGains] = parameter({}, 'joint -> gains of its simulated drive')


class JointGroupVelocityControllerParameters(JointGroupParameters):
    """Parameters of ``velocity_controllers/JointGroupVelocityController``."""

    interface: ClassVar[str] = 'velocity'


class JointGroupEffortControllerParameters(JointGroupParameters):
    """Parameters of ``effort_controllers/JointGroupEffortController``."""

    interface: ClassVar[str] = 'effort'


class ForwardCommandControllerParameters(JointGroupParameters):
    """Parameters of ``forward_command_controller/ForwardCommandController``."""

    interface_name: str = configured('', 'interface that is commanded')

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """The named interface of each joint."""
        return tuple((joint, self.interface_name) for joint in self.joints)

    @property
    def missing(self) -> str:
        """Name what is empty."""
        return super().missing or ('' if self.interface_name else 'interface_name')


class MultiInterfaceForwardCommandControllerParameters(ForwardParameters):
    """Parameters of ``forward_command_controller/MultiInterfaceForwardCommandController``."""

    joint: str = configured('', 'commanded joint')
    interface_names: tuple[str, ...] = configured(
        (), 'commanded interfaces, in the order of the values')

    @field_validator('interface_names')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return unique_names(value)

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """Each interface of the joint."""
        return tuple((self.joint, name) for name in self.interface_names)

    @property
    def missing(self) -> str:
        """Name what is empty."""
        if not self.joint:
            return 'joint'
        return '' if self.interface_names else 'interface_names'


class JointParameters(ForwardParameters):
    """Parameters of ROS 1's controllers of a single joint; the type's name gives its interface."""

    interface: ClassVar[str] = POSITION
    joint: str = configured('', 'commanded joint')

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """The interface."""
        return ((self.joint, self.interface),)

    @property
    def missing(self) -> str:
        """Name ``joint`` where it is empty."""
        return '' if self.joint else 'joint'


class JointPositionControllerParameters(JointParameters):
    """Parameters of ``position_controllers/JointPositionController``."""

    pid: PidGains | None = fixed(None, "gains of the joint's simulated drive")

    @property
    def gains(self) -> dict[str, PidGains]:
        """Joint -> gains of its drive."""
        return {self.joint: self.pid} if self.pid is not None else {}


class JointVelocityControllerParameters(JointParameters):
    """Parameters of ``velocity_controllers/JointVelocityController``."""

    interface: ClassVar[str] = 'velocity'
    pid: PidGains | None = fixed(
        None, 'ROS 1: has no effect, the drive follows velocities by itself')


class JointEffortControllerParameters(JointParameters):
    """Parameters of ``effort_controllers/JointEffortController``."""

    interface: ClassVar[str] = 'effort'


class GpioInterfaces(Settings):
    """Interfaces of a gpio."""

    interfaces: tuple[str, ...] = fixed((), 'names without the gpio')


class GpioCommandControllerParameters(BroadcasterParameters):
    """Parameters of ``gpio_controllers/GpioCommandController``."""

    gpios: tuple[str, ...] = fixed((), 'gpios, joints or sensors, commanded or published')
    command_interfaces: dict[str, GpioInterfaces] = fixed({}, 'gpio -> what is commanded')
    state_interfaces: dict[str, GpioInterfaces] = fixed(
        {}, 'gpio -> published interfaces; all of gpios by default')

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """(gpio, interface) of each command interface."""
        return _pairs(self.gpios, self.command_interfaces)

    @property
    def states(self) -> tuple[str, ...]:
        """State interfaces that are named."""
        return tuple('/'.join(pair) for pair in _pairs(self.gpios, self.state_interfaces))

    @property
    def missing(self) -> str:
        """Name ``gpios`` where it is empty."""
        return '' if self.gpios else 'gpios'

    @model_validator(mode='after')
    def _only_its_own(self) -> Self:
        for key in ('command_interfaces', 'state_interfaces'):
            for name in getattr(self, key):
                if name not in self.gpios:
                    raise ValueError(f"{key}: '{name}' is not among gpios ("
                                     f'{", ".join(self.gpios)}) {nearest(name, self.gpios)}'
                                     .rstrip())
        return self


def _pairs(
    gpios: tuple[str, ...], chosen: dict[str, GpioInterfaces]
) -> tuple[tuple[str, str], ...]:
    return tuple((gpio, name) for gpio in gpios if gpio in chosen
                 for name in chosen[gpio].interfaces)


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

    name: str = configured('', 'force-torque sensor with all six interfaces')
    filter_coefficient: float = parameter(
        0.05, 'share of the newest measurement in the filtered value', gt=0.0, le=1.0)


class AdmittanceKinematics(Settings):
    """From joints to links."""

    plugin_name: str = configured('', "has no effect: the robot's own model is used")
    plugin_package: str = configured('', "has no effect: the robot's own model is used")
    base: str = configured('', 'link in whose axes forces and motion are given')
    tip: str = configured('', 'link at the end of the joints')
    alpha: float = parameter(0.01, 'damping of the inverse Jacobian', ge=0.0)


class CentreOfGravity(Settings):
    """What hangs beyond the sensor."""

    pos: tuple[float, float, float] = parameter((0.0, 0.0, 0.0), 'its centre of gravity [m]')
    force: float = parameter(0.0, 'its weight [N]', allow_inf_nan=False)


class GravitySettings(FramedSettings):
    """What the sensor measures of gravity alone; the frame is that of the centre's position."""

    CoG: CentreOfGravity = parameter(CentreOfGravity(), 'what hangs beyond the sensor')


class AdmittanceSettings(Settings):
    """
    Spring and damper of each axis of the control frame, mass of each axis of the base frame.

    The axes are x, y, z, rx, ry, rz.
    """

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

    joints: tuple[str, ...] = fixed((), 'controlled joints')
    command_joints: tuple[str, ...] = fixed(
        (), "joints of following controllers, in joints' order; empty is joints")
    command_interfaces: tuple[Interface, ...] = fixed(
        ('position',), 'interfaces to claim', min_length=1)
    state_interfaces: tuple[Interface, ...] = fixed(
        ('position',), 'interfaces to read', min_length=1)
    chainable_command_interfaces: tuple[Reference, ...] = fixed(
        ('position', 'velocity'), 'references to export')
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
    robot_description: str = fixed('', 'has no effect: the URDF file is read')

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
