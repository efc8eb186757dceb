# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Octomaps as coal checks them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from weakref import WeakKeyDictionary

import coal
import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.planning.scene.octomap import Octomap

#: A tree and its pose (4, 4) in the frame of the map.
PlacedTree = tuple[Any, Matrix]

_made: WeakKeyDictionary[Octomap, tuple[PlacedTree, ...]] = WeakKeyDictionary()


def octree_shapes(octomap: Octomap) -> tuple[PlacedTree, ...]:
    """
    Return the octrees of coal that are the occupied cells of a map, and where they are in it.

    coal's trees have leaves of one size. A leaf of several cells is a cell of a coarser tree: to
    divide it would take eight cells for each level. Made once for a map.
    """
    found = _made.get(octomap)
    if found is None:
        found = _made[octomap] = tuple(_trees(octomap))
    return found


def _trees(octomap: Octomap) -> Iterator[PlacedTree]:
    centres, edges = octomap.boxes
    for edge in np.unique(edges):
        own = centres[edges == edge]
        # About its middle a tree of 16 levels has eight branches of mostly empty nodes. With the
        # lowest cell at the middle it has a single chain of them.
        pose = np.eye(4)
        pose[:3, 3] = own.min(axis=0) - 0.5 * edge
        yield coal.makeOctree(np.ascontiguousarray(own - pose[:3, 3]), float(edge)), pose
