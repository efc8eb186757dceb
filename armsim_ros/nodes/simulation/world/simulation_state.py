# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the simulation is playing, and the services that change it, reset all, or step."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
import time
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Resource, Result, SimulationState
from simulation_interfaces.srv import (
    GetSimulationState,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
)
from std_srvs.srv import Empty

from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import answered, refuse, RefusedError, Work
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.world.entities import Entities


class RunState:
    """
    The state of the simulation in the words of simulation_interfaces.

    :param world: name of the world that is loaded.
    :param resource: what it is loaded from.
    """

    def __init__(self, clock: SimClock, world: str, resource: Resource) -> None:
        self.world: str | None = world
        self.resource = resource
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
#: What ALL has besides: deleted objects and the infos of entities.
_REST = _ALL & ~_KNOWN
#: The message for clients that wait for a goal.
REASON = 'the simulation was reset'
NO_TIME = ('time is not reset: programs that follow /clock take no step back; stop and start '
           'the simulation for a new time, or run it with mode:=lockstep')


class Resetting:
    """
    Takes robots and world back to the start while everything runs.

    :param resets_time: whether it can begin at 0 again.
    """

    def __init__(
        self, node: Node, work: Work, entities: Entities, state: RunState, *, resets_time: bool
    ) -> None:
        self._node, self._work, self._entities, self._state = node, work, entities, state
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

    async def stop(self) -> None:
        """Reset all that can be reset, and pause time."""
        await self._run(self._possible(_ALL), stop=True)

    def _possible(self, scope: int) -> int:
        """Return a scope without time where that cannot be reset."""
        return scope if self._resets_time else scope & ~_TIME

    async def _run(self, scope: int, *, stop: bool = False) -> None:
        """
        Reset states, what was spawned, or time.

        :param scope: of SCOPE_ALL, what can be reset.
        :param stop: whether time is paused then.
        """
        def change() -> None:
            whole = bool(scope & _REST)
            edit = self._entities.stage_reset(whole=whole) if scope & _SPAWNED else None

            def between_ticks() -> None:
                if edit is not None:
                    self._entities.commit(edit)
                if whole:
                    self._entities.forget_infos()
                if scope & (_STATE | _TIME):
                    self._work.loop.restart(
                        REASON, states=bool(scope & _STATE), time=bool(scope & _TIME))
                if stop:
                    self._state.stop()
                for follow in self.followers:
                    follow()

            self._work.wait_for_loop(between_ticks)

        await self._work.beside(change)
        names = ((_TIME, 'time'), (_STATE, 'states'), (_SPAWNED, 'spawned entities'),
                 (_REST, 'deleted entities'))
        what = [word for bit, word in names if scope & bit]
        self._node.get_logger().info(f'reset: {" and ".join(what)}')

    @answered
    async def _reset(self, request: Any, response: Any) -> None:
        scope = request.scope or _ALL
        if scope != _ALL and scope & ~_KNOWN:
            raise RefusedError(
                Result.RESULT_FEATURE_UNSUPPORTED, f'scope {request.scope} is not known; allowed: '
                'a sum of TIME (1), STATE (2), SPAWNED (4), or ALL (255)')
        possible = self._possible(scope)
        if possible != scope:
            if not possible:
                raise RefusedError(Result.RESULT_FEATURE_UNSUPPORTED, NO_TIME)
            response.result.error_message = NO_TIME
        await self._run(possible)

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
            await self._run(scope)
        except SimulationError as error:
            self._node.get_logger().error(f'nothing was reset: {error}')


_STOPPED, _PLAYING = SimulationState.STATE_STOPPED, SimulationState.STATE_PLAYING
_PAUSED, _QUITTING = SimulationState.STATE_PAUSED, SimulationState.STATE_QUITTING
_WORDS = {_STOPPED: 'stopped', _PLAYING: 'playing', _PAUSED: 'paused'}


