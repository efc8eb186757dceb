# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``/get_simulation_state`` and ``/set_simulation_state``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import (
    GetSimulationState,
    ResetSimulation,
    SetSimulationState,
)

from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import answered, refuse
from armsim_ros.nodes.simulation.world.resetting import Resetting
from armsim_ros.nodes.simulation.world.run_state import RunState

_STOPPED, _PLAYING = SimulationState.STATE_STOPPED, SimulationState.STATE_PLAYING
_PAUSED, _QUITTING = SimulationState.STATE_PAUSED, SimulationState.STATE_QUITTING
_WORDS = {_STOPPED: 'stopped', _PLAYING: 'playing', _PAUSED: 'paused'}


class SimulationStateServices:
    """
    Pause, play, stop and quit.

    :param node: the node that serves.
    :param resetting: takes everything to the start for a stop.
    :param quit_program: ends the program.
    """

    def __init__(
        self,
        node: Node,
        state: RunState,
        resetting: Resetting,
        dispatcher: Dispatcher,
        quit_program: Callable[[], None],
    ) -> None:
        self._node = node
        self._state = state
        self._resetting = resetting
        self._dispatcher = dispatcher
        self._quit = quit_program
        group = ReentrantCallbackGroup()
        for name, kind, answer in (
            ('/get_simulation_state', GetSimulationState, self._get),
            ('/set_simulation_state', SetSimulationState, self._set),
        ):
            node.create_service(kind, name, answer, callback_group=group)

    @answered
    async def _get(self, _: Any, response: Any) -> None:
        response.state.state = self._state.now

    @answered
    async def _set(self, request: Any, response: Any) -> None:
        wanted, kinds = request.state.state, SetSimulationState.Response
        if wanted == _QUITTING:
            self._dispatcher.post_later(0.1, self._quit)  # the answer goes out first
            return
        if wanted not in _WORDS:
            refuse(response.result, kinds.INCORRECT_TRANSITION,
                   f'state {wanted} cannot be asked for; allowed: stopped (0), playing (1), '
                   'paused (2), quitting (3); load_world and unload_world change the world')
            return
        if self._state.now not in _WORDS:
            refuse(response.result, kinds.INCORRECT_TRANSITION,
                   f'no world is loaded, so nothing can be {_WORDS[wanted]}; call load_world')
            return
        if self._state.now == wanted:
            refuse(response.result, kinds.ALREADY_IN_TARGET_STATE,
                   f'it is {_WORDS[wanted]} already')
            return
        if wanted == _STOPPED:
            scopes = ResetSimulation.Request
            await self._resetting.reset(scopes.SCOPE_STATE | scopes.SCOPE_SPAWNED, stop=True)
        elif wanted == _PLAYING:
            self._state.play()
        else:
            self._state.pause()
        self._node.get_logger().info(_WORDS[wanted])
