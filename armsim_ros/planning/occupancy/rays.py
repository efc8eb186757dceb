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
