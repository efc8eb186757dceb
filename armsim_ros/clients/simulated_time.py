# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether simulated time passes, for clients that wait for something to happen."""

from __future__ import annotations

from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
import time
from typing import Any

from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import GetSimulationState
from std_srvs.srv import Trigger

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError

_STATE, _SYNC = '/get_simulation_state', '/simulation/sync'
#: A simulation that publishes /clock serves its state within this time [s].
_PATIENCE = 1.0
_PERIOD = 0.02
PAUSED = ('simulated time does not pass: the simulation is paused or in lockstep; '
          '/step_simulation advances it, /set_simulation_state (1 is playing) lets it run')


class SimulatedTime:
    """
    Reads from the simulation whether time passes; a robot without a simulation has its own time.

    :param client: the node.
    """

    def __init__(self, client: RosClient) -> None:
        self._client = client
        client.prepare(GetSimulationState, _STATE)
        client.prepare(Trigger, _SYNC)

    def paused(self) -> bool:
        """Return whether there is a simulation, and its time does not pass."""
        deadline = time.monotonic() + _PATIENCE
        while not self._client.serves(GetSimulationState, _STATE):
            if (not self._client.node.count_publishers('/clock')
                    or time.monotonic() > deadline):
                return False
            time.sleep(_PERIOD)
        answer = _answer(self._client.call(GetSimulationState, _STATE))
        return answer is not None and answer.state.state == SimulationState.STATE_PAUSED

    def publish_now(self) -> None:
        """Have the simulation publish joint states and time once, where time does not pass."""
        if self._client.serves(Trigger, _SYNC):
            _answer(self._client.call(Trigger, _SYNC))


def _answer(future: Future[Any]) -> Any:
    try:
        return future.result(_PATIENCE)
    except (ArmsimError, FutureTimeoutError, TimeoutError):
        return None
