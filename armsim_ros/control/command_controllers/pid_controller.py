# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The PID controller: closes a loop around each degree of freedom.

``receive``, ``measure``, ``set_feedforward`` and ``snapshot`` may be called from any thread; all
else belongs to the control loop.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any, ClassVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.pid_controller import PidControllerParameters
from armsim_ros.control.command_controllers.chainable_controller import (
    ChainableController,
    NamedValues,
)
from armsim_ros.control.command_writer import CommandTargets, Pid
from armsim_ros.errors import ControllerError


@dataclass(frozen=True, slots=True, eq=False)
class PidSnapshot:
    """
    What the controller did in an update [ns].

    :param reference: (k, n) of the one or two interfaces; ``feedback`` likewise.
    :param error: (2, n) of the first interface, and its derivative.
    :param output: (n,) what was commanded.
    :param integral: (n,) its integral parts.
    :param period: since the update before [s].
    """

    time_ns: int
    names: tuple[str, ...]
    reference: Matrix
    feedback: Matrix
    error: Matrix
    output: Vector
    integral: Vector
    period: float


class PidController(ChainableController[PidControllerParameters]):
    """``pid_controller/PidController``."""

    parameters_class: ClassVar[type[Settings]] = PidControllerParameters

    _pids: tuple[Pid, ...] = ()
    _snapshot: PidSnapshot | None = None
    _feedforward = False

    @property
    def joints(self) -> tuple[str, ...]:
        """What is commanded."""
        return self.parameters.dof_names

    @property
    def references(self) -> tuple[tuple[str, str], ...]:
        """Each interface of each degree of freedom, interface by interface."""
        kinds = self.parameters.reference_and_state_interfaces
        return tuple((name, kind) for kind in kinds for name in self.parameters.measured)

    @property
    def exported_states(self) -> tuple[str, ...]:
        """What is measured, with the controller's name."""
        return self.reference_interfaces

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """The interface of each degree of freedom."""
        return tuple(f'{name}/{self.parameters.command_interface}' for name in self.joints)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """What is measured, unless it comes from a topic."""
        if self.parameters.use_external_measured_states:
            return ()
        return tuple('/'.join(pair) for pair in self.references)

    def configure(self) -> None:
        """Look whether everything is named that is needed."""
        if self.parameters.missing:
            raise ControllerError(
                f"parameter '{self.parameters.missing}' of '{self.name}' is missing")
        parameters = self.parameters
        self._shape = (len(parameters.reference_and_state_interfaces), len(parameters.measured))
        self._values = NamedValues(parameters.measured, self._shape[0])
        self._pids = tuple(Pid(parameters.gains[name]) for name in parameters.dof_names)
        self._feedforward = parameters.enable_feedforward
        given = self.context.hardware.given_states
        given.update(dict.fromkeys(self.exported_states, math.nan))

    def begin(self, time_ns: int) -> Vector:
        """Take the joints over; hold what is measured, where that is asked for."""
        targets = [(name, self.parameters.command_interface) for name in self.joints]
        self._output = CommandTargets(targets, self.context.hardware)
        self._output.take_over()
        for name, pid in zip(self.joints, self._pids, strict=True):
            if not self.parameters.gains[name].save_i_term:
                pid.reset()
        self._measured: Vector = np.full(self._shape[0] * self._shape[1], np.nan)
        self._last_error = np.full(self._shape[1], np.nan)
        self._snapshot = None
        if self.parameters.set_current_state_as_first_setpoint:
            first = self._feedback().copy()
            first[1:] = 0.0
            return np.asarray(first.ravel())
        return np.full(self._shape[0] * self._shape[1], np.nan)

    def deactivate(self, time_ns: int) -> None:
        """Stop velocities and efforts; positions stay."""
        self._output.stop()

    def receive(self, names: Sequence[str], values: Sequence[float],
                derivatives: Sequence[float]) -> str:
        """
        Take references from the topic.

        :param names: of the degrees of freedom, in any order; empty is all in their order.
        :param values: a value per name, NaN for a value that stays as it is.
        :param derivatives: of the first names, of no use to a single interface.
        :returns: why they were dropped, '' where they were taken.
        """
        if self._shape[0] == 1:
            derivatives = ()
        elif len(derivatives) < len(values):
            lacking = len(values) - len(derivatives)
            derivatives = (*derivatives, *[math.nan] * lacking)
        found = self._values.sorted(names, values, derivatives)
        return self.drop(found) if isinstance(found, str) else self.offer(found)

    def measure(self, names: Sequence[str], values: Sequence[float],
                derivatives: Sequence[float]) -> str:
        """
        Take measured states, as :meth:`receive` takes references.

        :param derivatives: a value per name, or empty; always empty for a single interface.
        """
        found = self._values.sorted(names, values, derivatives)
        if isinstance(found, str):
            return self.drop(found)
        self._measured = found
        return ''

    def set_feedforward(self, requested: bool) -> None:
        """Add the references' own part to the commands, or not, until a parameter changes."""
        self._feedforward = requested

    def snapshot(self) -> PidSnapshot | None:
        """Return what the last update did, None before the first."""
        return self._snapshot

    def set_parameters(self, changes: Settings | Mapping[str, Any]) -> None:
        """
        Take parameters over; new gains leave the integral parts as they are.

        As upstream, any change sets the feed-forward to its parameter.
        """
        super().set_parameters(changes)
        self._feedforward = self.parameters.enable_feedforward
        for name, pid in zip(self.joints, self._pids, strict=False):
            pid.set_gains(self.parameters.gains[name])

    def follow(self, references: Vector, time_ns: int, period: float) -> None:
        """Close the loops; a degree of freedom without reference or state is not commanded."""
        requested, feedback = references.reshape(self._shape), self._feedback()
        given = self.context.hardware.given_states
        given.update(zip(self.exported_states, feedback.ravel().tolist(), strict=True))
        error = np.zeros((2, self._shape[1]))
        error[0] = requested[0] - feedback[0]
        gains = [self.parameters.gains[name] for name in self.joints]
        for i, gain in enumerate(gains):
            if gain.angle_wraparound and math.isfinite(error[0, i]):
                error[0, i] = math.remainder(error[0, i], math.tau)
        change = (error[0] - self._last_error) / period if period > 0.0 else error[1]
        if self._shape[0] == 2:
            known = requested[1] - feedback[1]
            change = np.where(np.isfinite(known), known, change)
        error[1] = np.where(np.isfinite(change), change, 0.0)
        self._last_error = error[0].copy()
        output = np.array([pid.compute(error[0, i], error[1, i], period)
                           for i, pid in enumerate(self._pids)])
        if self._feedforward:
            own = requested[-1] * np.array([gain.feedforward_gain for gain in gains])
            output += np.where(np.isfinite(own), own, 0.0)
        self._snapshot = PidSnapshot(
            time_ns, self.parameters.measured, requested.copy(), feedback.copy(), error, output,
            np.array([pid.integral for pid in self._pids]), period)
        self._output.write(output)

    def _feedback(self) -> Matrix:
        """Return what is measured (k, n), NaN where nothing has come."""
        if self.parameters.use_external_measured_states:
            return self._measured.reshape(self._shape)
        return self.context.hardware.read_states(
            self.required_state_interfaces).reshape(self._shape)
