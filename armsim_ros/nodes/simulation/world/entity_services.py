# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that query and move entities."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import EntityCategory, EntityInfo
from simulation_interfaces.srv import (
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    SetEntityInfo,
    SetEntityState,
)

from armsim_ros.nodes.simulation.world.answers import (
    answered,
    box,
    given_state,
    refuse,
    RefusedPoseError,
    state_message,
)
from armsim_ros.nodes.simulation.world.filters import Selection
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.world.entities import Entities

#: The longest text that is kept of a user's input.
LONGEST_TEXT, MOST_TAGS = 10_000, 100


class EntityServices:
    """
    Answers about entities, each consistent with a single moment between two ticks.

    :param node: the node that serves.
    :param work: reaches the loop.
    """

    def __init__(self, node: Node, work: Work, entities: Entities) -> None:
        self._work = work
        self._entities = entities
        group = ReentrantCallbackGroup()
        for name, kind, answer in (
            ('/get_entities', GetEntities, self._list),
            ('/get_entities_states', GetEntitiesStates, self._states),
            ('/get_entity_state', GetEntityState, self._state),
            ('/set_entity_state', SetEntityState, self._set_state),
            ('/get_entity_info', GetEntityInfo, self._info),
            ('/set_entity_info', SetEntityInfo, self._set_info),
            ('/get_entity_bounds', GetEntityBounds, self._bounds),
        ):
            node.create_service(kind, name, answer, callback_group=group)

    @answered
    async def _list(self, request: Any, response: Any) -> None:
        selection = Selection(request.filters)
        response.entities = await self._work.in_loop(lambda: selection.names(self._entities))

    @answered
    async def _states(self, request: Any, response: Any) -> None:
        selection = Selection(request.filters)

        def look() -> tuple[dict[str, Any], int]:
            names = selection.names(self._entities)
            return self._entities.states(names), self._work.loop.clock.now_ns

        states, time_ns = await self._work.in_loop(look)
        response.entities = list(states)
        response.states = [state_message(state, time_ns) for state in states.values()]

    @answered
    async def _state(self, request: Any, response: Any) -> None:
        state, time_ns = await self._work.in_loop(
            lambda: (self._entities.state(request.entity), self._work.loop.clock.now_ns))
        response.state = state_message(state, time_ns)

    @answered
    async def _set_state(self, request: Any, response: Any) -> None:
        def put() -> None:
            entities = self._entities
            entities.state(request.entity)  # an unknown entity is reported first
            entities.set_state(
                request.entity, given_state(request.state, entities.frame_pose))

        try:
            await self._work.beside(lambda: self._work.wait_for_loop(put))
        except RefusedPoseError as error:
            refuse(response.result, SetEntityState.Response.INVALID_POSE, str(error))

    @answered
    async def _info(self, request: Any, response: Any) -> None:
        info = await self._work.in_loop(lambda: self._entities.info(request.entity))
        response.info = EntityInfo(
            category=EntityCategory(category=int(info.category)),
            description=info.description,
            tags=list(info.tags),
        )

    @answered
    async def _set_info(self, request: Any, response: Any) -> None:
        requested = request.info
        known = await self._work.in_loop(lambda: self._entities.info(request.entity))
        if requested.category.category not in (EntityCategory.CATEGORY_OBJECT, known.category):
            refuse(response.result, response.result.RESULT_OPERATION_FAILED,
                   f"the category of '{request.entity}' is {int(known.category)} and cannot be "
                   f'changed to {requested.category.category}')
            return
        if len(requested.description) > LONGEST_TEXT or len(requested.tags) > MOST_TAGS:
            refuse(response.result, response.result.RESULT_OPERATION_FAILED,
                   f'allowed: a description of {LONGEST_TEXT} characters and {MOST_TAGS} tags')
            return
        await self._work.in_loop(lambda: self._entities.set_info(
            request.entity, requested.description, requested.tags))

    @answered
    async def _bounds(self, request: Any, response: Any) -> None:
        low, high = await self._work.in_loop(lambda: self._entities.bounds(request.entity))
        response.bounds = box(low, high)
