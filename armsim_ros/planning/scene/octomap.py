# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An occupancy map of the world: cells that cameras have seen occupied or free."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
import math
import re

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.scene.octree_data import (
    DEPTH,
    Floats,
    Integers,
    Leaves,
    read_leaves,
    write_binary,
    write_full,
)

#: The class of tree that planning reads; others hold colours or times, too.
TREE = 'OcTree'
#: A cell's number at the origin of the map.
MIDDLE = 1 << (DEPTH - 1)
#: Edges of cells that are used [m].
SMALLEST_CELL, LARGEST_CELL = 1e-4, 1e3

_FILE_HEADER = b'# Octomap OcTree binary file'
_SIZE_LINE = re.compile(rb'^size (\d+)$', re.MULTILINE)


def _identity() -> Matrix:
    return np.eye(4)


@dataclass(frozen=True, eq=False)
class Octomap:
    """
    Cells of space that are occupied or free; immutable.

    :param resolution: edge of a cell [m].
    :param leaves: of the octree that holds the cells.
    :param pose: (4, 4) of the map in the model frame; cells lie along its axes.
    """

    resolution: float
    leaves: Leaves
    pose: Matrix = field(default_factory=_identity)

    @cached_property
    def boxes(self) -> tuple[Matrix, Vector]:
        """Centres (k, 3) [m] in the frame of the map and edges (k,) [m] of occupied leaves."""
        which = self.leaves.occupied
        corners, levels = self.leaves.corners[which], self.leaves.levels[which]
        if len(levels) == 1 and levels[0] == DEPTH:  # the root: its middle is a corner of cells
            corners = (np.arange(8)[:, None] >> np.arange(3) & 1) * MIDDLE
            levels = np.full(8, DEPTH - 1)
        edges: Vector = self.resolution * (1 << levels).astype(np.float64)
        low = (corners - MIDDLE) * self.resolution
        centres: Matrix = low + 0.5 * edges[:, None]
        return centres, edges

    @property
    def empty(self) -> bool:
        """Whether no cell is occupied or free."""
        return not len(self.leaves.levels)

    def full_data(self) -> bytes:
        """Return the tree in the full form of a message."""
        return write_full(self.leaves)


def octomap_from_cells(
    keys: Integers, log_odds: Floats, resolution: float, pose: Matrix
) -> Octomap:
    """
    Return the map of single cells.

    :param keys: (k, 3) numbers of the cells; 0 is the one whose lowest corner is the origin.
    :param log_odds: (k,) of occupancy.
    :param resolution: edge of a cell [m].
    :param pose: (4, 4) of the map in the model frame.
    """
    levels = np.zeros(len(keys), dtype=np.int64)
    return Octomap(resolution, Leaves(keys + MIDDLE, levels, log_odds), pose)


def read_octomap(
    data: bytes, *, tree: str, binary: bool, resolution: float, pose: Matrix
) -> Octomap:
    """
    Return the map of a message or file.

    :param data: the tree, at least a byte.
    :param tree: the name of its class.
    :param binary: whether it is in the binary form.
    :param resolution: edge of a cell [m].
    :param pose: (4, 4) of the map in the model frame.
    :raises PlanningError: FAILURE for another kind of tree, a resolution that is not allowed, and
        for damaged data with the byte's position.
    """
    if tree != TREE:
        raise octomap_error(f"the tree is of class '{tree}'; allowed: '{TREE}'")
    if not (math.isfinite(resolution) and SMALLEST_CELL <= resolution <= LARGEST_CELL):
        raise octomap_error(f'the resolution is {resolution} m; allowed: {SMALLEST_CELL:g} to '
                            f'{LARGEST_CELL:g} m')
    try:
        leaves = read_leaves(data, binary=binary)
    except ValueError as error:
        form = 'binary' if binary else 'full'
        raise octomap_error(f'the data is not a tree in the {form} form: {error}; the map stays '
                            'as it was') from None
    return Octomap(float(resolution), leaves, pose)


def octomap_error(text: str) -> PlanningError:
    """Return the error for a map that cannot be used."""
    return PlanningError(MoveItErrorCode.FAILURE, f'octomap: {text}', 'planning scene')


def write_map_file(octomap: Octomap) -> bytes:
    """Return the content of a ``.bt`` file as OctoMap writes it."""
    data, nodes = write_binary(octomap.leaves)
    header = (f'{_FILE_HEADER.decode()}\n# cells in the frame of the map\nid {TREE}\n'
              f'size {nodes if data else 0}\nres {octomap.resolution:g}\ndata\n')
    return header.encode() + data


def read_map_file(content: bytes, pose: Matrix) -> Octomap:
    """
    Return the map of a ``.bt`` file.

    :param pose: (4, 4) to put it at in the model frame.
    :raises PlanningError: FAILURE where it is not such a file.
    """
    header, found, data = content.partition(b'\ndata\n')
    if not content.startswith(_FILE_HEADER) or not found:
        raise octomap_error(
            f"the file does not begin with '{_FILE_HEADER.decode()}'; only .bt files are read")
    lines = dict(line.split(None, 1) for line in header.splitlines()
                 if line[:1] != b'#' and len(line.split()) == 2)
    try:
        resolution, tree = float(lines[b'res']), lines[b'id'].decode()
    except (KeyError, ValueError):
        raise octomap_error("the file's header lacks a line 'id' or 'res'") from None
    size = _SIZE_LINE.search(header)
    if not data and size is not None and int(size[1]) == 0:
        none = np.zeros(0, dtype=np.int64)
        return Octomap(resolution, Leaves(none.reshape(0, 3), none, none.astype(np.float32)), pose)
    return read_octomap(data, tree=tree, binary=True, resolution=resolution, pose=pose)


@dataclass(frozen=True, slots=True, eq=False)
class OctomapUpdate:
    """
    A map that takes the place of the scene's.

    :param octomap: None takes the map away; its pose is in ``frame_id``.
    :param frame_id: '' is the model frame.
    """

    octomap: Octomap | None = None
    frame_id: str = ''
