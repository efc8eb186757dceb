# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Octomaps as coal checks them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from weakref import WeakKeyDictionary

import coal
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.scene.octomap import Octomap

#: A tree and its pose (4, 4) in the frame of the map.
PlacedTree = tuple[Any, Matrix]
#: Trees that cells of a size are divided into: more of them gain nothing.
MOST_TREES = 4
#: Half the size of a link [m].
_LINK = 0.1

_made: WeakKeyDictionary[Octomap, tuple[PlacedTree, ...]] = WeakKeyDictionary()


def octree_shapes(octomap: Octomap) -> tuple[PlacedTree, ...]:
    """
    Return the octrees of coal that are the occupied cells of a map, and where they are in it.

    coal's trees have leaves of one size. A leaf of several cells is a cell of a coarser tree: to
    divide it would take eight cells for each level. Cells that are apart are in trees of their
    own. Made once for a map.
    """
    found = _made.get(octomap)
    if found is None:
        found = _made[octomap] = tuple(_trees(octomap))
    return found


def _trees(octomap: Octomap) -> Iterator[PlacedTree]:
    centres, edges = octomap.boxes
    for edge in np.unique(edges):
        for own in _clusters(centres[edges == edge]):
            # About its middle a tree of 16 levels has eight branches of mostly empty nodes. With
            # the lowest cell at the middle it has a single chain of them.
            pose = np.eye(4)
            pose[:3, 3] = own.min(axis=0) - 0.5 * edge
            yield coal.makeOctree(np.ascontiguousarray(own - pose[:3, 3]), float(edge)), pose


def _clusters(centres: Matrix) -> list[Matrix]:
    """
    Return cells (k, 3) [m] in parts whose bounding boxes hold little else.

    A link in the bounding box of a tree costs ten times as much as one outside, however few of
    the tree's cells are near.
    """
    parts = [(centres, *_best_cut(centres))]
    while len(parts) < MOST_TREES:
        parts.sort(key=lambda part: part[3])
        if parts[-1][3] <= 0.0:
            break
        cells, axis, at, _ = parts.pop()
        below = cells[:, axis] < at
        parts += [(half, *_best_cut(half)) for half in (cells[below], cells[~below])]
    return [part[0] for part in parts]


def _best_cut(centres: Matrix) -> tuple[int, float, float]:
    """Return axis and place [m] of the plane that saves most volume [m^3], and how much."""
    best = 0, 0.0, 0.0
    whole = _volume(centres.min(axis=0), centres.max(axis=0))
    for axis in range(3):
        cells = centres[np.argsort(centres[:, axis], kind='stable')]
        layers = np.flatnonzero(np.diff(cells[:, axis], prepend=-np.inf))
        lows, highs = (edge.reduceat(cells, layers) for edge in (np.minimum, np.maximum))
        below = _volume(np.minimum.accumulate(lows), np.maximum.accumulate(highs))
        above = _volume(np.minimum.accumulate(lows[::-1]), np.maximum.accumulate(highs[::-1]))
        saved = whole - below[:-1] - above[-2::-1]
        if len(saved) and saved.max() > best[2]:
            cut = layers[int(np.argmax(saved)) + 1]
            best = axis, float(cells[cut - 1:cut + 1, axis].mean()), float(saved.max())
    return best


def _volume(low: Matrix, high: Matrix) -> Vector:
    """Return where the middle of a link may be [m^3] for the link to be in bounding boxes."""
    volume: Vector = np.prod(high - low + 2.0 * _LINK, axis=-1)
    return volume
