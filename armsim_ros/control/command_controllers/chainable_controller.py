# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base of controllers whose references come from a topic, or from a preceding controller."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.control.controller import Controller, ParametersT
from armsim_ros.control.mailbox import Mailbox, RepeatedWarning, STREAM_CAPACITY
from armsim_ros.errors import nearest


class NamedValues:
    """
    Brings values and their derivatives into a fixed order.

    :param names: (n,) in that order.
    :param rows: 1 for values alone, 2 for their derivatives too.
    """

    def __init__(self, names: Sequence[str], rows: int) -> None:
        self._names = tuple(names)
        self._rows = rows

    def sorted(
        self, names: Sequence[str], values: Sequence[float], derivatives: Sequence[float]
    ) -> Vector | str:
        """
        Return values and derivatives (rows * n,), NaN for those that are not given.

        :param names: those that are given; empty is all.
        :returns: in words what is wrong, where something is.
        """
        given = tuple(names) or self._names
        expected = f'; expected a value for each of {", ".join(self._names)}'
        if len(given) != len(set(given)):
            return f'a name comes twice among {", ".join(given)}'
        for name in given:
            if name not in self._names:
                hint = nearest(name, self._names)
                return f"'{name}' is not controlled{'; ' if hint else expected}{hint}"
        if len(values) != len(given):
            return f'{len(values)} values for {len(given)} names{expected}'
        if len(derivatives) and self._rows < 2:
            return 'derivatives are given, but none are controlled'
        if len(derivatives) not in (0, len(given)):
            return f'{len(derivatives)} derivatives for {len(given)} names'
        found = np.full((self._rows, len(self._names)), np.nan)
        places = [self._names.index(name) for name in given]
        found[0, places] = values
        if len(derivatives):
            found[1, places] = derivatives
        if np.isinf(found).any() or not np.isfinite(found).any():
            return f'values {list(values)} {list(derivatives)}'.rstrip(' []') + expected
        return np.asarray(found.ravel())


class ChainableController(Controller[ParametersT]):
    """
    Exports its references; what comes from the topic counts only while no controller writes them.

    ``offer`` may be called from any thread; all else belongs to the control loop.
    """

    chainable: ClassVar[bool] = True

    @property
    @abstractmethod
    def references(self) -> tuple[tuple[str, str], ...]:
        """(joint, interface) of each reference."""

    @abstractmethod
    def begin(self, time_ns: int) -> Vector:
        """Take the joints over; return the references (m,) to begin with, NaN for none."""

    @abstractmethod
    def follow(self, references: Vector, time_ns: int, period: float) -> None:
        """
        Make an update with references.

        :param references: (m,) in effect, NaN where none was given yet.
        """

    @property
    def reference_interfaces(self) -> tuple[str, ...]:
        """The references, with the controller's name."""
        return tuple(f'{self.name}/{joint}/{kind}' for joint, kind in self.references)

    def activate(self, time_ns: int) -> None:
        """Take the joints over and forget what came before."""
        self.time_ns = time_ns
        self._inbox: Mailbox[Vector] = Mailbox(self.context.wake, capacity=STREAM_CAPACITY)
        self._wanted = self.begin(time_ns)
        self._warning = RepeatedWarning(self.events)
        self.context.hardware.references.update(
            dict.fromkeys(self.reference_interfaces, float('nan')))

    def update(self, time_ns: int, period: float) -> None:
        """Take the newest references up and follow them."""
        self.time_ns = time_ns
        if self.chained:
            written = self.context.hardware.references
            given = [np.array([written[name] for name in self.reference_interfaces])]
        else:
            given = self._inbox.take_all()
        for coming in given:  # what was not given stays as it was
            self._wanted = np.where(np.isfinite(coming), coming, self._wanted)
        self.follow(self._wanted, time_ns, period)

    def offer(self, references: Vector) -> str:
        """
        Take references from the topic; while chained or inactive they are dropped.

        :param references: (m,), NaN for those that stay as they are.
        :returns: why they were dropped, '' where they were taken.
        """
        if not self.active:
            return 'the controller is not active'
        if self.chained:
            return self.drop('another controller writes the references')
        if obstacle := self.obstacle:
            return self.drop(obstacle)
        self._inbox.post(references)
        return ''

    def drop(self, reason: str) -> str:
        """Warn, now and then, of references that are not followed."""
        if self.active:
            self._warning.add(self.time_ns, f'reference dropped: {reason}')
        return reason
