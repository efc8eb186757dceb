# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the cells of an octomap are to be drawn."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('viser')

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.web.parts.octomap import OctomapDrawing
from armsim_ros.planning.scene.octomap import Octomap
from armsim_ros.planning.scene.octree_data import Leaves, read_leaves, write_full


class Scene:
    """Notes what is drawn."""

    def __init__(self):
        self.drawn = []

    def add_batched_meshes_simple(self, name, vertices, faces, turns, centres, **options):
        node = SimpleNamespace(
            name=name, centres=centres, size=np.ptp(vertices, axis=0), **options)
        node.remove = lambda: self.drawn.remove(node)
        self.drawn.append(node)
        return node


def octomap():
    """Return a full cube of two cells to a side, a cell above it, and a free one."""
    cube = np.stack(np.meshgrid(*[np.arange(2)] * 3), -1).reshape(-1, 3)
    corners = np.vstack([cube, [[0, 0, 4], [0, 0, 6]]]) + (1 << 15)
    odds = np.array([1.0] * 9 + [-1.0], dtype=np.float32)
    leaves = Leaves(corners, np.zeros(10, dtype=np.int64), odds)
    return Octomap(0.1, read_leaves(write_full(leaves), binary=False), pose_matrix((1, 0, 0)))


def test_each_occupied_leaf_is_a_box():
    """At its place and of its size, coloured by its height; below the frame of the map."""
    scene = Scene()
    assert OctomapDrawing(scene).show(octomap(), '/world') == 2
    node, = scene.drawn
    assert node.name == '/world/octomap'
    order = np.argsort(node.centres[:, 2])
    assert np.allclose(node.centres[order], [[0.1, 0.1, 0.1], [0.05, 0.05, 0.45]])
    assert np.allclose(node.size * node.batched_scales[order][:, None], [[0.2] * 3, [0.1] * 3])
    assert np.allclose(node.position, [1, 0, 0])
    assert (node.batched_colors[order[0]] != node.batched_colors[order[1]]).any()


def test_a_map_takes_the_place_of_the_last():
    """None draws nothing."""
    scene = Scene()
    drawing = OctomapDrawing(scene)
    drawing.show(octomap(), '')
    drawing.show(octomap(), '')
    assert len(scene.drawn) == 1
    assert drawing.show(None, '') == 0
    assert not scene.drawn
