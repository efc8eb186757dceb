# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that query and move entities."""

from __future__ import annotations

from collections.abc import Callable, Collection
import ctypes
from functools import cache
from math import prod
import re
import sys
from typing import Any

import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import Bounds, EntityCategory, EntityFilters, Result, TagsFilter
from simulation_interfaces.msg import EntityInfo as EntityInfoMessage
from simulation_interfaces.srv import (
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    SetEntityInfo,
    SetEntityState,
)

from armsim_ros.arrays import Matrix
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.conversions.geometry import corners_from_message
from armsim_ros.nodes.simulation.world.answers import (
    answered,
    box,
    given_state,
    RefusedError,
    RefusedPoseError,
    state_message,
    Work,
)
from armsim_ros.sim.world.entities import Category, Entities, EntityInfo

#: Longer expressions are refused.
LONGEST_EXPRESSION = 500
#: Product of all counts in braces; each makes the expression so many times as large.
MOST_REPEATS = 1000
_COUNTS, _BACKWARDS = re.compile(r'(\d+)\s*}'), re.compile(r'\\\d')
#: Room for a ``regex_t`` [bytes]; it has 64 in the GNU library and less in others.
_ROOM = 512
_EXTENDED = 1


class Selection:
    """
    A filter that was understood.

    :param filters: the message.
    :raises RefusedError: its region has a type that is not supported.
    :raises SimulationError: a filter cannot be understood.
    """

    def __init__(self, filters: EntityFilters) -> None:
        self._matches = expression(filters.filter)
        self._categories = {category.category for category in filters.categories}
        self._overlaps = region(filters.bounds)
        self._tags = filters.tags
        has_tags((), self._tags)

    def names(self, entities: Entities) -> list[str]:
        """Return the names of the entities that pass, sorted; only in the loop's thread."""
        return [name for name in entities.names if self._passes(name, entities)]

    def _passes(self, name: str, entities: Entities) -> bool:
        info = entities.info(name)
        return (
            self._matches(name)
            and (not self._categories or info.category in self._categories)
            and has_tags(info.tags, self._tags)
            and (self._overlaps is None or self._overlaps(*entities.world_bounds(name))))


def has_tags(tags: Collection[str], requested: TagsFilter) -> bool:
    """
    Return whether labels pass a filter.

    :raises SimulationError: a mode that is none.
    """
    if not requested.tags:
        return True
    if requested.filter_mode == TagsFilter.FILTER_MODE_ALL:
        return all(tag in tags for tag in requested.tags)
    if requested.filter_mode == TagsFilter.FILTER_MODE_ANY:
        return any(tag in tags for tag in requested.tags)
    raise SimulationError(f'filter_mode is {requested.filter_mode}; allowed: ANY (0), ALL (1)')


def expression(text: str) -> Callable[[str], bool]:
    """
    Return what searches a POSIX extended regular expression in a name.

    The C library does it, so that it means what it means elsewhere.

    :raises SimulationError: the expression is broken.
    """
    if not text:
        return lambda name: True
    if len(text) > LONGEST_EXPRESSION or '\0' in text:
        raise SimulationError(
            f'the filter has {len(text)} characters; allowed: up to {LONGEST_EXPRESSION}')
    if prod(max(1, int(number)) for number in _COUNTS.findall(text)) > MOST_REPEATS:
        raise SimulationError(
            f"the filter '{text}' repeats too much; allowed: a product of {MOST_REPEATS}")
    if _BACKWARDS.search(text):
        raise SimulationError(f"the filter '{text}' refers to a group; that is not supported")
    library, compiled = _library(), ctypes.create_string_buffer(_ROOM)
    code = library.regcomp(compiled, text.encode(), _EXTENDED)
    if code:
        words = ctypes.create_string_buffer(200)
        library.regerror(code, compiled, words, len(words))
        raise SimulationError(f"the filter '{text}' is not a POSIX extended regular expression: "
                              f'{words.value.decode(errors="replace")}')
    held = _Compiled(library, compiled)
    return lambda name: library.regexec(held.buffer, name.encode(), 0, None, 0) == 0


