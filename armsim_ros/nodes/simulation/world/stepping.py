# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``/step_simulation`` and the action ``/simulate_steps``."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
import time
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result
from simulation_interfaces.srv import StepSimulation

from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.world.answers import answered, refuse
from armsim_ros.nodes.simulation.world.simulation_state import RunState
from armsim_ros.nodes.simulation.world.work import Work

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

    :param node: the node that serves.
    :param work: reaches the loop.
    :param publish: hands over what belongs to the present time, /clock too; called between two
        ticks.
    :param settle: called after that; steps are answered when it is done.
    """

    def __init__(
        self, node: Node, work: Work, state: RunState, publish: Callable[[], object],
        settle: Callable[[], Awaitable[object]],
    ) -> None:
        self._work = work
        self._state = state
        self._publish, self._settle = publish, settle
        group = ReentrantCallbackGroup()
        node.create_service(StepSimulation, '/step_simulation', self._step,
                            callback_group=group)
        self._server = ActionServer(
            node,
            SimulateSteps,
            '/simulate_steps',
            execute_callback=self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=group,
            **qos.ACTION_SERVICES,
        )

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