class SimulationStateServices:
    """Pause, play, stop and quit."""

    def __init__(
        self, node: Node, state: RunState, resetting: Resetting, dispatcher: Dispatcher,
        quit_program: Callable[[], None]
    ) -> None:
        self._node, self._state, self._resetting = node, state, resetting
        self._dispatcher, self._quit = dispatcher, quit_program
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
            raise RefusedError(
                kinds.INCORRECT_TRANSITION, f'state {requested} cannot be requested; allowed: '
                'stopped (0), playing (1), paused (2), quitting (3); load_world and unload_world '
                'change the world')
        if self._state.now not in _WORDS:
            raise RefusedError(kinds.INCORRECT_TRANSITION, 'no world is loaded, so nothing can be '
                               f'{_WORDS[requested]}; call load_world')
        if self._state.now == requested:
            raise RefusedError(
                kinds.ALREADY_IN_TARGET_STATE, f'it is {_WORDS[requested]} already')
        if requested == _STOPPED:
            await self._resetting.stop()
        elif requested == _PLAYING:
            self._state.play()
        else:
            self._state.pause()
        self._node.get_logger().info(_WORDS[requested])


#: The most steps of a request.
MOST_STEPS = 10**9
#: Wall time of the steps that are done without a pause [s]; a cancel waits this long.
_GO = 0.008
#: Steps of the first go, and the most of any; observers of the loop wait as long.
_FIRST, _LARGEST = 10, 2000
#: Wall time between two pieces of feedback [s].
_FEEDBACK_PERIOD = 0.02


class Stepping:
    """
    Steps the paused simulation by whole steps of the physics.

    :param publish: hands over what belongs to the present time, /clock too; called between two
        ticks.
    :param settle: called after that; steps are answered when it is done.
    """

    def __init__(
        self, node: Node, work: Work, state: RunState, publish: Callable[[], object],
        settle: Callable[[], Awaitable[object]],
    ) -> None:
        self._work, self._state = work, state
        self._publish, self._settle = publish, settle
        group = ReentrantCallbackGroup()
        node.create_service(StepSimulation, '/step_simulation', self._step, callback_group=group)
        self._server = ActionServer(
            node, SimulateSteps, '/simulate_steps', execute_callback=self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT, callback_group=group,
            **qos.ACTION_SERVICES)

    @answered
    async def _step(self, request: Any, response: Any) -> None:
        await self._run(request.steps, response.result, lambda done: True)

    async def _execute(self, handle: Any) -> Any:
        outcome, steps = SimulateSteps.Result(), handle.request.steps
        outcome.result.result = Result.RESULT_OK
        reported = [0.0]

        def go_on(done: int) -> bool:
            now = time.monotonic()
            if done == steps or now - reported[0] >= _FEEDBACK_PERIOD:
                reported[0] = now
                handle.publish_feedback(SimulateSteps.Feedback(
                    completed_steps=done, remaining_steps=steps - done))
            return not handle.is_cancel_requested

        done = await self._run(steps, outcome.result, go_on)
        if outcome.result.result != Result.RESULT_OK:
            handle.abort()
        elif done < steps:
            refuse(outcome.result, Result.RESULT_OPERATION_FAILED,
                   f'canceled after {done} of {steps} steps')
            handle.canceled()
        else:
            handle.succeed()
        return outcome

    async def _run(self, steps: int, result: Result, go_on: Callable[[int], bool]) -> int:
        """Do the steps as far as possible; return how many, with the reason in ``result``."""
        done, size = 0, _FIRST
        if not 0 < steps <= MOST_STEPS:
            refuse(result, Result.RESULT_OPERATION_FAILED,
                   f'{steps} steps cannot be done; allowed: 1 to {MOST_STEPS}')
            return 0
        while True:
            count = min(size, steps - done)
            moved, stable, wall = await self._work.in_loop(partial(self._advance, count))
            done += moved
            if not stable:
                refuse(result, Result.RESULT_OPERATION_FAILED,
                       f'the physics became unstable in step {done} of {steps}; the '
                       "simulation's log has the place")
                break
            if moved < count:
                refuse(result, Result.RESULT_OPERATION_FAILED,
                       'the simulation plays; pause it, then it can be stepped'
                       + (f' ({done} steps were done before)' if done else ''))
                break
            if not go_on(done) or done == steps:
                break
            size = int(min(max(count * _GO / max(wall, 1e-6), 1), 4 * count, _LARGEST))
        if done:
            await self._work.in_loop(self._publish)
            await self._settle()
        return done

    def _advance(self, steps: int) -> tuple[int, bool, float]:
        """Do steps; return how many, whether all were stable, and the wall time [s]."""
        clock = self._work.loop.clock
        if not clock.paused:
            return 0, True, 0.0
        begin, wall = clock.steps, time.monotonic()
        stable = self._work.loop.advance(steps)
        return clock.steps - begin, stable, time.monotonic() - wall