def region(bounds: Bounds) -> Callable[[Matrix, Matrix], bool] | None:
    """
    Return a test whether a box of the world overlaps a region; None where there is none.

    :raises RefusedError: the type of the region is not supported.
    :raises SimulationError: it has wrong points.
    """
    if bounds.type == Bounds.TYPE_EMPTY:
        return None
    points = np.array([(point.x, point.y, point.z) for point in bounds.points])
    if bounds.type not in (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE):
        raise RefusedError(
            Result.RESULT_FEATURE_UNSUPPORTED, f'bounds of type {bounds.type} are not supported; '
            'allowed: TYPE_EMPTY (0), TYPE_BOX (1), TYPE_SPHERE (3)')
    if points.shape != (2, 3) or not np.isfinite(points).all():
        raise SimulationError(f'the bounds have {len(points)} points; allowed: 2, finite')
    if bounds.type == Bounds.TYPE_SPHERE:
        centre, radius = points[0], float(points[1, 0])

        def in_sphere(low: Matrix, high: Matrix) -> bool:
            return float(np.linalg.norm(np.clip(centre, low, high) - centre)) <= radius

        return in_sphere
    least, most = corners_from_message(bounds.points)

    def in_box(low: Matrix, high: Matrix) -> bool:
        return bool((low <= most).all() and (high >= least).all())

    return in_box


class _Compiled:
    """Frees an expression with its last reference."""

    def __init__(self, library: Any, buffer: Any) -> None:
        self._library, self.buffer = library, buffer

    def __del__(self) -> None:
        self._library.regfree(self.buffer)


@cache
def _library() -> Any:
    library = ctypes.CDLL('libSystem.dylib' if sys.platform == 'darwin' else None)
    pointer, text, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
    library.regcomp.argtypes = [pointer, text, ctypes.c_int]
    library.regexec.argtypes = [pointer, text, size, pointer, ctypes.c_int]
    library.regerror.argtypes = [ctypes.c_int, pointer, pointer, size]
    library.regfree.argtypes = [pointer]
    return library


#: The longest text that is kept of a user's input.
LONGEST_TEXT, MOST_TAGS = 10_000, 100


def given_info(message: EntityInfoMessage) -> EntityInfo:
    """
    Return an info of a message, each tag once.

    :raises SimulationError: a category that is none, or too much text.
    """
    number = message.category.category
    if number not in list(Category):
        raise SimulationError(f'category {number} is not known; allowed: ' + ', '.join(
            f'{category.name} ({category})' for category in Category))
    if len(message.description) > LONGEST_TEXT or len(message.tags) > MOST_TAGS:
        raise SimulationError(
            f'allowed: a description of {LONGEST_TEXT} characters and {MOST_TAGS} tags')
    return EntityInfo(
        Category(number), message.description, tuple(dict.fromkeys(message.tags)))


class EntityServices:
    """Answers about entities, each consistent with a single moment between two ticks."""

    def __init__(self, node: Node, work: Work, entities: Entities) -> None:
        self._work, self._entities = work, entities
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
            entities.set_state(request.entity, given_state(request.state, entities.frame_pose))

        try:
            await self._work.beside(lambda: self._work.wait_for_loop(put))
        except RefusedPoseError as error:
            raise RefusedError(SetEntityState.Response.INVALID_POSE, str(error)) from None

    @answered
    async def _info(self, request: Any, response: Any) -> None:
        info = await self._work.in_loop(lambda: self._entities.info(request.entity))
        response.info = EntityInfoMessage(
            category=EntityCategory(category=int(info.category)), description=info.description,
            tags=list(info.tags))

    @answered
    async def _set_info(self, request: Any, response: Any) -> None:
        info = given_info(request.info)
        await self._work.in_loop(lambda: self._entities.set_info(request.entity, info))

    @answered
    async def _bounds(self, request: Any, response: Any) -> None:
        low, high = await self._work.in_loop(lambda: self._entities.bounds(request.entity))
        response.bounds = box(low, high)
