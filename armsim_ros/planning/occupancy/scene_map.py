# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The octomap of a scene, which measurements and the scene's edits change."""

from __future__ import annotations

from dataclasses import dataclass

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.planning.occupancy.occupancy_map import HALF_DIAGONAL, Measurement, OccupancyMap
from armsim_ros.planning.occupancy.solids import changed_bodies, known_bodies
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.octomap import Octomap
from armsim_ros.planning.scene.octree_data import Floats
from armsim_ros.planning.scene.planning_scene import PlanningScene


@dataclass(frozen=True, eq=False)
class Sight:
    """
    What a sensor measured, and what was known then.

    :param points: (k, 3) [m] in the sensor's frame.
    :param max_range: farther points are no hits [m].
    :param beyond: (j, 3) [m] where rays end that have hit nothing.
    :param sensor: (4, 4) pose of the sensor in the model frame.
    :param content: of the scene, whose bodies are left out.
    :param q: (n,) the robot's state at that time.
    :param scale: factor of the size of the bodies.
    :param offset: [m] by which they are grown.
    :param spread: further growth [m/m^2] by the square of their depth.
    """

    points: Floats
    max_range: float
    beyond: Floats
    sensor: Matrix
    content: SceneContent
    q: Vector
    scale: float = 1.0
    offset: float = 0.0
    spread: float = 0.0


class SceneMap:
    """
    Keeps an occupancy map in the model frame, and puts it into a scene.

    The map changes only under the lock of the scene, so that what an edit of the scene has
    emptied is not brought back by a measurement of before. Objects that are added, moved or
    attached empty their cells at once.

    :param scene: gets the map.
    :param resolution: edge of a cell [m].
    :param growth: [m] by which such objects are grown.
    """

    def __init__(self, scene: PlanningScene, resolution: float, growth: float) -> None:
        self._scene = scene
        self._map, self._growth = OccupancyMap(resolution), growth
        #: Increases each time that the map is forgotten.
        self.epoch = 0
        """Increases each time that the map is forgotten."""
        scene.add_listener(self._edited)

    def add(self, sight: Sight, epoch: int | None = None) -> Mask:
        """
        Add a measurement; return which points (k,) are within range and outside of bodies.

        :param epoch: of the map when the measurement came: one of before is not added.
        """
        bodies = known_bodies(
            self._scene.kinematic_model, sight.content, sight.q, sight.scale, sight.offset,
            sight.spread, sight.sensor)
        measurement = Measurement(sight.points, sight.sensor, sight.max_range, sight.beyond)
        known = self.epoch if epoch is None else epoch
        while True:
            base = self._map
            added, kept = base.inserted(measurement, bodies)
            if self._taken(base, added, known):
                return kept

    def load(self, octomap: Octomap) -> None:
        """
        Replace the map and the scene's; later measurements are added to its occupied cells.

        :param octomap: in the model frame; its resolution is that of the map from then on.
        :raises PlanningError: FAILURE for too many cells.
        """
        loaded = OccupancyMap.of_occupied(octomap)

        def change() -> Octomap | None:
            self._map = loaded
            return None if octomap.empty else octomap

        self._scene.change_octomap(change)

    def forget(self) -> None:
        """Empty the map and the scene's."""
        def empty() -> Octomap | None:
            self._empty()
            return None

        self._scene.change_octomap(empty)

    def _empty(self) -> None:
        self._map = OccupancyMap(self._map.resolution)
        self.epoch += 1

    def _taken(self, base: OccupancyMap, added: OccupancyMap, epoch: int) -> bool:
        """Put a map in the place of what it was made from; False where that has changed."""
        done = True

        def change() -> Octomap | None:
            nonlocal done
            if self.epoch == epoch and self._map is base:
                self._map = added
                return added.octomap()
            done = self.epoch != epoch
            return self._scene.octomap

        self._scene.change_octomap(change)
        return done

    def _edited(self, before: SceneContent, after: SceneContent) -> None:
        """Follow an edit; under the lock of the scene."""
        if after.octomap is None and before.octomap is not None:
            self._empty()
        if after.objects is before.objects and after.attached is before.attached:
            return
        reach = self._growth + HALF_DIAGONAL * self._map.resolution
        emptied = self._map.emptied(
            changed_bodies(self._scene.kinematic_model, before, after, reach))
        if emptied is not self._map:
            self._map = emptied
            self._scene.set_octomap(emptied.octomap())
