# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers that pass commands on, as their packages declare them."""

from __future__ import annotations

from typing import ClassVar

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import ControllerParameters, parameter, Settings, unique_names
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
        ge=0.0,
        allow_inf_nan=False,
    )

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
    joints: tuple[str, ...] = parameter(
        (), 'commanded joints, in the order of the values', read_only=True
    )

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

    interface_name: str = parameter('', 'interface that is commanded', read_only=True)

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

    joint: str = parameter('', 'commanded joint', read_only=True)
    interface_names: tuple[str, ...] = parameter(
        (), 'commanded interfaces, in the order of the values', read_only=True
    )

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
    joint: str = parameter('', 'commanded joint', read_only=True)

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

    pid: PidGains | None = parameter(None, "gains of the joint's simulated drive", read_only=True)

    @property
    def gains(self) -> dict[str, PidGains]:
        """Joint -> gains of its drive."""
        return {self.joint: self.pid} if self.pid is not None else {}


class JointVelocityControllerParameters(JointParameters):
    """Parameters of ``velocity_controllers/JointVelocityController``."""

    interface: ClassVar[str] = 'velocity'
    pid: PidGains | None = parameter(
        None, 'ROS 1: has no effect, the drive follows velocities by itself', read_only=True
    )


class JointEffortControllerParameters(JointParameters):
    """Parameters of ``effort_controllers/JointEffortController``."""

    interface: ClassVar[str] = 'effort'


class GpioInterfaces(Settings):
    """Interfaces of a gpio."""

    interfaces: tuple[str, ...] = parameter((), 'names without the gpio', read_only=True)


class GpioCommandControllerParameters(BroadcasterParameters):
    """Parameters of ``gpio_controllers/GpioCommandController``."""

    gpios: tuple[str, ...] = parameter((), 'gpios that are commanded or published', read_only=True)
    command_interfaces: dict[str, GpioInterfaces] = parameter(
        {}, 'gpio -> what is commanded', read_only=True)
    state_interfaces: dict[str, GpioInterfaces] = parameter(
        {}, 'gpio -> published interfaces; all by default', read_only=True)

    @property
    def commands(self) -> tuple[str, ...]:
        """Command interfaces, as ``gpio/interface``."""
        return _names(self.gpios, self.command_interfaces)

    @property
    def interfaces(self) -> tuple[str, ...]:
        """State interfaces that are named."""
        return _names(self.gpios, self.state_interfaces)

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


def _names(gpios: tuple[str, ...], chosen: dict[str, GpioInterfaces]) -> tuple[str, ...]:
    return tuple(f'{gpio}/{name}' for gpio in gpios if gpio in chosen
                 for name in chosen[gpio].interfaces)
