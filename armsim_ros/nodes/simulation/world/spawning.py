# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that add and remove entities, and that load and unload worlds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
import re
from typing import Any, NamedTuple

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import Resource, Result, Spawnable, SpawnResult, WorldResource
from simulation_interfaces.srv import (
    DeleteEntity,
    GetAvailableWorlds,
    GetCurrentWorld,
    GetSpawnables,
    LoadWorld,
    SpawnEntities,
    SpawnEntity,
    UnloadWorld,
)

from armsim_ros.errors import ArmsimError, ResourceError, SimulationError
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.nodes.simulation.world.answers import (
    answered,
    box,
    checked_pose,
    frame_of,
    refuse,
    RefusedError,
    RefusedPoseError,
    Work,
)
from armsim_ros.nodes.simulation.world.entity_services import has_tags
from armsim_ros.nodes.simulation.world.simulation_state import Resetting, RunState
from armsim_ros.sim.physics.mujoco_model import FLOOR_NAME, Ground
from armsim_ros.sim.world.entities import Entities, object_bounds, WORLD_FRAME
from armsim_ros.sim.world.loaded_world import LoadedWorld, ResourceFaultError, told_of
from armsim_ros.sim.world.resources import WorldResources
from armsim_ros.sim.world.world_scene import OverlapError

LONGEST_NAME = 200
#: Reserved names.
_RESERVED = (WORLD_FRAME, FLOOR_NAME)
_NAME = re.compile(rf'[A-Za-z0-9_./-]{{1,{LONGEST_NAME}}}')
_NAMESPACE = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*/?', re.ASCII)


class _Order(NamedTuple):
    """A request to spawn, in the form that both services share."""

    name: str
    renaming: bool
    uri: str
    text: str
    namespace: str
    pose: Any


class Spawning:
    """Adds and removes entities while everything runs."""

    def __init__(
        self, node: Node, work: Work, entities: Entities, resources: WorldResources
    ) -> None:
        self._node, self._work, self._entities, self._resources = node, work, entities, resources
        group = ReentrantCallbackGroup()
        for name, kind, answer in (
            ('/spawn_entity', SpawnEntity, self._spawn_one),
            ('/spawn_entities', SpawnEntities, self._spawn_many),
            ('/delete_entity', DeleteEntity, self._delete),
            ('/get_spawnables', GetSpawnables, self._spawnables),
        ):
            node.create_service(kind, name, answer, callback_group=group)

    @answered
    async def _spawn_one(self, request: Any, response: Any) -> None:
        response.entity_name = await self._spawned(_Order(
            request.name, request.allow_renaming, request.uri, request.resource_string,
            request.entity_namespace, request.initial_pose,
        ), response.result)

    @answered
    async def _spawn_many(self, request: Any, response: Any) -> None:
        for entity in request.spawn_requests:
            result = SpawnResult()
            result.result.result = Result.RESULT_OK
            result.entity_name = await self._spawned(_Order(
                entity.name, entity.allow_renaming, entity.entity_resource.uri,
                entity.entity_resource.resource_string, entity.entity_namespace,
                entity.initial_pose,
            ), result.result)
            response.results.append(result)
        failed = [result for result in response.results
                  if result.result.result != Result.RESULT_OK]
        if failed:
            raise RefusedError(
                SpawnEntities.Response.ENTITIES_SPAWN_FAILED, f'{len(failed)} of '
                f'{len(response.results)} could not be spawned, the first because: '
                f'{failed[0].result.error_message}')

    async def _spawned(self, order: _Order, result: Result) -> str:
        """Carry out a request; return the name, '' if refused, with the reason in the result."""
        try:
            name, note = await self._work.beside(lambda: self._spawn(order))
        except RefusedError as error:
            refuse(result, error.code, str(error))
            return ''
        except ArmsimError as error:
            refuse(result, Result.RESULT_OPERATION_FAILED, str(error))
            return ''
        if note:
            result.error_message = note
            self._node.get_logger().info(f"'{name}' was spawned; {result.error_message}")
        return name

    def _spawn(self, order: _Order) -> tuple[str, str]:
        """Read, compile, and swap; in the thread of changes. Return name and remarks."""
        if order.name and not order.renaming:
            self._check_name(order.name)
        if order.namespace and not _NAMESPACE.fullmatch(order.namespace):
            raise RefusedError(
                SpawnResult.NAMESPACE_INVALID, f"'{order.namespace[:200]}' is not a namespace; "
                'allowed: letters, digits and _ that do not begin with a digit, separated by /')
        try:
            loaded = self._resources.object(order.uri, order.text, order.name)
        except ResourceFaultError as error:
            raise RefusedError(getattr(SpawnResult, error.fault.name), str(error)) from None
        name = self._name(order, loaded.item)
        try:
            local = checked_pose(order.pose.pose)
            frame = self._work.wait_for_loop(
                lambda: frame_of(order.pose.header.frame_id, self._entities.frame_pose))
        except RefusedPoseError as error:
            raise RefusedError(SpawnResult.INVALID_POSE, str(error)) from None
        edit = self._entities.stage_spawn([replace(loaded.item, name=name, pose=frame @ local)])
        try:
            overlap = self._work.wait_for_loop(lambda: self._entities.spawn(edit))
        except OverlapError as error:
            raise RefusedError(SpawnResult.INVALID_POSE, str(error)) from None
        return name, '; '.join(filter(None, (told_of(loaded), overlap)))

    def _name(self, order: _Order, item: WorldObject) -> str:
        requested = order.name or item.name
        if not requested and not order.renaming:
            raise RefusedError(
                SpawnResult.NAME_INVALID, 'the name is empty, and the resource gives none; '
                'allow_renaming lets it be chosen')
        if not _NAME.fullmatch(requested):
            if not order.renaming:
                self._check_name(requested)
            requested = re.sub(r'[^A-Za-z0-9_./-]', '_', requested)[:LONGEST_NAME - 8] or 'entity'
        taken = self._entities.has(requested) or requested in _RESERVED
        if taken and not order.renaming:
            raise RefusedError(
                SpawnResult.NAME_NOT_UNIQUE, f"the name '{requested}' is taken; allow_renaming "
                'puts a number behind it')
        return self._entities.free_name(requested, _RESERVED)

    def _check_name(self, name: str) -> None:
        if not _NAME.fullmatch(name):
            raise RefusedError(
                SpawnResult.NAME_INVALID, f"'{name[:LONGEST_NAME]}' is not a name; allowed: 1 to "
                f'{LONGEST_NAME} letters, digits, _ - . /')

    @answered
    async def _delete(self, request: Any, response: Any) -> None:
        def delete() -> None:
            edit = self._entities.stage_delete([request.entity])
            self._work.wait_for_loop(lambda: self._entities.commit(edit))

        await self._work.beside(delete)

    @answered
    async def _spawnables(self, request: Any, response: Any) -> None:
        if request.sources:
            response.result.error_message = (
                'only the armsim:// addresses are listed; other sources are not searched')
        for uri, loaded in (await self._work.beside(self._resources.spawnables)).items():
            item = loaded.item
            mass = 'fixed' if item.mass is None else f'{item.mass:g} kg'
            response.spawnables.append(Spawnable(
                uri=uri, description=f'{item.name or uri}, {mass}',
                spawn_bounds=box(*object_bounds(item))))


