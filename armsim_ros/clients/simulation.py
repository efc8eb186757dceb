# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A typed client of a simulator that offers ``simulation_interfaces``, as ours does."""

from __future__ import annotations

from typing import Any

from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntityState,
    LoadWorld,
    ResetSimulation,
    SetSimulationState,
    SpawnEntity,
    StepSimulation,
)

from armsim_ros.arrays import Matrix
from armsim_ros.clients.controller_manager import Caller
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.conversions.geometry import pose_from_message, pose_to_message

#: What a reset takes back: the positions, what was spawned, or all of it and the time.
STATE, SPAWNED, ALL = (ResetSimulation.Request.SCOPE_STATE, ResetSimulation.Request.SCOPE_SPAWNED,
                       ResetSimulation.Request.SCOPE_ALL)
_BECOME = (Result.RESULT_OK, SetSimulationState.Response.ALREADY_IN_TARGET_STATE)


class SimulationClient:
    """
    Calls the services of a simulator.

    What it refuses raises a SimulationError with its reason.

    :param client: what calls, such as a :class:`ClientNode`.
    """

    def __init__(self, client: Caller) -> None:
        self._client = client

    def play(self) -> None:
        """Let the time run."""
        self._become(SimulationState.STATE_PLAYING)

    def pause(self) -> None:
        """Stop the time."""
        self._become(SimulationState.STATE_PAUSED)

    def step(self, steps: int = 1) -> None:
        """Make physics steps; in lockstep, or while the time is stopped."""
        self.ask('/step_simulation', StepSimulation, StepSimulation.Request(steps=steps))

    def reset(self, scope: int = STATE | SPAWNED) -> None:
        """Take back what has happened since the start; see :data:`STATE`."""
        self.ask('/reset_simulation', ResetSimulation, ResetSimulation.Request(scope=scope))

    def load_world(self, uri: str) -> None:
        """Replace the world by that of a file or a name of ours."""
        self.ask('/load_world', LoadWorld, LoadWorld.Request(uri=uri))

    def spawn(self, name: str, uri: str, pose: Matrix) -> str:
        """
        Put an object into the world and return its name there.

        :param uri: of a model, or a shape such as ``armsim://box?size=0.05,0.05,0.05&mass=0.1``.
        :param pose: (4, 4) in the world.
        """
        request = SpawnEntity.Request(name=name, uri=uri)
        request.initial_pose.pose = pose_to_message(pose)
        return str(self.ask('/spawn_entity', SpawnEntity, request).entity_name)

    def delete(self, name: str) -> None:
        """Take an object out of the world."""
        self.ask('/delete_entity', DeleteEntity, DeleteEntity.Request(entity=name))

    def entities(self) -> list[str]:
        """Return the names of all that is in the world."""
        return list(self.ask('/get_entities', GetEntities, None).entities)

    def pose(self, name: str) -> Matrix:
        """Return where an object is in the world, (4, 4)."""
        request = GetEntityState.Request(entity=name)
        return pose_from_message(self.ask('/get_entity_state', GetEntityState, request).state.pose)

    def ask(self, service: str, kind: type[Any], request: Any) -> Any:
        """
        Call a service of ``simulation_interfaces`` and return its response.

        :raises SimulationError: the result is not OK.
        """
        response = self._client.call(service, kind, request)
        if response.result.result != Result.RESULT_OK:
            raise SimulationError(response.result.error_message)
        return response

    def _become(self, state: int) -> None:
        request = SetSimulationState.Request(state=SimulationState(state=state))
        result = self._client.call('/set_simulation_state', SetSimulationState, request).result
        if result.result not in _BECOME:
            raise SimulationError(result.error_message)
