# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that print a line, and the loggers of launch files: those of Python."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

from armsim_ros.launch.api.context import Action, LaunchContext, LaunchDescriptionEntity, SomeText
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


def get_logger(name: str | None = None) -> logging.Logger:
    """Return a logger that prints as launch does."""
    logger = logging.getLogger(f'launch.{name}' if name else 'launch')
    if not logging.getLogger('launch').handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter('[%(levelname)s] [%(name)s]: %(message)s'))
        top = logging.getLogger('launch')
        top.addHandler(handler)
        top.setLevel(logging.INFO)
        top.propagate = False
    return logger


def get_output_loggers(process_name: str, output_config: Any) -> tuple[Any, Any]:
    """Return the loggers of a process's two streams."""
    return get_logger(f'{process_name}-stdout'), get_logger(f'{process_name}-stderr')


class launch_config:  # noqa: N801 - launch's own name
    """The settings of the logging."""

    level = logging.INFO
    log_dir = os.environ.get('ROS_LOG_DIR', str(Path.home() / '.ros' / 'log'))

    @classmethod
    def get_log_file_path(cls, file_name: str = 'launch.log') -> str:
        """Return the path of a log file."""
        return os.path.join(cls.log_dir, file_name)
