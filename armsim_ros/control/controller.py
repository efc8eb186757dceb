# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The base of all controllers: life cycle, interfaces, parameters and their updates.

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
from armsim_ros.control.hardware_interface import HardwareInterface
from armsim_ros.control.mailbox import ControllerEvent, EventQueue
from armsim_ros.control.parameter_changes import changed, in_effect
from armsim_ros.model.robot_model import RobotModel

TOLERANCE_NS = 1_000
"""So much too early still counts as in time: rounding of float time steps [ns]."""


class Rate:
    """
    Determines when something is due: at multiples of the period after the first time asked.

    :param frequency: [Hz]; infinite is always, 0 or less is never.
    :param aligned: count the multiples from time 0 instead, so that what has the same rate is
        due at the same time; the first time asked it is due all the same.
    """

    def __init__(self, frequency: float, *, aligned: bool = False) -> None:
        self._period_ns = 1e9 / frequency if frequency > 0.0 else math.inf
        self._aligned = aligned and self._period_ns > 0.0
        self._base_ns = 0
        self._count = 0
        self._last_ns: int | None = None

    def next_due_ns(self, time_ns: int) -> int | None:
        """Return when it is due next, from a time on [ns]; None where it is never."""
        if math.isinf(self._period_ns):
            return None
        last = self._last_ns
        if last is None or time_ns < last or self._period_ns == 0.0:
            return time_ns
        return math.ceil(self._base_ns + (self._count + 1) * self._period_ns) - TOLERANCE_NS

    def due(self, time_ns: int) -> bool:
        """
        Return whether it is time again; asked once an update [ns].

        Periods that were missed are not made up for; when time jumps back it starts anew.
        """
        if math.isinf(self._period_ns):
            return False
        last, self._last_ns = self._last_ns, time_ns
        if last is None or time_ns < last:
            since_ns = time_ns % self._period_ns if self._aligned else 0.0
            self._base_ns, self._count = time_ns - round(since_ns), 0
            return True
        if self._period_ns == 0.0:
            return time_ns > last
        count = int((time_ns + TOLERANCE_NS - self._base_ns) // self._period_ns)
        if count > self._count:
            self._count = count
            return True
        return False


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
    :param obstacle: returns why the arm takes no commands, '' where it does; any thread.
    """

    hardware: HardwareInterface
    model: RobotModel | None
    update_rate: int
    wake: Callable[[], object] = lambda: None
    obstacle: Callable[[], str] = lambda: ''


class Controller(ABC, Generic[ParametersT]):
    """
    A controller.

    :param name: as in the manager's parameters.
    :param type: the type under which it was loaded.
    :param parameters: checked; replaced as a whole when any of those in effect changes.
    """

    parameters_class: ClassVar[type[Settings]]

    chainable: ClassVar[bool] = False
    """Whether it exports references or states for other controllers."""

    frees_arm: ClassVar[bool] = False
    """Whether forces from outside may move the arm while it is active, so that no other does."""

    only_reads: ClassVar[bool] = False
    """Whether updates command nothing and depend on nothing but states and time."""

    def __init__(
        self,
        name: str,
        type: str,  # noqa: A002
        parameters: ParametersT,
        context: ControllerContext,
    ) -> None:
        self.name, self.type, self.parameters, self.context = name, type, parameters, context
        self._requested = parameters
        self.state = LifecycleState.UNCONFIGURED
        self.events = EventQueue(name)
        self.time_ns = 0
        #: Controllers that take over when this controller fails; set by the manager.
        self.fallback_controllers: tuple[str, ...] = ()
        #: Whether another controller writes this controller's references; set by the manager.
        self.chained = False
        #: Of a device: the active controller that commands its joints, '' where none does.
        self.holder = ''
        self.on_init()

    def on_init(self) -> None:
        """Make what a kind of controller needs from the moment on at which it is loaded."""

    @property
    def active(self) -> bool:
        """Whether the controller is updated."""
        return self.state is LifecycleState.ACTIVE

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it commands."""
        return ()

    @property
    def update_rate(self) -> int:
        """Updates per second, of those that the manager calls [Hz]."""
        return self.own_rate

    @property
    def own_rate(self) -> int:
        """
        Updates per second: what the parameters ask for, or the nearest rate that can be run [Hz].

        Only every so many updates of the manager can be updates of the controller.
        """
        rate, fastest = self._requested_rate, self.context.update_rate
        return fastest if rate >= fastest else fastest // math.floor(fastest / rate + 0.5)

    @property
    def moves_arm(self) -> bool:
        """Whether it commands joints, and stops when the arm does."""
        references = self.context.hardware.references
        return bool(self.moved_joints) or any(
            name in references for name in self.required_command_interfaces)

    @property
    def moved_joints(self) -> tuple[str, ...]:
        """Joints of the hardware whose motion it commands."""
        motions = map(self.context.hardware.motion_of, self.required_command_interfaces)
        return tuple(dict.fromkeys(motion[0] for motion in motions if motion))

    @property
    def obstacle(self) -> str:
        """Why its commands are not followed, '' where they are; any thread."""
        reason = self.context.obstacle()
        return reason if reason and self.moves_arm else ''

    def warn_of_rate(self) -> None:
        """Warn where the parameters ask for a rate that cannot be run."""
        if self._requested_rate != self.own_rate:
            self.events.warn(
                self.time_ns, f'runs at {self.own_rate} Hz instead of {self._requested_rate} Hz: '
                f"its update_rate has to divide the manager's {self.context.update_rate} Hz")

    @property
    def _requested_rate(self) -> int:
        rate: int = getattr(self.parameters, 'update_rate', 0)
        return rate or self.context.update_rate

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Interfaces to claim, as ``joint/interface``."""
        return ()

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Interfaces to read, as ``joint/interface``."""
        return ()

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

    def process_requests(self, time_ns: int) -> None:
        """Take up what other threads requested, while time is paused; commands wait."""

    def set_parameters(self, changes: Settings | Mapping[str, Any]) -> None:
        """
        Replace the parameters; the next update works with the new ones.

        Those that only configure takes over wait for :meth:`take_parameters`.

        :param changes: all parameters, or some by their dotted names.
        :raises ControllerError: the change is not allowed, and nothing was changed.
        """
        new = changed(self._requested, changes)
        self.check_parameters(new)
        self._requested = new
        self.parameters = in_effect(self.parameters, new)
        self.context.wake()

    def take_parameters(self) -> None:
        """Have all parameters take effect, as a controller that is being configured does."""
        self.parameters = self._requested

    def check_parameters(self, parameters: ParametersT) -> None:
        """Check parameters that are about to be set; ControllerError refuses them."""

    def poll_events(self) -> list[ControllerEvent]:
        """Return the events since the last call."""
        return self.events.drain()
