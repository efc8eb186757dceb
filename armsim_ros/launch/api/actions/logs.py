# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that print a line."""

from __future__ import annotations

from typing import Any

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.entity import Action, LaunchDescriptionEntity, SomeText
from armsim_ros.launch.api.utilities import (
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

Entities = list[LaunchDescriptionEntity]


class LogInfo(Action):
    """
    Prints a line.

    :param msg: the text.
    """

    level = 'INFO'

    def __init__(self, *, msg: SomeText, **kwargs: Any) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._msg = normalize_to_list_of_substitutions(msg)
        if isinstance(kwargs.get('level'), str):
            self.level = kwargs['level'].upper()

    def execute(self, context: LaunchContext) -> None:
        """Print it."""
        text = perform_substitutions(context, self._msg)
        if context.engine is not None:
            context.engine.log(self.level, text, 'launch.user')


class Log(LogInfo):
    """Logs a line at a level."""


class LogDebug(LogInfo):
    """Logs a line at debug level."""

    level = 'DEBUG'


class LogWarning(LogInfo):
    """Logs a warning."""

    level = 'WARNING'


class LogError(LogInfo):
    """Logs an error."""

    level = 'ERROR'
