# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Logs each answer that the middleware could not deliver."""

from __future__ import annotations

from collections.abc import Iterator
import sys
from types import FrameType
from typing import Any, TextIO
import warnings

_LOST = 'failed to send response'


def log_lost_answers() -> None:
    """
    Log answers whose client does not receive, from now on.

    Fast DDS waits for the client's reader for the writer's ``max_blocking_time``. rclpy then
    raises a warning, of which Python prints the first alone.
    """
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], filename: str, lineno: int,
             file: TextIO | None = None, line: str | None = None) -> None:
        if not str(message).startswith(_LOST):
            shown(message, category, filename, lineno, file, line)
            return
        from rclpy.logging import get_logger

        names = (_name(frame) for frame in _frames(sys._getframe(1)))
        name = next(filter(None, names), 'an action')
        get_logger('lost_answers').warning(
            f"a client of '{name}' gets no answer: this process has not discovered the client's "
            'reader in time, or their QoS do not match')

    warnings.filterwarnings('always', _LOST, RuntimeWarning)
    warnings.showwarning = show


def _name(frame: FrameType) -> str:
    server: Any = frame.f_locals.get('self')
    return getattr(server, 'srv_name', '') or getattr(server, '_action_name', '')


def _frames(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back
