# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The state of an arm's drives and safety, and what may change it.

The methods are for the control loop's thread; what they change is in force from the next update
on. Everything may be read from any thread.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Literal

from armsim_ros.config.simulation import HardwareSettings
from armsim_ros.control.controller import NEVER_NS
from armsim_ros.control.mailbox import EventQueue
from armsim_ros.vendors import Vendor


class Signals:
    """
    Values by name, such as ``digital_out_3``; a signal that was never set is 0.

    The methods are for the control loop's thread; values may be read from any thread.
    """

    def __init__(self) -> None:
        self._values: dict[str, float] = {}
        self._actions: dict[str, Callable[[bool], object]] = {}
        self._sources: dict[str, Callable[[], bool]] = {}

    def get(self, name: str) -> float:
        """Return the value of a signal; that of a wired input is its source's."""
        source = self._sources.get(name)
        return float(source()) if source is not None else self._values.get(name, 0.0)

    def set(self, name: str, value: float) -> None:
        """Set a signal; what a digital output is wired to is switched where the value changes."""
        before = self.get(name) > 0.0
        self._values[name] = value
        action = self._actions.get(name)
        if action is not None and (value > 0.0) != before:
            action(value > 0.0)

    def wire(self, actions: Mapping[str, Callable[[bool], object]],
             sources: Mapping[str, Callable[[], bool]]) -> None:
        """
        Connect signals.

        :param actions: output -> is called with its new value.
        :param sources: input -> returns its value; any thread.
        """
        self._actions.update(actions)
        self._sources.update(sources)

    def reset(self) -> None:
        """Switch everything off."""
        for name in list(self._values):
            self.set(name, 0.0)


#: After a pause trajectories reach the full pace in this time [s].
RAMP = 0.5


class Mode(Enum):
    """What the drives do; IDLE: they have power and the brakes are on."""

    POWER_OFF = 'POWER_OFF'
    POWER_ON = 'POWER_ON'
    IDLE = 'IDLE'
    RUNNING = 'RUNNING'


class Safety(Enum):
    """What the safety system allows."""

    NORMAL = 'NORMAL'
    REDUCED = 'REDUCED'
    PROTECTIVE_STOP = 'PROTECTIVE_STOP'
    SAFEGUARD_STOP = 'SAFEGUARD_STOP'
    EMERGENCY_STOP = 'EMERGENCY_STOP'
    FAULT = 'FAULT'


class Program(Enum):
    """What the program does by which an arm takes commands."""

    STOPPED = 'STOPPED'
    PLAYING = 'PLAYING'
    PAUSED = 'PAUSED'


CauseKind = Literal['injected', 'collision', 'speed', 'position', 'power', 'emergency']
#: Cause -> its number, for interfaces that have no room for a text.
NUMBERS: dict[str, int] = {
    'injected': 1, 'collision': 2, 'speed': 3, 'position': 4, 'power': 5, 'emergency': 6}


@dataclass(frozen=True, slots=True)
class Cause:
    """
    Why an arm stopped.

    :param text: joint or bodies, value and limit; '' where the kind is enough.
    :param joint: that it is about, if any.
    """

    kind: CauseKind
    text: str = ''
    joint: str = ''

    def __str__(self) -> str:
        """Return kind and text."""
        return f'{self.kind}: {self.text}' if self.text else self.kind


