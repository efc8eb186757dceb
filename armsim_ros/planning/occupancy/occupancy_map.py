# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Cells and their log odds, and what a measurement does to them.

The rules are OctoMap's with its usual numbers. Of a measurement each cell changes once: a cell
with a point inside of a known body becomes free, one with another point is a hit, and one that a
ray has crossed is a miss. Only cells that were hit at some time are kept: to planning a free
cell is the same as an unknown one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.planning.occupancy.solids import inside_any, near_any, PlacedSolid
from armsim_ros.planning.scene.octomap import MIDDLE, Octomap, octomap_error, octomap_from_cells
from armsim_ros.planning.scene.octree_data import Floats, HIGHEST, Integers, LOWEST

HIT = float(np.log(0.7 / 0.3))
MISS = float(np.log(0.4 / 0.6))
#: Cells of an octomap to which measurements are added.
MOST_CELLS = 10_000_000
#: Bits of a cell's number along an axis.
_BITS = 16
#: Half the diagonal of a cell, in edges.
HALF_DIAGONAL = 0.5 * 3.0 ** 0.5


@dataclass(frozen=True, eq=False)
class Measurement:
    """
    What a sensor measured at a moment.

    :param points: (k, 3) [m] in the sensor's frame, all finite.
    :param sensor: (4, 4) pose of the sensor in the frame of the map.
    :param max_range: farther points [m] are no hits.
    :param beyond: (j, 3) [m] in the sensor's frame, where other rays end that have hit nothing.
    """

    points: Floats
    sensor: Matrix
    max_range: float = np.inf
    beyond: Floats = field(default_factory=lambda: np.zeros((0, 3), dtype=np.float32))


