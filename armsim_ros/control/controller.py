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
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
import math
from typing import Any, ClassVar, Generic, TypeVar

from armsim_ros.config.base import Settings
from armsim_ros.control.events import ControllerEvent, EventQueue
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.parameter_update import changed
from armsim_ros.model.robot_model import RobotModel

ParametersT = TypeVar('ParametersT', bound=Settings)

NEVER_NS = 2**62
"""A time that does not come [ns]."""


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
    :param wake: to be called from any thread when there is something new for the next update.
    """

    hardware: HardwareInterface
    model: RobotModel | None
    update_rate: int
    wake: Callable[[], object] = lambda: None


class Controller(ABC, Generic[ParametersT]):
    """
    A controller.

    :param name: as in the manager's parameters.
    :param type: the type under which it was loaded.
    :param parameters: checked; replaced as a whole when any changes.
    """

    parameters_class: ClassVar[type[Settings]]

    chainable: ClassVar[bool] = False
    """Whether it exports references or states for other controllers."""

    only_reads: ClassVar[bool] = False
    """Whether updates command nothing and depend on nothing but states and time."""

    def __init__(
        self,
        name: str,
        type: str,  # noqa: A002
        parameters: ParametersT,
        context: ControllerContext,
    ) -> None:
        self.name = name
        self.type = type
        self.parameters = parameters
        self.context = context
        self.state = LifecycleState.UNCONFIGURED
        self.events = EventQueue(name)
        self.time_ns = 0
        #: Controllers that take over when this controller fails; set by the manager.
        self.fallback_controllers: tuple[str, ...] = ()
        #: Whether another controller writes this controller's references; set by the manager.
        self.chained = False
        self.on_init()

    def on_init(self) -> None:
        """Make what a kind of controller needs from the moment on at which it is loaded."""

    @property
    def active(self) -> bool:
        """Whether the controller is updated."""
        return self.state is LifecycleState.ACTIVE

    @property
    def update_rate(self) -> int:
        """
        Updates per second: what the parameters ask for, or the nearest rate that can be run [Hz].

        Only every so many updates of the manager can be updates of the controller.
        """
        rate, fastest = self._requested_rate, self.context.update_rate
        return fastest if rate >= fastest else fastest // math.floor(fastest / rate + 0.5)

    def warn_of_rate(self) -> None:
        """Warn where the parameters ask for a rate that cannot be run."""
        if self._requested_rate != self.update_rate:
            self.events.add(
                self.time_ns, 'warning', 'warning',
                f'runs at {self.update_rate} Hz instead of {self._requested_rate} Hz: its '
                f"update_rate has to divide the manager's {self.context.update_rate} Hz")

    @property
    def _requested_rate(self) -> int:
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

    @property
    def reads_all_states(self) -> bool:
        """Whether it reads whatever states are available, and needs none of them."""
        return False

    @property
    def reference_interfaces(self) -> tuple[str, ...]:
        """What other controllers may write to, as ``controller/joint/interface``."""
        return ()

    @property
    def exported_states(self) -> tuple[str, ...]:
        """States that other controllers may read, as ``controller/joint/interface``."""
        return ()

    @abstractmethod
    def configure(self) -> None:
        """Check what can be checked before activation; ControllerError names what is wrong."""

    @abstractmethod
    def activate(self, time_ns: int) -> None:
        """Take the claimed joints over without moving them; ControllerError where it cannot."""

    @abstractmethod
    def deactivate(self, time_ns: int) -> None:
        """Let go of the joints and end all goals."""

    def interrupt(self, time_ns: int, reason: str) -> None:
        """
        End all goals because the plant is about to be somewhere else.

        The controller stays active; ``activate`` is called where it goes on.

        :param reason: for clients that wait for a goal.
        """
        self.deactivate(time_ns)

    @abstractmethod
    def update(self, time_ns: int, period: float) -> None:
        """
        Read states and write commands.

        :param time_ns: the time that the states belong to [ns].
        :param period: until the next update [s].
        """

    def next_update(self, time_ns: int) -> int:
        """
        Return from when on an update matters [ns]; an earlier update would change no command.

        The control loop's thread asks between updates; those that do not matter may be left out,
        see :meth:`pass_updates`.
        What another thread asks for ends the time at once: it calls the context's ``wake``.

        :param time_ns: the time of the next update; it matters where this is returned.
        """
        return time_ns

    def plan(self, updates: int, period: float) -> int:
        """
        Write position commands for some updates ahead into the hardware's ``plan``.

        They are those that so many updates from now on would write if nothing came between and
        the joints stayed where ``plan`` expects them.

        :param updates: that may be planned.
        :param period: from each to the next [s].
        :returns: updates that are planned; 0 where the controller does not know.
        """
        return 0

    def pass_updates(self, updates: int, period: float) -> None:
        """
        Be where updates have led that were not made: they did not matter, or were planned.

        :param updates: at least 1.
        :param period: from each to the next [s].
        """

    @abstractmethod
    def process_requests(self, time_ns: int) -> None:
        """Take up what other threads requested, while time is paused."""

    def set_parameters(self, changes: Settings | Mapping[str, Any]) -> None:
        """
        Replace the parameters; the next update works with the new ones.

        :param changes: all parameters, or some by their dotted names.
        :raises ControllerError: the change is not allowed, and nothing was changed.
        """
        self.parameters = changed(self.parameters, changes)
        self.context.wake()

    def poll_events(self) -> list[ControllerEvent]:
        """Return the events since the last call."""
        return self.events.drain()
