# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The life of a small node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from armsim_ros.nodes.lean_executor import LeanExecutor
from armsim_ros.nodes.robot_program import StopSignals


def spin(name: str, ros_args: Sequence[str], make: Callable[[Node], object], **options: Any
         ) -> int:
    """
    Run a node until SIGINT or SIGTERM.

    :param name: of the node where nothing renames it.
    :param make: adds what the node does; what it returns is kept.
    :returns: 0.
    """
    # rclpy's own handlers would raise, or shut the context down, in the midst of anything.
    signals = StopSignals()
    rclpy.init(args=[name, *ros_args], signal_handler_options=SignalHandlerOptions.NO)
    node: Node | None = None
    try:
        node = Node(name, **options)
        kept = make(node)
        executor = LeanExecutor()
        executor.add_node(node)
        signals.on_stop = rclpy.try_shutdown
        if not signals.stop_requested:
            executor.spin()
        del kept
    except ExternalShutdownException:
        pass
    finally:
        # A participant that is left to the end of the process may wait there for seconds for a
        # listener whose thread is gone.
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