class OccupancyMap:
    """
    Cells and their log odds; immutable, a measurement makes a new map.

    :param resolution: edge of a cell [m].
    :param numbers: (k,) packed numbers of the cells, increasing.
    :param log_odds: (k,) of occupancy.
    """

    def __init__(
        self, resolution: float, numbers: Integers | None = None, log_odds: Floats | None = None
    ) -> None:
        self.resolution = resolution
        self._numbers = np.zeros(0, dtype=np.int64) if numbers is None else numbers
        self.log_odds = np.zeros(0, dtype=np.float32) if log_odds is None else log_odds
        """Log odds (k,) of occupancy."""

    @property
    def keys(self) -> Integers:
        """Numbers of the cells (k, 3); cell 0 begins at the origin."""
        return unpacked(self._numbers)

    @property
    def occupied(self) -> Integers:
        """Numbers of the occupied cells (k, 3)."""
        return unpacked(self._numbers[self.log_odds >= 0.0])

    def octomap(self) -> Octomap | None:
        """Return the map in the model frame; None where nothing is known."""
        if not len(self._numbers):
            return None
        return octomap_from_cells(self.keys, self.log_odds, self.resolution, np.eye(4))

    @classmethod
    def of_occupied(cls, octomap: Octomap) -> OccupancyMap:
        """
        Return the occupied cells of an octomap, in its frame.

        :raises PlanningError: FAILURE for more than :data:`MOST_CELLS` cells.
        """
        leaves = octomap.leaves
        which = leaves.occupied
        count = int((8.0 ** leaves.levels[which]).sum())
        if count > MOST_CELLS:
            raise octomap_error(
                f'it has {count} occupied cells; measurements are added to {MOST_CELLS} at most')
        numbers, odds = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.float32)]
        for level in np.unique(leaves.levels[which]):
            of_level = which & (leaves.levels == level)
            steps = packed(np.indices((1 << level,) * 3).reshape(3, -1).T)
            numbers.append((packed(leaves.corners[of_level])[:, None] + steps).ravel())
            odds.append(np.repeat(leaves.log_odds[of_level], len(steps)))
        united = np.concatenate(numbers)
        order = np.argsort(united)
        return cls(octomap.resolution, united[order], np.concatenate(odds)[order])

    # ---------------------------------------------------------------- changes

    def inserted(
        self, measurement: Measurement, bodies: Sequence[PlacedSolid]
    ) -> tuple[OccupancyMap, Mask]:
        """
        Return the map after a measurement, and which points (k,) are within range and outside.

        :param bodies: what is known already, in the frame of the map.
        """
        x, y, z = axes = np.ascontiguousarray(measurement.points.T)
        distances = np.sqrt(x * x + y * y + z * z)
        kept: Mask = distances <= measurement.max_range
        # Axis by axis, which takes a third of the time of a product of matrices.
        numbers = np.zeros(len(x), dtype=np.int64)
        placed = np.empty_like(axes)
        for row, axis in zip(measurement.sensor[:3].astype(np.float32), placed, strict=True):
            axis[:] = row[0] * x + row[1] * y + row[2] * z + row[3]
            cells = np.floor(axis * np.float32(1.0 / self.resolution)) + np.float32(MIDDLE)
            kept &= (cells >= 0) & (cells < 2 * MIDDLE)
            numbers = (numbers << _BITS) + cells.astype(np.int64)
        which = np.flatnonzero(kept)
        model, hit, inside = self._sorted_out(numbers[which], placed.T[which], bodies)
        kept[which[inside]] = False
        crossed = self._crossed(measurement, distances)
        return self._changed(model, hit, crossed), kept

    def _sorted_out(
        self, numbers: Integers, placed: Floats, bodies: Sequence[PlacedSolid]
    ) -> tuple[Integers, Integers, Mask]:
        """Return the cells with points inside of bodies, the other cells, the points inside."""
        inside = np.zeros(len(numbers), dtype=bool)
        if not len(numbers):
            return numbers, numbers, inside
        # Neighbouring points are mostly in the same cell: only where it changes are they sorted.
        starts = np.flatnonzero(np.r_[True, numbers[1:] != numbers[:-1]])
        cells, of_run = np.unique(numbers[starts], return_inverse=True)
        if bodies:
            centres = self._centres(cells)
            near = near_any(centres, HALF_DIAGONAL * self.resolution, bodies)
            lengths = np.diff(np.r_[starts, len(numbers)])
            asked = np.flatnonzero(np.repeat(near[of_run], lengths))
            inside[asked] = inside_any(placed[asked].astype(np.float64), bodies)
        model = np.unique(numbers[inside])
        return model, np.setdiff1d(cells, model, assume_unique=True), inside

    def _crossed(self, measurement: Measurement, distances: NDArray[np.float32]) -> Mask:
        """Return which of the cells a ray has crossed before its end."""
        sensor = measurement.sensor
        centres: Matrix = (self._centres(self._numbers) - sensor[:3, 3]) @ sensor[:3, :3]
        # At the lower clamp a miss changes nothing.
        asked = np.flatnonzero(self.log_odds > LOWEST)
        crossed = np.zeros(len(centres), dtype=bool)
        if len(asked):
            rays = Rays(measurement.points, np.minimum(distances, measurement.max_range),
                        measurement.beyond)
            crossed[asked] = rays.cross(
                centres[asked], HALF_DIAGONAL * self.resolution, sensor[:3, :3])
        return crossed

    def _changed(self, model: Integers, hit: Integers, crossed: Mask) -> OccupancyMap:
        odds = self.log_odds.copy()
        at_model, new_model = self._found(model)
        at_hit, new_hit = self._found(hit)
        crossed = crossed.copy()
        crossed[at_model] = crossed[at_hit] = False
        odds[crossed] = np.maximum(odds[crossed] + np.float32(MISS), np.float32(LOWEST))
        odds[at_hit] = np.minimum(odds[at_hit] + np.float32(HIT), np.float32(HIGHEST))
        odds[at_model] = LOWEST
        added = np.concatenate([new_model, new_hit])
        values = np.repeat(
            np.array([LOWEST, HIT], dtype=np.float32), [len(new_model), len(new_hit)])
        numbers = np.concatenate([self._numbers, added])
        order = np.argsort(numbers, kind='stable')
        return OccupancyMap(
            self.resolution, numbers[order], np.concatenate([odds, values])[order])

    def _found(self, numbers: Integers) -> tuple[Integers, Integers]:
        """Return the places of the cells that are kept, and the numbers of the others."""
        at = np.searchsorted(self._numbers, numbers)
        known = np.zeros(len(numbers), dtype=bool)
        inner = at < len(self._numbers)
        known[inner] = self._numbers[at[inner]] == numbers[inner]
        return at[known], numbers[~known]

    def _centres(self, numbers: Integers) -> Matrix:
        """Return the centres (k, 3) [m] of cells."""
        centres: Matrix = (unpacked(numbers).astype(np.float64) + 0.5) * self.resolution
        return centres

    def emptied(self, bodies: Sequence[PlacedSolid]) -> OccupancyMap:
        """
        Return the map without the occupied cells inside of bodies.

        :param bodies: in the frame of the map, grown by what a cell reaches out of its centre.
        """
        which = np.flatnonzero(self.log_odds >= 0.0)
        gone = which[inside_any(self._centres(self._numbers[which]), bodies)]
        if not len(gone):
            return self
        odds = self.log_odds.copy()
        odds[gone] = LOWEST
        return OccupancyMap(self.resolution, self._numbers, odds)


