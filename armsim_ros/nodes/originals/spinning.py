# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The life of a small node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    rclpy.init(args=[name, *ros_args])
    node = Node(name, **options)
    try:
        kept = make(node)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        executor.spin()
        del kept
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
    return 0
