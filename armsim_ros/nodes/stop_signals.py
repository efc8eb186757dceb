# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM as a flag that a program reads when it can."""

from __future__ import annotations

from collections.abc import Callable
import signal
import socket
import threading

_NUMBERS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """
    SIGINT and SIGTERM as a flag that is read between the steps of the start.

    Python runs signal handlers in the main thread, once that comes back to the interpreter; one
    that waits for the middleware does not come back. So a separate thread passes the signal on.
    """

    def __init__(self) -> None:
        self.wanted = False
        self.on_stop: Callable[[], None] | None = None
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        for number in _NUMBERS:
            signal.signal(number, lambda *_: None)
        threading.Thread(target=self._wait, name='signals', daemon=True).start()

    def _wait(self) -> None:
        while signals := self._reader.recv(16):
            if set(signals) & set(_NUMBERS):
                self.wanted = True
                if self.on_stop is not None:
                    self.on_stop()