#: Labels of the worlds that come with the package.
_SHIPPED = ('armsim_ros',)


class Worlds:
    """Replaces the world around the robots."""

    def __init__(
        self, node: Node, work: Work, entities: Entities, resources: WorldResources,
        state: RunState, resetting: Resetting
    ) -> None:
        self._node, self._work, self._entities, self._resources = node, work, entities, resources
        self._state, self._resetting = state, resetting
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
            raise ResourceError('; '.join(problems))
        response.result.error_message = '; '.join(problems)
        for name, file in sorted(found.items()):
            tags = _SHIPPED if name in shipped else ()
            if has_tags(tags, request.filter):
                response.worlds.append(_world_message(
                    name, Resource(uri=f'file://{file}'), tags))

    def _only(self, folder: Path) -> dict[str, Path]:
        return self._resources.worlds([folder])

    @answered
    async def _current(self, request: Any, response: Any) -> None:
        if self._state.world is None:
            raise RefusedError(GetCurrentWorld.Response.NO_WORLD_LOADED,
                               'no world is loaded; call load_world')
        response.world = _world_message(self._state.world, self._state.resource, ())

    @answered
    async def _load(self, request: Any, response: Any) -> None:
        try:
            world = await self._work.beside(
                lambda: self._resources.world(
                    request.uri, request.resource_string,
                    ignore_assets=request.ignore_missing_or_unsupported_assets))
        except ResourceFaultError as error:
            raise RefusedError(getattr(LoadWorld.Response, error.fault.name), str(error)) from None
        if world.unused and request.fail_on_unsupported_element:
            raise RefusedError(LoadWorld.Response.UNSUPPORTED_ELEMENTS,
                               f'not used here: {"; ".join(world.unused)}')
        self._state.loading = True
        try:
            await self._exchange(world)
        except SimulationError as error:
            raise RefusedError(LoadWorld.Response.RESOURCE_PARSE_ERROR, str(error)) from None
        finally:
            self._state.loading = False
        text = '' if request.uri else request.resource_string
        self._state.world = world.name
        self._state.resource = Resource(uri=request.uri, resource_string=text)
        response.world = _world_message(world.name, self._state.resource, ())
        response.result.error_message = told_of(world)
        self._node.get_logger().info(
            f"world '{world.name}' is loaded and paused; {response.result.error_message}")

    @answered
    async def _unload(self, request: Any, response: Any) -> None:
        if self._state.world is None:
            raise RefusedError(UnloadWorld.Response.NO_WORLD_LOADED,
                               'no world is loaded, so none can be unloaded')
        await self._exchange(LoadedWorld('', ()))
        self._state.world = None
        self._node.get_logger().info('the world is unloaded; the robots do not move')

    async def _exchange(self, world: LoadedWorld) -> None:
        """Replace the current world; if that fails, the old world stays."""
        def change() -> None:
            taken = [item.name for item in world.items if self._entities.is_robot(item.name)]
            if taken:
                raise SimulationError(f"the world has an object '{taken[0]}', as a robot is named")
            edit = self._entities.stage_load(world.items, Ground(world.floor, world.gravity))

            def between_ticks() -> None:
                self._entities.load(edit)
                self._work.loop.restart('another world was loaded')
                self._state.stop()
                for follow in self._resetting.followers:
                    follow()

            self._work.wait_for_loop(between_ticks)

        await self._work.beside(change)


def _world_message(name: str, resource: Resource, tags: Iterable[str]) -> WorldResource:
    return WorldResource(name=name, world_resource=resource, tags=list(tags))