class ArmState:
    """
    Drives and safety of an arm.

    :param settings: the user's.
    :param vendor: whose arm it is; None for an arm without a vendor.
    :param events: get a line for each stop and its end.
    :param wake: called after each change.
    """

    def __init__(
        self, settings: HardwareSettings, vendor: Vendor | None, events: EventQueue,
        wake: Callable[[], object]
    ) -> None:
        self.settings = settings
        self.vendor = vendor or Vendor(name='none')
        self._events, self._wake = events, wake
        delay = settings.unlock_delay
        self.unlock_delay_ns = round(1e9 * (delay if delay >= 0.0 else self.vendor.unlock_delay))
        #: Returns what still keeps a protective stop from being cleared, None where nothing does.
        self.present_cause: Callable[[], Cause | None] = lambda: None
        #: Counts the changes, for those who publish the state.
        self.generation = 0
        #: Whether something changes that the next update has to follow.
        self.changed = False
        #: Whether the next update has anything to follow: a change, or one that time brings.
        self.busy = False
        self.time_ns = 0
        self.signals = Signals()
        self._begin()

    def _begin(self) -> None:
        self.mode = Mode(self.settings.start)
        self.safety = Safety.NORMAL
        self.cause: Cause | None = None
        self.since_ns = self.time_ns
        self.pressed = False
        self._target = self.mode
        self._due_ns = NEVER_NS
        runs = not self.vendor.program or (
            self.settings.program == 'PLAYING' and self.mode is Mode.RUNNING)
        self.program = Program.PLAYING if runs else Program.STOPPED
        #: Share of their speed at which trajectories are to run, 0.01 to 1.
        self.slider = 1.0
        #: Whether forces from outside move the arm.
        self.freedrive = False
        self.pace = self._target_pace
        """What trajectories feel of slider, pauses and stops, 0 to 1."""
        self._ramps, self._ramp_ns = False, NEVER_NS
        self.signals.reset()
        self.changed = self.busy = bool(self.obstacle)

    @property
    def stopped(self) -> bool:
        """Whether a stop of the safety system is in force."""
        return self.safety not in (Safety.NORMAL, Safety.REDUCED)

    @property
    def moves(self) -> bool:
        """Whether drives and safety let the arm move."""
        return self.mode is Mode.RUNNING and not self.stopped

    @property
    def obstacle(self) -> str:
        """Why the arm takes no commands, '' where it does."""
        if self.stopped:
            name = self.safety.value.replace('_', ' ').lower()
            return f'{name}: {self.cause}'
        if self.mode is not Mode.RUNNING:
            return f'the drives are not ready: {self.mode.value}; power the arm on'
        if self.program is Program.STOPPED:
            return "the arm's program does not run; play it"
        return 'the arm is in freedrive' if self.freedrive else ''

    @property
    def _target_pace(self) -> float:
        return self.slider if self.moves and self.program is Program.PLAYING else 0.0

    def update(self, time_ns: int) -> None:
        """Be where time has led [ns]."""
        self.time_ns = time_ns
        if time_ns >= self._due_ns:
            self._step_power()
        target = self._target_pace
        if self._ramps and target > 0.0:
            if self._ramp_ns == NEVER_NS:
                self._ramp_ns = time_ns
            self.pace = min(target, (time_ns - self._ramp_ns) * 1e-9 / RAMP)
            self._ramps = self.pace < target
        else:
            self.pace = target
        self.busy = self._due_ns != NEVER_NS or (self._ramps and target > 0.0)

    def set_slider(self, fraction: float) -> str:
        """Set the pace of trajectories; return why it is refused, '' where it is not."""
        if not 0.01 <= fraction <= 1.0:
            return f'the speed slider cannot be at {fraction:g}; allowed: 0.01 to 1.0'
        self.slider = fraction
        self._changed()
        return ''

    def play(self) -> str:
        """Run the program, or go on after a pause; return why it cannot, '' where it does."""
        if not self.moves:
            return f'the program cannot run: {self.obstacle}'
        if self.program is not Program.PLAYING:
            self.program = Program.PLAYING
            self._note('the program runs')
        return ''

    def pause(self) -> str:
        """Let trajectories rest where they are until ``play``; return why not, '' where so."""
        if self.program is Program.STOPPED:
            return 'no program runs'
        self.program, self._ramps, self._ramp_ns = Program.PAUSED, True, NEVER_NS
        self._note('the program is paused')
        return ''

    def stop_program(self) -> None:
        """End the program; the arm is held until ``play``."""
        if self.vendor.program and self.program is not Program.STOPPED:
            self.program, self.freedrive = Program.STOPPED, False
            self._note('the program is stopped')

    def set_freedrive(self, on: bool) -> None:
        """Let forces from outside move the arm, or hold it."""
        if on != self.freedrive:
            self.freedrive = on
            self._note(f'freedrive is {"on" if on else "off"}')

    def protective_stop(self, cause: Cause | None = None) -> None:
        """Stop the arm; an emergency stop stays what it is."""
        if self.safety is Safety.EMERGENCY_STOP or self.safety is Safety.PROTECTIVE_STOP:
            return
        self._stop(Safety.PROTECTIVE_STOP, cause or Cause('injected'))

    def emergency_stop(self, cause: Cause | None = None) -> None:
        """Press the button of the emergency stop."""
        self.pressed = True
        self._stop(Safety.EMERGENCY_STOP, cause or Cause('emergency', 'the button is pressed'))

    def release_emergency_stop(self) -> None:
        """Release the button; the arm goes on only after a recovery, or a power-up."""
        if not self.pressed:
            return
        self.pressed = False
        if self.vendor.emergency_power_off:
            self.safety, self.cause = Safety.NORMAL, None
            self.mode = self._target = Mode.POWER_OFF
            self._due_ns = NEVER_NS
        self._note('the emergency stop is released')

    def clear_stop(self) -> str:
        """
        End a stop.

        :returns: why it goes on, '' where it has ended or there was none.
        """
        if not self.stopped:
            return ''
        if self.pressed:
            return 'the button of the emergency stop is pressed; release it first'
        left_ns = self.since_ns + self.unlock_delay_ns - self.time_ns
        if self.safety is Safety.PROTECTIVE_STOP and left_ns > 0:
            return (f'a protective stop can be cleared {self.unlock_delay_ns * 1e-9:g} s after '
                    f'it began; wait {left_ns * 1e-9:.1f} s')
        present = self.present_cause()
        if present is not None:
            return f'the cause is still there: {present}'
        text = self.safety.value.replace('_', ' ').lower()
        self.safety, self.cause, self.since_ns = Safety.NORMAL, None, self.time_ns
        self._note(f'the {text} is cleared')
        return ''

    def power_to(self, mode: Mode) -> None:
        """Bring the drives into a mode; each step up takes the vendor's time."""
        if mode is Mode.POWER_OFF:
            self._due_ns = NEVER_NS
            self._target = mode
            if self.mode is not mode:
                self.mode = mode
                self._halt_program()
                self._note('the drives are off', Cause('power', 'the drives were switched off'))
            return
        order = list(Mode)
        if order.index(mode) <= order.index(self.mode):
            if mode is Mode.IDLE and self.mode is Mode.RUNNING:
                self.mode = self._target = mode
                self._halt_program()
                self._note('the brakes are on', Cause('power', 'the brakes were applied'))
            return
        self._target = mode
        if self._due_ns == NEVER_NS:
            self._due_ns = self.time_ns + round(self.vendor.power_step * 1e9)
        if not self.vendor.power_step:
            while self.mode is not self._target:
                self._step_power()
        self._changed()

    def reset(self) -> None:
        """Be as at the start."""
        self._begin()
        self._changed()

    def _stop(self, safety: Safety, cause: Cause) -> None:
        self.safety, self.cause, self.since_ns = safety, cause, self.time_ns
        self._halt_program()
        self._note(f'{self.obstacle}; at {self.time_ns * 1e-9:.3f} s', level='error')

    def _halt_program(self) -> None:
        self.freedrive = self._ramps = False
        if self.vendor.program:
            self.program = Program.STOPPED

    def _step_power(self) -> None:
        order = list(Mode)
        self.mode = order[order.index(self.mode) + 1]
        more = self.mode is not self._target
        self._due_ns = self.time_ns + round(self.vendor.power_step * 1e9) if more else NEVER_NS
        if self.mode is Mode.RUNNING:
            self.cause = None
        self._note(f'the drives are {self.mode.value}')

    def _note(self, text: str, cause: Cause | None = None,
              level: Literal['info', 'error'] = 'info') -> None:
        if cause is not None:
            self.cause = cause
        self._events.add(self.time_ns, level, 'stop', text)
        self._changed()

    def _changed(self) -> None:
        self.changed = self.busy = True
        self.generation += 1
        self._wake()
