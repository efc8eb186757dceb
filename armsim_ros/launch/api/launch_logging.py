# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The loggers of launch files: Python's own."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any


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
