# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The life of a program with a single node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from armsim_ros.nodes.robot_program import StopSignals
from armsim_ros.nodes.shutdown import shut_down
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor


def spin(name: str, ros_args: Sequence[str], make: Callable[[Node], object], **options: Any
         ) -> int:
    """
    Run a node until SIGINT, SIGTERM or the end of rclpy's context.

    :param name: of the node where nothing renames it.
    :param make: adds what the node does; what it returns is kept.
    :returns: 0.
    """
    # rclpy's own handlers would raise, or shut the context down, in the midst of anything.
    signals = StopSignals()
    rclpy.init(args=[name, *ros_args], signal_handler_options=SignalHandlerOptions.NO)
    nodes: list[Node] = []
    try:
        node = Node(name, **options)
        nodes.append(node)
        kept = make(node)
        with WaitSetExecutor() as executor:
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
        shut_down(*nodes)
    return 0
