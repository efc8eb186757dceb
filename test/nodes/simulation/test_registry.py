# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When and where the endpoints of controllers are created."""

import threading
from types import SimpleNamespace

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from armsim_ros.control.controller import LifecycleState
from armsim_ros.nodes.simulation.controllers.controller_nodes import ControllerNode
from armsim_ros.nodes.simulation.controllers.registry import ControllerRegistry


class Recorder(ControllerNode):
    """A controller's node that notes in which threads its endpoints are created."""

    def __init__(self):
        super().__init__(SimpleNamespace(state=LifecycleState.INACTIVE, name='arm'), None, None)
        self.threads = []

    def _open(self, node):
        self.threads.append(threading.get_ident())


@pytest.fixture(name='executor')
def _executor():
    """Return an executor that only the test spins."""
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    executor = SingleThreadedExecutor(context=context)
    yield executor
    executor.shutdown()
    context.shutdown()


def test_endpoints_are_created_once_in_the_executors_thread(executor):
    """
    A thread that finds a controller without endpoints leaves them to the executor's thread.

    A spawner configures the controller there at the same time; were both to create them, the
    controller would have two action servers, which preempt each other's goals.
    """
    registry = ControllerRegistry(None, None, executor, None, '/', None)
    side = Recorder()
    registry._sides = {'arm': side}
    finder = threading.Thread(target=registry.open_due_soon)
    finder.start()
    finder.join()
    assert not side.opened
    registry.open_due()
    executor.spin_once(1.0)
    assert side.threads == [threading.get_ident()]