def packed(cells: Integers) -> Integers:
    """Return packed numbers (k,) of cells (k, 3), 0 at the lowest corner of the map."""
    numbers: Integers = (cells.astype(np.int64) << np.array([2 * _BITS, _BITS, 0])).sum(axis=-1)
    return numbers


def unpacked(numbers: Integers) -> Integers:
    """Return cells (k, 3), 0 at the origin, from packed numbers (k,)."""
    mask = (1 << _BITS) - 1
    cells: Integers = np.stack(
        [numbers >> 2 * _BITS, numbers >> _BITS & mask, numbers & mask], axis=-1) - MIDDLE
    return cells


#: Most bins along a direction, and rays in a bin on average.
_MOST_BINS, _RAYS_OF_A_BIN = 320, 4.0
#: Slopes [m/m] up to which all rays are those of a camera, which looks along z.
_CAMERA = 4.0


class Rays:
    """
    Rays from a sensor, sorted into bins by their directions.

    A cell is crossed where all rays of the bin of its centre end behind it. Where only some of
    them do, at the edge of something nearer, one of these has to pass its centre closely. Where
    the centre is beside the picture, one of the nearest bin has to pass through the cell.

    :param points: (k, 3) [m] in the sensor's frame.
    :param lengths: (k,) of the rays to them [m].
    :param beyond: (j, 3) [m] ends of other rays.
    """

    def __init__(self, points: Floats, lengths: Floats, beyond: Floats) -> None:
        self._ways = np.ascontiguousarray((np.concatenate([points, beyond]) if len(beyond)
                                           else points).T)
        self._ends = np.concatenate(
            [lengths, np.linalg.norm(beyond, axis=1)]).astype(np.float32)
        ways = self._ways
        across, along, depth = np.abs(ways[0]), np.abs(ways[1]), _CAMERA * ways[2]
        self._camera = bool(len(self._ends)) and bool(
            ((across < depth) & (along < depth)).all())
        places = self._places(ways)
        self._low = places.min(axis=1, initial=np.inf)[:, None]
        width = np.maximum(places.max(axis=1, initial=-np.inf)[:, None] - self._low, 1e-6)
        self._count = int(np.clip(np.sqrt(len(self._ends) / _RAYS_OF_A_BIN), 1, _MOST_BINS))
        self._per_unit = (self._count - 1e-3) / width
        self._nearest = np.full(self._count ** 2, np.inf, dtype=np.float32)
        self._farthest = np.full(self._count ** 2, -np.inf, dtype=np.float32)
        self._of_ray = self._bins(places) if len(self._ends) else np.zeros(0, dtype=np.int64)
        np.minimum.at(self._nearest, self._of_ray, self._ends)
        np.maximum.at(self._farthest, self._of_ray, self._ends)

    def cross(self, centres: Matrix, radius: float, axes: Matrix) -> Mask:
        """
        Return which cells rays cross before their ends.

        :param centres: (k, 3) [m] of the cells in the sensor's frame.
        :param radius: [m] of the sphere around a cell.
        :param axes: (3, 3) of the sensor in the frame of the cells' edges.
        """
        found = np.zeros(len(centres), dtype=bool)
        seen = np.flatnonzero(centres[:, 2] > 0.0) if self._camera else np.arange(len(centres))
        places = self._places(centres[seen].T)
        scaled = (places - self._low) * self._per_unit
        if not len(self._ends):
            return found
        distances = np.linalg.norm(centres[seen], axis=1)
        inner = np.clip(scaled, 0.0, self._count - 1e-3)
        beside = (np.abs(scaled - inner) / self._per_unit).max(axis=0) * distances
        near = beside <= radius
        seen, beside, far = seen[near], beside[near] > 0.0, distances[near] + radius
        columns = inner[:, near].astype(np.int64)
        bins = columns[0] * self._count + columns[1]
        some = self._farthest[bins] > far
        all_of_them = some & (self._nearest[bins] > far) & ~beside
        found[seen[all_of_them]] = True
        edge = some & ~all_of_them
        if edge.any():
            found[seen[edge]] = self._passed(
                centres[seen[edge]], bins[edge], far[edge], radius, beside[edge], axes)
        return found

    def _passed(
        self, centres: Matrix, bins: Integers, far: Vector, radius: float, beside: Mask,
        axes: Matrix,
    ) -> Mask:
        """Return which cells have a ray of their bin that ends behind and passes them."""
        asked = np.zeros(len(self._nearest), dtype=bool)
        asked[bins] = True
        rays = np.flatnonzero(asked[self._of_ray])
        rays = rays[np.argsort(self._of_ray[rays], kind='stable')]
        sorted_bins = self._of_ray[rays]
        begin = np.searchsorted(sorted_bins, bins)
        count = np.searchsorted(sorted_bins, bins, side='right') - begin
        cell = np.repeat(np.arange(len(bins)), count)
        ray = rays[np.arange(len(cell)) - np.repeat(np.cumsum(count) - count - begin, count)]
        ways = self._ways[:, ray].astype(np.float64).T
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        apart = np.linalg.norm(np.cross(ways, centres[cell]), axis=1)
        # Within the sphere inside of the cell.
        half = radius / np.sqrt(3.0)
        passed = (apart <= half) & (self._ends[ray] > far[cell])
        beside = beside[cell] & (apart <= radius) & (self._ends[ray] > far[cell])
        turned, middles = ways[beside] @ axes.T, centres[cell[beside]] @ axes.T
        # A ray along a face is not in the cell.
        with np.errstate(divide='ignore', invalid='ignore'):
            faces = np.stack([(middles - half) / turned, (middles + half) / turned])
        passed[beside] = faces.min(axis=0).max(axis=1) <= faces.max(axis=0).min(axis=1)
        found = np.zeros(len(bins), dtype=bool)
        found[cell[passed]] = True
        return found

    def _places(self, ways: Matrix | Floats) -> Matrix:
        """Return coordinates (2, k) of directions (3, k): slopes of a camera, else angles."""
        if self._camera:
            slopes: Matrix = ways[:2] / ways[2]
            return slopes
        return np.stack([np.arctan2(ways[1], ways[0]),
                         np.arctan2(ways[2], np.hypot(ways[0], ways[1]))])

    def _bins(self, places: Matrix) -> Integers:
        columns = ((places - self._low) * self._per_unit).astype(np.int64)
        numbers: Integers = columns[0] * self._count + columns[1]
        return numbers
