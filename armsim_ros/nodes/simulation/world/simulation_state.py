# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the simulation is playing, and the services that change it or reset all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import (
    GetSimulationState,
    ResetSimulation,
    SetSimulationState,
)
from std_srvs.srv import Empty

from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import answered, refuse
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.world.entities import Entities


class RunState:
    """
    The state of the simulation in the words of simulation_interfaces.

    :param clock: knows whether time passes.
    :param world: name of the world that is loaded.
    :param uri: where it can be loaded from.
    """

    def __init__(self, clock: SimClock, world: str, uri: str) -> None:
        self.world: str | None = world
        self.uri = uri
        self.loading = False
        self._clock = clock
        self._stopped_at: int | None = None

    @property
    def now(self) -> int:
        """A constant of ``simulation_interfaces/msg/SimulationState``."""
        if self.loading:
            return int(SimulationState.STATE_LOADING_WORLD)
        if self.world is None:
            return int(SimulationState.STATE_NO_WORLD)
        if not self._clock.paused:
            return int(SimulationState.STATE_PLAYING)
        if self._stopped_at == self._clock.steps:
            return int(SimulationState.STATE_STOPPED)
        return int(SimulationState.STATE_PAUSED)

    def stop(self) -> None:
        """Record that everything is at its start; a step ends that. Pauses the clock."""
        self._clock.paused = True
        self._stopped_at = self._clock.steps

    def pause(self) -> None:
        """Pause time."""
        self._clock.paused = True
        self._stopped_at = None

    def play(self) -> None:
        """Resume time."""
        self._stopped_at = None
        self._clock.paused = False


_TIME = ResetSimulation.Request.SCOPE_TIME
_STATE = ResetSimulation.Request.SCOPE_STATE
_SPAWNED = ResetSimulation.Request.SCOPE_SPAWNED
_ALL = ResetSimulation.Request.SCOPE_ALL
_KNOWN = _TIME | _STATE | _SPAWNED
#: The message for clients that wait for a goal.
REASON = 'the simulation was reset'
NO_TIME = ('time is not reset: programs that follow /clock take no step back; stop and start '
           'the simulation for a new time, or run it with mode:=lockstep')


class Resetting:
    """
    Takes robots and world back to the start while everything runs.

    :param node: the node that serves.
    :param work: makes changes beside the loop.
    :param resets_time: whether it can begin at 0 again.
    """

    def __init__(
        self, node: Node, work: Work, entities: Entities, state: RunState, *, resets_time: bool
    ) -> None:
        self._node = node
        self._work = work
        self._entities = entities
        self._state = state
        self._resets_time = resets_time
        self.followers: list[Callable[[], object]] = []
        """Called in the loop's thread after each reset."""
        group = ReentrantCallbackGroup()
        node.create_service(ResetSimulation, '/reset_simulation', self._reset,
                            callback_group=group)
        for name, answer in (
            ('/gazebo/pause_physics', self._pause),
            ('/gazebo/unpause_physics', self._unpause),
            ('/gazebo/reset_world', self._reset_world),
            ('/gazebo/reset_simulation', self._reset_simulation),
        ):
            node.create_service(Empty, name, answer, callback_group=group)

    async def reset(self, scope: int, *, stop: bool = False) -> None:
        """
        Reset states, what was spawned, or time.

        :param scope: a sum of SCOPE_STATE, SCOPE_SPAWNED and, where time can be reset, SCOPE_TIME.
        :param stop: whether time is paused then.
        """
        def change() -> None:
            edit = (self._entities.stage_delete(self._entities.spawned)
                    if scope & _SPAWNED and self._entities.spawned else None)

            def between_ticks() -> None:
                if edit is not None:
                    self._entities.delete(edit)
                if scope & (_STATE | _TIME):
                    self._work.loop.restart(
                        REASON, states=bool(scope & _STATE), time=bool(scope & _TIME))
                if stop:
                    self._state.stop()
                for follow in self.followers:
                    follow()

            self._work.wait_for_loop(between_ticks)

        await self._work.beside(change)
        names = ((_TIME, 'time'), (_STATE, 'states'), (_SPAWNED, 'spawned entities'))
        what = [word for bit, word in names if scope & bit]
        self._node.get_logger().info(f'reset: {" and ".join(what)}')

    @answered
    async def _reset(self, request: Any, response: Any) -> None:
        scope = _KNOWN if request.scope in (0, _ALL) else request.scope
        if scope & ~_KNOWN:
            refuse(response.result, Result.RESULT_FEATURE_UNSUPPORTED,
                   f'scope {request.scope} is not known; allowed: a sum of TIME (1), STATE (2), '
                   'SPAWNED (4), or ALL (255)')
            return
        if scope & _TIME and not self._resets_time:
            if scope == _TIME:
                refuse(response.result, Result.RESULT_FEATURE_UNSUPPORTED, NO_TIME)
                return
            response.result.error_message = NO_TIME
            scope -= _TIME
        await self.reset(scope)

    async def _pause(self, _: Any, response: Any) -> Any:
        if self._state.world is not None:
            self._state.pause()
            self._node.get_logger().info('paused')
        return response

    async def _unpause(self, _: Any, response: Any) -> Any:
        if self._state.world is None:
            self._node.get_logger().error('no world is loaded, so nothing can play')
        else:
            self._state.play()
            self._node.get_logger().info('playing')
        return response

    async def _reset_world(self, _: Any, response: Any) -> Any:
        await self._logged(_STATE)
        return response

    async def _reset_simulation(self, _: Any, response: Any) -> Any:
        await self._logged(_STATE | _SPAWNED)
        return response

    async def _logged(self, scope: int) -> None:
        try:
            await self.reset(scope)
        except SimulationError as error:
            self._node.get_logger().error(f'nothing was reset: {error}')


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
        requested, kinds = request.state.state, SetSimulationState.Response
        if requested == _QUITTING:
            self._dispatcher.post_later(0.1, self._quit)  # the answer goes out first
            return
        if requested not in _WORDS:
            refuse(response.result, kinds.INCORRECT_TRANSITION,
                   f'state {requested} cannot be requested; allowed: stopped (0), playing (1), '
                   'paused (2), quitting (3); load_world and unload_world change the world')
            return
        if self._state.now not in _WORDS:
            refuse(response.result, kinds.INCORRECT_TRANSITION,
                   f'no world is loaded, so nothing can be {_WORDS[requested]}; call load_world')
            return
        if self._state.now == requested:
            refuse(response.result, kinds.ALREADY_IN_TARGET_STATE,
                   f'it is {_WORDS[requested]} already')
            return
        if requested == _STOPPED:
            scopes = ResetSimulation.Request
            await self._resetting.reset(scopes.SCOPE_STATE | scopes.SCOPE_SPAWNED, stop=True)
        elif requested == _PLAYING:
            self._state.play()
        else:
            self._state.pause()
        self._node.get_logger().info(_WORDS[requested])
