# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while a script waits."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import threading

import rclpy
from rclpy.signals import (
    get_current_signal_handlers_options,
    install_signal_handlers,
    SignalHandlerOptions,
    uninstall_signal_handlers,
)


@contextmanager
def interruptible() -> Iterator[None]:
    """
    Have Ctrl-C raise KeyboardInterrupt inside before it ends the contexts of rclpy.

    The handlers that ``rclpy.init`` installs shut all contexts down at once, and what has to be
    cancelled could be cancelled no more. They are set aside meanwhile; the script's own context
    is shut down after the interrupt, as they do.
    """
    options = SignalHandlerOptions.NO
    if threading.current_thread() is threading.main_thread():
        options = get_current_signal_handlers_options()
    if options not in (SignalHandlerOptions.ALL, SignalHandlerOptions.SIGINT):
        yield
        return
    uninstall_signal_handlers()
    if options == SignalHandlerOptions.ALL:
        install_signal_handlers(SignalHandlerOptions.SIGTERM)
    try:
        yield
    except KeyboardInterrupt:
        rclpy.try_shutdown()
        raise
    finally:
        uninstall_signal_handlers()
        install_signal_handlers(options)
