# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that list, load and unload worlds."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import Resource, Result, WorldResource
from simulation_interfaces.srv import (
    GetAvailableWorlds,
    GetCurrentWorld,
    LoadWorld,
    UnloadWorld,
)

from armsim_ros.errors import ResourceError, SimulationError
from armsim_ros.nodes.simulation.world.answers import answered, refuse
from armsim_ros.nodes.simulation.world.filters import has_tags
from armsim_ros.nodes.simulation.world.simulation_state import Resetting, RunState
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.physics.mujoco_model import Ground
from armsim_ros.sim.world.entities import Entities
from armsim_ros.sim.world_files.loaded import (
    Fault,
    LoadedWorld,
    ResourceFaultError,
    told_of,
)
from armsim_ros.sim.world_files.resources import WorldResources

_CODES = {
    Fault.UNSUPPORTED_FORMAT: LoadWorld.Response.UNSUPPORTED_FORMAT,
    Fault.NO_RESOURCE: LoadWorld.Response.NO_RESOURCE,
    Fault.RESOURCE_PARSE_ERROR: LoadWorld.Response.RESOURCE_PARSE_ERROR,
    Fault.MISSING_ASSETS: LoadWorld.Response.MISSING_ASSETS,
    Fault.UNSUPPORTED_ASSETS: LoadWorld.Response.UNSUPPORTED_ASSETS,
}
#: Labels of the worlds that come with the package.
_SHIPPED = ('armsim_ros',)


class Worlds:
    """
    Replaces the world around the robots.

    :param node: the node that serves.
    :param work: makes changes beside the loop.
    :param resources: finds and reads worlds.
    :param resetting: notifies of a new world.
    """

    def __init__(
        self,
        node: Node,
        work: Work,
        entities: Entities,
        resources: WorldResources,
        state: RunState,
        resetting: Resetting,
    ) -> None:
        self._node = node
        self._work = work
        self._entities = entities
        self._resources = resources
        self._state = state
        self._resetting = resetting
        group = ReentrantCallbackGroup()
        for name, kind, answer in (
            ('/get_available_worlds', GetAvailableWorlds, self._available),
            ('/get_current_world', GetCurrentWorld, self._current),
            ('/load_world', LoadWorld, self._load),
            ('/unload_world', UnloadWorld, self._unload),
        ):
            node.create_service(kind, name, answer, callback_group=group)

    @answered
    async def _available(self, request: Any, response: Any) -> None:
        folders = [Path(text.removeprefix('file://')) for text in request.additional_sources]
        shipped = self._resources.worlds()
        found, problems = dict(shipped), []
        for folder in folders:
            try:
                found.update(await self._work.beside(partial(self._only, folder)))
            except ResourceError as error:
                problems.append(str(error))
        if problems and not request.continue_on_error:
            refuse(response.result, Result.RESULT_OPERATION_FAILED, '; '.join(problems))
            return
        response.result.error_message = '; '.join(problems)
        for name, file in sorted(found.items()):
            tags = _SHIPPED if name in shipped else ()
            if has_tags(tags, request.filter):
                response.worlds.append(_world_message(name, f'file://{file}', tags))

    def _only(self, folder: Path) -> dict[str, Path]:
        return self._resources.worlds([folder])

    @answered
    async def _current(self, request: Any, response: Any) -> None:
        if self._state.world is None:
            refuse(response.result, GetCurrentWorld.Response.NO_WORLD_LOADED,
                   'no world is loaded; call load_world')
            return
        response.world = _world_message(self._state.world, self._state.uri, ())

    @answered
    async def _load(self, request: Any, response: Any) -> None:
        try:
            world = await self._work.beside(
                lambda: self._resources.world(
                    request.uri, request.resource_string,
                    ignore_assets=request.ignore_missing_or_unsupported_assets))
        except ResourceFaultError as error:
            refuse(response.result, _CODES[error.fault], str(error))
            return
        if world.unused and request.fail_on_unsupported_element:
            refuse(response.result, LoadWorld.Response.UNSUPPORTED_ELEMENTS,
                   f'not used here: {"; ".join(world.unused)}')
            return
        self._state.loading = True
        try:
            await self._exchange(world)
        except SimulationError as error:
            refuse(response.result, LoadWorld.Response.RESOURCE_PARSE_ERROR, str(error))
            return
        finally:
            self._state.loading = False
        self._state.world, self._state.uri = world.name, request.uri
        response.world = _world_message(world.name, request.uri, ())
        response.result.error_message = told_of(world)
        self._node.get_logger().info(
            f"world '{world.name}' is loaded and paused; {response.result.error_message}")

    @answered
    async def _unload(self, request: Any, response: Any) -> None:
        if self._state.world is None:
            refuse(response.result, UnloadWorld.Response.NO_WORLD_LOADED,
                   'no world is loaded, so none can be unloaded')
            return
        await self._exchange(LoadedWorld('', ()))
        self._state.world, self._state.uri = None, ''
        self._node.get_logger().info('the world is unloaded; the robots do not move')

    async def _exchange(self, world: LoadedWorld) -> None:
        """Replace the current world; if that fails, the old world stays."""
        def change() -> None:
            taken = [item.name for item in world.items
                     if self._entities.is_robot(item.name)]
            if taken:
                raise SimulationError(f"the world has an object '{taken[0]}', as a robot is named")
            edit = self._entities.stage_load(
                world.items, Ground(world.floor, world.gravity))

            def between_ticks() -> None:
                self._entities.load(edit)
                self._work.loop.restart('another world was loaded')
                self._state.stop()
                for follow in self._resetting.followers:
                    follow()

            self._work.wait_for_loop(between_ticks)

        await self._work.beside(change)


def _world_message(name: str, uri: str, tags: Iterable[str]) -> WorldResource:
    return WorldResource(name=name, world_resource=Resource(uri=uri), tags=list(tags))
