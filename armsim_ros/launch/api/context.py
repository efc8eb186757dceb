# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state of a running launch: configurations, environment, event handlers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
import os
from types import SimpleNamespace
from typing import Any, TYPE_CHECKING

from armsim_ros.launch.api.entity import Substitution
from armsim_ros.launch.failures import SubstitutionFailure

if TYPE_CHECKING:
    from armsim_ros.launch.engine import Engine


class LaunchContext:
    """
    The state that substitutions and actions read and write.

    :param argv: the words of the command line.
    :param engine: runs the launch; None while nothing runs.
    """

    def __init__(
        self, *, argv: Iterable[str] | None = None, noninteractive: bool = True,
        engine: Engine | None = None,
    ) -> None:
        self.argv = list(argv or ())
        self.noninteractive = noninteractive
        self.engine = engine
        self.launch_configurations: dict[str, Any] = {}
        self.environment: dict[str, str] = dict(os.environ)
        self.is_shutdown = False
        self.asyncio_loop = None
        self._globals: dict[str, Any] = {}
        self._locals: list[dict[str, Any]] = [{}]
        self._configurations: list[dict[str, Any]] = []
        self._environments: list[dict[str, str]] = []

    def perform_substitution(self, substitution: Substitution) -> str:
        """
        Return the text of a substitution.

        :raises SubstitutionFailure: where it has none; with the line that made it.
        """
        try:
            return substitution.perform(self)
        except SubstitutionFailure as failure:
            raise failure.at(substitution.where) from None

    # Configurations and environment, scoped by groups.

    def push_launch_configurations(self) -> None:
        """Begin a scope."""
        self._configurations.append(dict(self.launch_configurations))

    def pop_launch_configurations(self) -> None:
        """End a scope, restoring the configurations from before it."""
        self.launch_configurations = self._configurations.pop()

    def push_environment(self) -> None:
        """Begin a scope of the environment."""
        self._environments.append(dict(self.environment))

    def pop_environment(self) -> None:
        """End a scope of the environment."""
        self.environment = self._environments.pop()

    # Values by name, as event handlers and OpaqueFunctions use them.

    @property
    def locals(self) -> SimpleNamespace:
        """The values of the current scope."""
        return SimpleNamespace(**self.get_locals_as_dict())

    def get_locals_as_dict(self) -> dict[str, Any]:
        """Return the values of the current scope."""
        return {**self._globals, **self._locals[-1]}

    def extend_globals(self, extension: Mapping[str, Any]) -> None:
        """Add values for the rest of the launch."""
        self._globals.update(extension)

    def extend_locals(self, extension: Mapping[str, Any]) -> None:
        """Add values to the current scope."""
        self._locals[-1].update(extension)

    def push_locals(self) -> None:
        """Begin a scope of values that starts as a copy of its parent scope."""
        self._locals.append(dict(self._locals[-1]))

    def pop_locals(self) -> None:
        """End a scope of values."""
        self._locals.pop()

    # Events.

    def register_event_handler(self, handler: Any, append: bool = False) -> None:
        """Register a handler for events from now on."""
        if self.engine is not None:
            self.engine.capture_scope(handler)
            self.engine.handlers.insert(len(self.engine.handlers) if append else 0, handler)

    def unregister_event_handler(self, handler: Any) -> None:
        """Unregister a handler."""
        if self.engine is not None and handler in self.engine.handlers:
            self.engine.handlers.remove(handler)

    def emit_event_sync(self, event: Any) -> None:
        """Queue an event."""
        if self.engine is not None:
            self.engine.emit(event)

    async def emit_event(self, event: Any) -> None:
        """Queue an event."""
        self.emit_event_sync(event)

    @property
    def current_file(self) -> str:
        """The launch file that is being visited, '' if there is none."""
        return str(self.get_locals_as_dict().get('current_launch_file_path', ''))
