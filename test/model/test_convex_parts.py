# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes as convex parts."""

import numpy as np
import pytest
import trimesh

from armsim_ros.model import meshes as module
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.meshes import convex_parts, MOST_PARTS


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep parts in a folder of the test's own."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))


@pytest.fixture
def ring():
    """Return a ring of 0.1 m with a hole of 0.07 m, 0.04 m high."""
    found = trimesh.creation.annulus(0.07, 0.1, 0.04)
    return Mesh(np.array(found.vertices), np.array(found.faces))


def contains(mesh, point, margin=0.0):
    """Whether a mesh's convex hull, made larger by a margin [m], contains a point."""
    hull = trimesh.convex.convex_hull(mesh.vertices)
    offsets = np.asarray(point) - hull.triangles[:, 0]
    return bool((np.einsum('ij,ij->i', offsets, hull.face_normals) <= margin).all())


def test_the_hole_of_a_ring_stays_open(ring):
    """Parts fill the ring to a few millimetres and leave its hole free; its hull does not."""
    parts = convex_parts(ring)
    assert 4 <= len(parts) <= MOST_PARTS
    assert contains(ring, (0.0, 0.0, 0.0))
    assert not any(contains(part, (0.0, 0.0, 0.0)) for part in parts)
    for angle in np.arange(0.0, 2.0 * np.pi, 0.5):
        point = (0.085 * np.cos(angle), 0.085 * np.sin(angle), 0.0)
        assert any(contains(part, point, 0.004) for part in parts), point


def test_parts_are_made_once(ring, monkeypatch):
    """The second time they come from the cache, the same to the last bit."""
    first = convex_parts(ring)
    monkeypatch.setattr(module, '_decompose', None)
    for one, other in zip(first, convex_parts(ring), strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.triangles, other.triangles)


def test_a_flat_mesh_has_no_parts():
    """What encloses nothing cannot be cut."""
    flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float), np.array([[0, 1, 2]]))
    assert convex_parts(flat) == ()
