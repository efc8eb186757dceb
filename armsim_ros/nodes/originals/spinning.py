# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The life of a small node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import signal
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


def spin(name: str, ros_args: Sequence[str], make: Callable[[Node], object], **options: Any
         ) -> int:
    """
    Run a node until SIGINT or SIGTERM.

    :param name: of the node where nothing renames it.
    :param make: adds what the node does; what it returns is kept.
    :returns: 0.
    """
    # A KeyboardInterrupt while a message is converted would end in a traceback.
    signals: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: signals.append(number))
    rclpy.init(args=[name, *ros_args])
    try:
        node = Node(name, **options)
        kept = make(node)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        if not signals:
            executor.spin()
        del kept
    except ExternalShutdownException:
        pass
    finally:
        rclpy.try_shutdown()
    return 0
