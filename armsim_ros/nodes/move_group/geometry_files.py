# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``save_geometry_to_file`` and ``load_geometry_from_file``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from moveit_msgs.srv import LoadGeometryFromFile, SaveGeometryToFile

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.scene_file import read_scene_file, write_scene_file


class GeometryFiles:
    """
    Writes the objects of the world to a file, or reads them from one.

    :param context: the parts of move_group.
    :param save: which of the two services to offer.
    """

    def __init__(self, context: Context, *, save: bool) -> None:
        """Make the server."""
        self._context = context
        if save:
            context.serve(SaveGeometryToFile, 'save_geometry_to_file', self._save)
        else:
            context.serve(LoadGeometryFromFile, 'load_geometry_from_file', self._load)

    async def _save(self, request: Any, response: Any) -> Any:
        scene = self._context.scene.snapshot()
        path = request.file_path_and_name
        response.success = self._done('save', lambda: write_scene_file(path, scene))
        return response

    async def _load(self, request: Any, response: Any) -> Any:
        def load() -> None:
            update = read_scene_file(request.file_path_and_name)
            _, refused = self._context.scene.with_update(update)
            if refused:
                raise PlanningError(MoveItErrorCode.FAILURE, '; '.join(refused))
            self._context.scene.apply(update)

        response.success = self._done('load', load)
        return response

    def _done(self, what: str, work: Callable[[], None]) -> bool:
        """Do all of it or nothing, and say why nothing."""
        try:
            work()
        except (PlanningError, OSError) as error:
            self._context.logger.error(f'{what} geometry: {error}')
            return False
        return True
