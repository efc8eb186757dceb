# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated objects that the planning scene does not know, pale, as the room that they take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.transforms import quat_wxyz_from_matrix
from armsim_ros.nodes.web.scene.objects_drawing import pose_of
from armsim_ros.nodes.web.view.shapes import Color

_COLOR: Color = (150, 156, 166)
_OPACITY = 0.35
#: Of ``simulation_interfaces/msg/Bounds``.
_BOX = 1
#: What is thinner is drawn so thick [m].
_THINNEST = 1e-3


@dataclass(frozen=True, eq=False)
class Entity:
    """
    An object of the simulation.

    :param frame: of its pose.
    :param pose: the message.
    :param bounds: ``simulation_interfaces/msg/Bounds`` in its own frame, None for unknown ones.
    """

    name: str
    frame: str
    pose: Any
    bounds: Any

    def box(self) -> tuple[Matrix, Matrix] | None:
        """Return the middle and the sides of the box that it fills, (3,) each [m]."""
        if self.bounds is None or self.bounds.type != _BOX or len(self.bounds.points) != 2:
            return None
        low, high = (np.array((each.x, each.y, each.z)) for each in self.bounds.points)
        return 0.5 * (low + high), np.maximum(high - low, _THINNEST)

    def form(self) -> dict[str, Any]:
        """Return what the panel has to know of it."""
        position = self.pose.position
        return {'name': self.name, 'xyz': [round(getattr(position, axis), 3) for axis in 'xyz']}


class EntitiesDrawing:
    """
    Boxes, one per entity.

    :param scene: of all sessions.
    :param node_of: frame -> path of its node.
    """

    def __init__(self, scene: Any, node_of: Callable[[str], str]) -> None:
        self._scene, self._node_of = scene, node_of
        self._nodes: dict[str, tuple[tuple[float, ...], Any]] = {}

    def show(self, entities: Sequence[Entity]) -> None:
        """Draw these and no others; what has not moved is not sent again."""
        boxes = {entity.name: (entity, box) for entity in entities
                 if (box := entity.box()) is not None}
        for name in set(self._nodes) - set(boxes):
            self._nodes.pop(name)[1].remove()
        for name, (entity, (middle, sides)) in boxes.items():
            pose = pose_of(entity.pose)
            pose[:3, 3] += pose[:3, :3] @ middle
            path = f'{self._node_of(entity.frame)}/entity_{name}'
            mark = (path, *sides.tolist())
            known = self._nodes.get(name)
            if known is None or known[0] != mark:
                if known is not None:
                    known[1].remove()
                node = self._scene.add_box(
                    path, color=_COLOR, dimensions=tuple(sides.tolist()), opacity=_OPACITY,
                    cast_shadow=False)
                known = self._nodes[name] = (mark, node)
            _put(known[1], pose)


def _put(node: Any, pose: Matrix) -> None:
    position, turn = pose[:3, 3], quat_wxyz_from_matrix(pose)
    if not np.allclose(node.position, position, atol=1e-5):
        node.position = position
    if not np.allclose(node.wxyz, turn, atol=1e-5):
        node.wxyz = turn
