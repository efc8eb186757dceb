# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shutdown of programs, also where the middleware blocks it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import faulthandler

import rclpy
from rclpy.node import Node

#: A shutdown that takes longer is blocked for good, however busy the machine is [s].
SHUTDOWN_LIMIT = 30.0
#: The file descriptor; ``sys.stderr`` may be something else, such as where pytest captures it.
STDERR = 2


@contextmanager
def bounded_shutdown(limit: float = SHUTDOWN_LIMIT) -> Iterator[None]:
    """
    End the process with status 1 where destroying nodes within the context takes too long.

    Fast DDS may wait for a callback that in turn waits for it, in a call that holds Python's
    global lock, so that neither threads nor signal handlers run any more (docs/errors.md). The
    stacks of all threads are printed to stderr. A timer that was set with ``faulthandler`` before
    is cancelled: it has only one.

    :param limit: time for the context [s].
    """
    faulthandler.dump_traceback_later(limit, exit=True, file=STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def shut_down(*nodes: Node) -> None:
    """Destroy the nodes of a program and shut down rclpy's default context, in bounded time."""
    with bounded_shutdown():
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
