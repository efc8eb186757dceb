# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``/get_simulation_state``, ``/set_simulation_state`` and ``/step_simulation``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import GetSimulationState, SetSimulationState, StepSimulation

from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.sim.control_loop import ControlLoop

#: Steps of one request; a longer way is gone by playing.
MOST_STEPS = 10_000


class SimulationStateServices:
    """
    Pause, play, single steps and the end, by the standard's interfaces.

    :param node: the node that serves.
    :param quit_program: ends the program.
    """

    def __init__(
        self,
        node: Node,
        loop: ControlLoop,
        dispatcher: Dispatcher,
        quit_program: Callable[[], None],
    ) -> None:
        """Make the services."""
        self._node = node
        self._loop = loop
        self._dispatcher = dispatcher
        self._quit = quit_program
        group = ReentrantCallbackGroup()
        for name, kind, answer in (
            ('/get_simulation_state', GetSimulationState, self._get),
            ('/set_simulation_state', SetSimulationState, self._set),
            ('/step_simulation', StepSimulation, self._step),
        ):
            node.create_service(
                kind, name, answer, qos_profile=qos.SERVICES, callback_group=group
            )

    def _get(self, _: Any, response: Any) -> Any:
        paused = self._loop.clock.paused
        response.state.state = (
            SimulationState.STATE_PAUSED if paused else SimulationState.STATE_PLAYING
        )
        response.result.result = Result.RESULT_OK
        return response

    def _set(self, request: Any, response: Any) -> Any:
        wanted, clock = request.state.state, self._loop.clock
        if wanted in (SimulationState.STATE_PLAYING, SimulationState.STATE_PAUSED):
            paused = wanted == SimulationState.STATE_PAUSED
            if clock.paused is paused:
                response.result.result = SetSimulationState.Response.ALREADY_IN_TARGET_STATE
                response.result.error_message = 'it is in this state already'
                return response
            clock.paused = paused
            self._node.get_logger().info('paused' if paused else 'playing')
        elif wanted == SimulationState.STATE_QUITTING:
            self._dispatcher.post_later(0.1, self._quit)  # the answer goes out first
        else:
            response.result.result = Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = (
                f'state {wanted} is not supported; allowed: playing (1), paused (2), quitting (3)'
            )
            return response
        response.result.result = Result.RESULT_OK
        return response

    async def _step(self, request: Any, response: Any) -> Any:
        if not self._loop.clock.paused or not 0 < request.steps <= MOST_STEPS:
            response.result.result = Result.RESULT_INCORRECT_STATE
            response.result.error_message = (
                f'only a paused simulation can be stepped, by 1 to {MOST_STEPS} steps'
            )
            return response
        done = Future()
        self._loop.call(lambda: self._advance(request.steps)).add_done_callback(
            lambda _: self._dispatcher.post(lambda: self._resume(done))
        )
        await done
        response.result.result = Result.RESULT_OK
        return response

    def _advance(self, steps: int) -> None:
        for _ in range(steps):
            self._loop.advance()

    def _resume(self, done: Future) -> None:
        done.set_result(None)
        self._node.executor.wake()
