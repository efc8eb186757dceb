# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Electrical inputs and outputs of an arm's cabinet and tool, and what they are wired to."""

from __future__ import annotations

from collections.abc import Callable, Mapping


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
