# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Rays of a measurement, and which cells they cross."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.planning.scene.octree_data import Floats, Integers

#: Most bins along a direction, and rays in a bin on average.
_MOST_BINS, _RAYS_OF_A_BIN = 320, 4.0
#: Slopes [m/m] up to which all rays are those of a camera, which looks along z.
_CAMERA = 4.0


class Rays:
    """
    Rays from a sensor, sorted into bins by their directions.

    A cell is crossed where all rays of the bin of its centre end behind it. Where only some of
    them do, at the edge of something nearer, one of these has to pass its centre closely.

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

    def cross(self, centres: Matrix, radius: float) -> Mask:
        """
        Return which cells rays cross before their ends.

        :param centres: (k, 3) [m] of the cells in the sensor's frame.
        :param radius: [m] of the sphere around a cell.
        """
        found = np.zeros(len(centres), dtype=bool)
        seen = np.flatnonzero(centres[:, 2] > 0.0) if self._camera else np.arange(len(centres))
        places = self._places(centres[seen].T)
        scaled = (places - self._low) * self._per_unit
        within = ((scaled >= 0) & (scaled < self._count)).all(axis=0)
        seen, bins = seen[within], self._bins(places[:, within])
        far = np.linalg.norm(centres[seen], axis=1) + radius
        some = self._farthest[bins] > far
        all_of_them = some & (self._nearest[bins] > far)
        found[seen[all_of_them]] = True
        edge = some & ~all_of_them
        if edge.any():
            found[seen[edge]] = self._passed(centres[seen[edge]], bins[edge], far[edge], radius)
        return found

    def _passed(self, centres: Matrix, bins: Integers, far: Vector, radius: float) -> Mask:
        """Return which cells have a ray of their bin that ends behind and passes the centre."""
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
        passed = (apart <= radius / np.sqrt(3.0)) & (self._ends[ray] > far[cell])
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
