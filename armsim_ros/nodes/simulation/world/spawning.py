# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services that add and remove entities."""

from __future__ import annotations

from dataclasses import replace
import re
from typing import Any, NamedTuple

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from simulation_interfaces.msg import Result, Spawnable, SpawnResult
from simulation_interfaces.srv import DeleteEntity, GetSpawnables, SpawnEntities, SpawnEntity

from armsim_ros.errors import ArmsimError
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.nodes.simulation.world.answers import (
    answered,
    box,
    checked_pose,
    frame_of,
    refuse,
    RefusedPoseError,
)
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.physics.mujoco_model import FLOOR_NAME
from armsim_ros.sim.world.entities import Entities, object_bounds, WORLD_FRAME
from armsim_ros.sim.world.world_scene import OverlapError
from armsim_ros.sim.world_files.loaded import Fault, ResourceFaultError, told_of
from armsim_ros.sim.world_files.resources import WorldResources

LONGEST_NAME = 200
#: Reserved names.
_RESERVED = (WORLD_FRAME, FLOOR_NAME)
_NAME = re.compile(rf'[A-Za-z0-9_./-]{{1,{LONGEST_NAME}}}')
_NAMESPACE = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*/?', re.ASCII)
_CODES = {
    Fault.UNSUPPORTED_FORMAT: SpawnResult.UNSUPPORTED_FORMAT,
    Fault.NO_RESOURCE: SpawnResult.NO_RESOURCE,
    Fault.RESOURCE_PARSE_ERROR: SpawnResult.RESOURCE_PARSE_ERROR,
    Fault.MISSING_ASSETS: SpawnResult.MISSING_ASSETS,
    Fault.UNSUPPORTED_ASSETS: SpawnResult.UNSUPPORTED_ASSETS,
}


class _Order(NamedTuple):
    """A request to spawn, in the form that both services share."""

    name: str
    renaming: bool
    uri: str
    text: str
    namespace: str
    pose: Any


class _RefusedError(ArmsimError):
    """A request cannot be carried out."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class Spawning:
    """
    Adds and removes entities while everything runs.

    :param node: the node that serves.
    :param work: makes changes beside the loop.
    :param resources: reads what is spawned.
    """

    def __init__(
        self, node: Node, work: Work, entities: Entities, resources: WorldResources
    ) -> None:
        self._node = node
        self._work = work
        self._entities = entities
        self._resources = resources
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
            refuse(response.result, SpawnEntities.Response.ENTITIES_SPAWN_FAILED,
                   f'{len(failed)} of {len(response.results)} could not be spawned, the first '
                   f'because: {failed[0].result.error_message}')

    async def _spawned(self, order: _Order, result: Result) -> str:
        """Carry out a request; return the name, '' if refused, with the reason in the result."""
        try:
            name, note = await self._work.beside(lambda: self._spawn(order))
        except _RefusedError as error:
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
            raise _RefusedError(
                SpawnResult.NAMESPACE_INVALID, f"'{order.namespace[:200]}' is not a namespace; "
                'allowed: letters, digits and _ that do not begin with a digit, separated by /')
        try:
            loaded = self._resources.object(order.uri, order.text, order.name)
        except ResourceFaultError as error:
            raise _RefusedError(_CODES[error.fault], str(error)) from None
        name = self._name(order, loaded.item)
        try:
            local = checked_pose(order.pose.pose)
            frame = self._work.wait_for_loop(
                lambda: frame_of(order.pose.header.frame_id, self._entities.frame_pose))
        except RefusedPoseError as error:
            raise _RefusedError(SpawnResult.INVALID_POSE, str(error)) from None
        edit = self._entities.stage_spawn([replace(loaded.item, name=name, pose=frame @ local)])
        try:
            overlap = self._work.wait_for_loop(lambda: self._entities.spawn(edit))
        except OverlapError as error:
            raise _RefusedError(SpawnResult.INVALID_POSE, str(error)) from None
        return name, '; '.join(filter(None, (told_of(loaded), overlap)))

    def _name(self, order: _Order, item: WorldObject) -> str:
        requested = order.name or item.name
        if not requested and not order.renaming:
            raise _RefusedError(
                SpawnResult.NAME_INVALID, 'the name is empty, and the resource gives none; '
                'allow_renaming lets it be chosen')
        if not _NAME.fullmatch(requested):
            if not order.renaming:
                self._check_name(requested)
            requested = re.sub(r'[^A-Za-z0-9_./-]', '_', requested)[:LONGEST_NAME - 8] or 'entity'
        taken = self._entities.has(requested) or requested in _RESERVED
        if taken and not order.renaming:
            raise _RefusedError(
                SpawnResult.NAME_NOT_UNIQUE, f"the name '{requested}' is taken; allow_renaming "
                'puts a number behind it')
        return self._entities.free_name(requested, _RESERVED)

    def _check_name(self, name: str) -> None:
        if not _NAME.fullmatch(name):
            raise _RefusedError(
                SpawnResult.NAME_INVALID, f"'{name[:LONGEST_NAME]}' is not a name; allowed: 1 to "
                f'{LONGEST_NAME} letters, digits, _ - . /')

    @answered
    async def _delete(self, request: Any, response: Any) -> None:
        def delete() -> None:
            edit = self._entities.stage_delete([request.entity])
            self._work.wait_for_loop(lambda: self._entities.delete(edit))

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
