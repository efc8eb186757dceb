# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The end of a program that the middleware does not let go of."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import faulthandler

import rclpy
from rclpy.node import Node

#: Time in which nodes are destroyed, however busy the machine is [s].
LONGEST_LEAVE = 30.0
STDERR = 2


@contextmanager
def leaving_graph(limit: float = LONGEST_LEAVE) -> Iterator[None]:
    """
    Destroy nodes within the context; a process in which this hangs ends with status 1.

    Fast DDS may wait for a callback that in turn waits for it, in a call that holds Python's
    lock: no thread of Python and no signal handler runs any more. The stacks of all threads go
    to stderr.

    :param limit: [s].
    """
    # sys.stderr may be no file, such as where pytest captures it.
    faulthandler.dump_traceback_later(limit, exit=True, file=STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def leave_graph(*nodes: Node) -> None:
    """Destroy the nodes of a program and shut rclpy down, see :func:`leaving_graph`."""
    with leaving_graph():
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
