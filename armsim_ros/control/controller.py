# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The base of all controllers: life cycle, interfaces, parameters.

``activate``, ``deactivate``, ``update`` and ``process_requests`` are called by the control loop's
thread alone. ``configure`` is called by the manager while the controller is not active. All else
may be called from any thread.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar, Generic, TypeVar

from armsim_ros.config.base import Settings
from armsim_ros.control.events import ControllerEvent, EventQueue
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.parameter_update import changed
from armsim_ros.model.robot_model import RobotModel

ParametersT = TypeVar('ParametersT', bound=Settings)


class LifecycleState(Enum):
    """States of a controller, with the words of ``lifecycle_msgs``."""

    UNCONFIGURED = 'unconfigured'
    INACTIVE = 'inactive'
    ACTIVE = 'active'
    FINALIZED = 'finalized'


@dataclass(frozen=True, slots=True)
class ControllerContext:
    """
    What a manager gives to its controllers.

    :param model: joint types and limits, or None where no robot description is known.
    :param update_rate: of the manager [Hz].
    """

    hardware: HardwareInterface
    model: RobotModel | None
    update_rate: int


class Controller(ABC, Generic[ParametersT]):
    """
    One controller.

    :param name: as in the manager's parameters.
    :param type: the type under which it was loaded.
    :param parameters: checked; replaced as a whole when one changes.
    """

    parameters_class: ClassVar[type[Settings]]

    def __init__(
        self,
        name: str,
        type: str,  # noqa: A002
        parameters: ParametersT,
        context: ControllerContext,
    ) -> None:
        """Start unconfigured."""
        self.name = name
        self.type = type
        self.parameters = parameters
        self.context = context
        self.state = LifecycleState.UNCONFIGURED
        self.events = EventQueue(name)
        self.time_ns = 0

    @property
    def active(self) -> bool:
        """Whether the controller is updated."""
        return self.state is LifecycleState.ACTIVE

    @property
    def update_rate(self) -> int:
        """Updates a second that were asked for [Hz]."""
        rate: int = getattr(self.parameters, 'update_rate', 0)
        return rate or self.context.update_rate

    @property
    @abstractmethod
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Interfaces to claim, as ``joint/interface``."""

    @property
    @abstractmethod
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Interfaces to read, as ``joint/interface``."""

    @abstractmethod
    def configure(self) -> None:
        """Check what can be checked before activation; ControllerError says what is wrong."""

    @abstractmethod
    def activate(self, time_ns: int) -> None:
        """Take the claimed joints over without moving them; ControllerError where it cannot."""

    @abstractmethod
    def deactivate(self, time_ns: int) -> None:
        """Let go of the joints and end all goals."""

    @abstractmethod
    def update(self, time_ns: int, period: float) -> None:
        """
        Read states and write commands.

        :param time_ns: the time that the states belong to [ns].
        :param period: until the next update [s].
        """

    @abstractmethod
    def process_requests(self, time_ns: int) -> None:
        """Take up what other threads asked for, while time stands still."""

    def set_parameters(self, changes: Settings | Mapping[str, Any]) -> None:
        """
        Replace the parameters; the next update works with the new ones.

        :param changes: all parameters, or some by their dotted names.
        :raises ControllerError: the change is not allowed, and nothing was changed.
        """
        self.parameters = changed(self.parameters, changes)

    def poll_events(self) -> list[ControllerEvent]:
        """Return the events since the last call."""
        return self.events.drain()
