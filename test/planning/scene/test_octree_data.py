# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Octrees in the serial forms of OctoMap, and data that is none."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.planning.scene.octomap import (
    octomap_from_cells,
    read_map_file,
    read_octomap,
    write_map_file,
)
from armsim_ros.planning.scene.octree_data import (
    HIGHEST,
    Leaves,
    LOWEST,
    read_leaves,
    write_binary,
    write_full,
)

CELLS = st.lists(
    st.tuples(*[st.one_of(st.integers(-3, 3), st.integers(-32768, 32767))] * 3),
    min_size=1, max_size=60, unique=True)


def tree(keys, values):
    """Return the leaves of single cells about the middle."""
    return octomap_from_cells(
        np.array(keys), np.array(values, dtype=np.float32), 0.1, np.eye(4)).leaves


def as_cells(leaves):
    """Return all cells that leaves of up to eight cells fill -> log odds."""
    return {
        (x + dx, y + dy, z + dz): value
        for (x, y, z), level, value in zip(
            leaves.corners.tolist(), leaves.levels.tolist(), leaves.log_odds.tolist(), strict=True)
        for dx in range(1 << level) for dy in range(1 << level) for dz in range(1 << level)
    }


def recursive(leaves):
    """Return the full form, written as OctoMap's recursion writes it, without pruning."""
    cells = {tuple(key): value for key, value in zip(
        leaves.corners.tolist(), leaves.log_odds, strict=True)}

    def node(inside, level):
        if level == 0:
            return next(iter(inside.values())), np.float32(next(iter(inside.values()))
                                                           ).tobytes() + b'\0'
        parts = {}
        for key, value in inside.items():
            child = sum((key[axis] >> level - 1 & 1) << axis for axis in range(3))
            parts.setdefault(child, {})[key] = value
        made = [node(parts[child], level - 1) for child in sorted(parts)]
        highest = max(value for value, _ in made)
        mask = sum(1 << child for child in parts)
        return highest, np.float32(highest).tobytes() + bytes([mask]) + b''.join(
            text for _, text in made)

    return node(cells, 16)[1]


@settings(max_examples=60, deadline=None)
@given(keys=CELLS, seed=st.integers(0, 99))
def test_full_form_is_that_of_the_recursion(keys, seed):
    """Nodes come depth first with the highest log odds of their children."""
    values = np.random.default_rng(seed).uniform(-2, 3.5, len(keys))
    leaves = tree(keys, values)
    assert write_full(leaves) == recursive(leaves)
    assert as_cells(read_leaves(write_full(leaves), binary=False)) == as_cells(leaves)


@settings(max_examples=60, deadline=None)
@given(keys=CELLS, seed=st.integers(0, 99))
def test_binary_form_keeps_what_is_occupied(keys, seed):
    """All else that is known is free."""
    values = np.random.default_rng(seed).uniform(-2, 3.5, len(keys))
    read = as_cells(read_leaves(write_binary(tree(keys, values))[0], binary=True))
    assert read == {key: np.float32(HIGHEST if value >= 0 else LOWEST)
                    for key, value in as_cells(tree(keys, values)).items()}


def test_eight_equal_leaves_are_one():
    """A full cube of cells is pruned level by level."""
    cube = np.stack(np.meshgrid(*[np.arange(4)] * 3), -1).reshape(-1, 3)
    read = read_leaves(write_full(tree(cube, np.full(64, 3.5))), binary=False)
    assert read.levels.tolist() == [2]
    assert read.corners.tolist() == [[32768] * 3]
    other = np.full(64, 3.5)
    other[5] = 1.0
    assert len(read_leaves(write_full(tree(cube, other)), binary=False).levels) == 15


def test_whole_space_is_a_leaf():
    """The root alone is all space; the binary form has it as eight children."""
    root = Leaves(np.zeros((1, 3), dtype=np.int64), np.array([16]),
                  np.array([3.0], dtype=np.float32))
    assert read_leaves(write_full(root), binary=False).levels.tolist() == [16]
    assert read_leaves(write_binary(root)[0], binary=True).levels.tolist() == [15] * 8
    assert len(write_full(Leaves(root.corners[:0], root.levels[:0], root.log_odds[:0]))) == 0


def test_file_of_octomap_is_read_and_written():
    """A .bt file has a header in lines."""
    octomap = octomap_from_cells(
        np.array([[0, 0, 0], [-5, 2, 9]]), np.array([1.0, -1.0], dtype=np.float32), 0.025,
        np.eye(4))
    content = write_map_file(octomap)
    assert content.startswith(b'# Octomap OcTree binary file\n')
    assert b'\nid OcTree\nsize 33\nres 0.025\ndata\n' in content
    read = read_map_file(content, np.eye(4))
    assert read.resolution == 0.025
    assert np.allclose(read.boxes[0], [[0.0125] * 3])


GOOD = write_full(tree([(0, 0, 0), (1, 5, 9)], [1.0, -1.0]))
BINARY = write_binary(tree([(0, 0, 0), (1, 5, 9)], [1.0, -1.0]))[0]


@pytest.mark.parametrize(('data', 'binary', 'text'), [
    (GOOD[:-1], False, 'ends in the middle of a node of 5 bytes'),
    (GOOD[:-5], False, r'ends at byte \d+, where 1 more nodes'),
    (GOOD + GOOD, False, rf'complete at byte {len(GOOD)}'),
    (GOOD[:5] + np.float32(np.nan).tobytes() + GOOD[9:], False, 'log odds at byte 5 are nan'),
    ((b'\0\0\0\0\1' * 17) + b'\0\0\0\0\0', False, 'byte 80 has children below'),
    (BINARY[:-1], True, 'ends in the middle of a node of 2 bytes'),
    (BINARY[:-2], True, 'where 1 more nodes'),
    (BINARY + b'\0\0', True, 'complete at byte'),
    (b'\3\0' * 17 + b'\2\0', True, 'below the 16 levels'),
])
def test_damaged_data_is_refused_with_the_place(data, binary, text):
    """The sentence says where the tree is wrong."""
    with pytest.raises(PlanningError, match=text):
        read_octomap(data, tree='OcTree', binary=binary, resolution=0.1, pose=np.eye(4))


@settings(max_examples=200, deadline=None)
@given(data=st.binary(min_size=1, max_size=200), binary=st.booleans())
def test_random_data_gives_leaves_or_an_error(data, binary):
    """Nothing but a PlanningError is raised, and nothing takes long."""
    try:
        octomap = read_octomap(
            data, tree='OcTree', binary=binary, resolution=0.1, pose=np.eye(4))
    except PlanningError:
        return
    assert (octomap.leaves.levels >= 0).all()


@pytest.mark.parametrize(('tree_class', 'resolution', 'text'), [
    ('ColorOcTree', 0.1, "class 'ColorOcTree'; allowed: 'OcTree'"),
    ('OcTree', 0.0, 'resolution is 0.0 m'),
    ('OcTree', float('nan'), 'resolution is nan m'),
])
def test_unusable_maps_are_refused(tree_class, resolution, text):
    """Another class of tree and a cell without a size are errors."""
    with pytest.raises(PlanningError, match=text):
        read_octomap(GOOD, tree=tree_class, binary=False, resolution=resolution, pose=np.eye(4))
