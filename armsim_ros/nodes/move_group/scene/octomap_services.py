# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services of the octomap: ``clear_octomap``, ``save_map`` and ``load_map``."""

from __future__ import annotations

from collections.abc import Callable

from moveit_msgs.srv import LoadMap, SaveMap
import numpy as np
from std_srvs.srv import Empty

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.scene.scene_services import (
    below_folder,
    done,
    geometry_folder,
)
from armsim_ros.planning.scene.octomap import octomap_error, read_map_file, write_map_file


class ClearOctomap:
    """
    Empties the map of the scene before it answers.

    :param context: the parts of move_group.
    :param forget: empties what the sensors have seen up to now.
    """

    def __init__(self, context: Context, forget: Callable[[], None]) -> None:
        self._context = context
        self._forget = forget
        context.serve(Empty, 'clear_octomap', self._answer)

    async def _answer(self, request: Empty.Request, response: Empty.Response) -> Empty.Response:
        def clear() -> None:
            self._forget()
            self._context.scene.set_octomap(None)

        await self._context.edits.submit(clear)
        return response


class MapFiles:
    """
    Writes the octomap to a ``.bt`` file, and reads it from a file, in the model frame.

    Files are below the folder of the parameter ``geometry_folder``; a path that is not absolute
    begins there.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._folder = geometry_folder(context.planning_parameters.geometry_folder)
        context.serve(SaveMap, 'save_map', self._save)
        context.serve(LoadMap, 'load_map', self._load)

    async def _save(
        self, request: SaveMap.Request, response: SaveMap.Response
    ) -> SaveMap.Response:
        def save() -> None:
            octomap = self._context.scene.octomap
            if octomap is None:
                raise octomap_error('there is none to save')
            below_folder(self._folder, request.filename).write_bytes(write_map_file(octomap))

        response.success = await done(self._context, 'save_map', save)
        return response

    async def _load(
        self, request: LoadMap.Request, response: LoadMap.Response
    ) -> LoadMap.Response:
        def load() -> None:
            content = below_folder(self._folder, request.filename).read_bytes()
            octomap = read_map_file(content, np.eye(4))
            self._context.scene.set_octomap(None if octomap.empty else octomap)

        response.success = await done(self._context, 'load_map', load)
        return response
