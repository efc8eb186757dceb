# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers that pass commands on, as ros2_controllers declares them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import field_validator, model_validator

from armsim_ros.config.base import parameter, Settings, unique_names
from armsim_ros.config.controllers.pid_gains import PidGains

POSITION = 'position'

VELOCITY_TIMEOUT = 0.5
"""Silence that ends velocity and effort commands where nothing else is asked for [s]."""


def _timeout(default: float) -> Any:
    return parameter(
        default,
        'silence after which velocity goes to 0 and effort gives way to holding; 0 is never [s]',
        ge=0.0,
        allow_inf_nan=False,
    )


class ForwardParameters(Settings):
    """
    What all of them share; the command timeout is ours.

    A list or name that is needed and empty is told of when the controller is configured.
    """

    command_timeout: float = _timeout(0.0)
    update_rate: int = parameter(
        0, "updates a second, 0 is the manager's rate [Hz]", read_only=True, ge=0
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
    """Parameters of a group of joints with one interface; the type's name says which."""

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
    command_timeout: float = _timeout(VELOCITY_TIMEOUT)


class JointGroupEffortControllerParameters(JointGroupParameters):
    """Parameters of ``effort_controllers/JointGroupEffortController``."""

    interface: ClassVar[str] = 'effort'
    command_timeout: float = _timeout(VELOCITY_TIMEOUT)


class ForwardCommandControllerParameters(JointGroupParameters):
    """Parameters of ``forward_command_controller/ForwardCommandController``."""

    interface_name: str = parameter('', 'interface that is commanded', read_only=True)

    @model_validator(mode='before')
    @classmethod
    def _timeout_of_the_interface(cls, data: Any) -> Any:
        return _with_timeout(data, [data.get('interface_name')] if _is_block(data) else [])

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

    @model_validator(mode='before')
    @classmethod
    def _timeout_of_the_interfaces(cls, data: Any) -> Any:
        names = data.get('interface_names') if _is_block(data) else None
        return _with_timeout(data, names if isinstance(names, (list, tuple)) else [])

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
    """Parameters of ROS 1's controllers of a single joint; the type's name says what it takes."""

    interface: ClassVar[str] = POSITION
    joint: str = parameter('', 'commanded joint', read_only=True)

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """The one interface."""
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
    command_timeout: float = _timeout(VELOCITY_TIMEOUT)
    pid: PidGains | None = parameter(
        None, 'ROS 1: has no effect, the drive follows velocities by itself', read_only=True
    )


class JointEffortControllerParameters(JointParameters):
    """Parameters of ``effort_controllers/JointEffortController``."""

    interface: ClassVar[str] = 'effort'
    command_timeout: float = _timeout(VELOCITY_TIMEOUT)


def _is_block(data: Any) -> bool:
    return isinstance(data, Mapping)


def _with_timeout(data: Any, interfaces: Any) -> Any:
    """Return the block with the timeout that velocity and effort have where none is given."""
    if not _is_block(data) or 'command_timeout' in data:
        return data
    lasting = all(name == POSITION for name in interfaces)
    return {**data, 'command_timeout': 0.0 if lasting else VELOCITY_TIMEOUT}
