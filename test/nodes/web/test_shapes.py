# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes as coloured triangles."""

import numpy as np
import pytest

trimesh = pytest.importorskip('trimesh')

from armsim_ros.errors import ResourceError  # noqa: E402
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Mesh, Plane, Sphere  # noqa: E402
from armsim_ros.model.robot_model import Link, LinkGeometry  # noqa: E402
from armsim_ros.nodes.web.shapes import parts_of_file, ShapeReader  # noqa: E402


def extent(part):
    """Return the sides of the box around a part [m]."""
    return np.ptp(part.vertices, axis=0)


@pytest.mark.parametrize(('shape', 'sides'), [
    (Box((0.1, 0.2, 0.3)), (0.1, 0.2, 0.3)),
    (Sphere(0.5), (1.0, 1.0, 1.0)),
    (Cylinder(0.1, 0.4), (0.2, 0.2, 0.4)),
    (Cone(0.1, 0.4), (0.2, 0.2, 0.4)),
    (Capsule(0.1, 0.4), (0.2, 0.2, 0.6)),
    (Plane(0.0, 0.0, 1.0, 0.0), (4.0, 4.0, 0.0)),
])
def test_a_shape_has_its_size_and_its_place(shape, sides):
    """Around its own frame, as messages and URDF have it."""
    (part,) = ShapeReader().parts(shape)
    assert extent(part) == pytest.approx(sides, abs=0.02)
    assert part.vertices.min(axis=0) + part.vertices.max(axis=0) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize('kind', ['stl', 'obj', 'ply', 'glb', 'dae'])
def test_mesh_files_of_all_kinds_are_read(kind):
    """COLLADA too, which most visual meshes are."""
    data = trimesh.creation.box((0.1, 0.2, 0.3)).export(file_type=kind)
    (part,) = parts_of_file(data.encode() if isinstance(data, str) else data, kind)
    assert sorted(extent(part)) == pytest.approx([0.1, 0.2, 0.3], abs=1e-6)


def test_a_mesh_is_scaled_and_mirrored(tmp_path):
    """A negative factor turns the triangles, so that outside stays outside."""
    file = tmp_path / 'box.stl'
    trimesh.creation.box((1.0, 1.0, 1.0)).export(file)
    (part,) = ShapeReader().parts(
        Mesh(np.array([[0.001, 0.002, -0.003]]), np.zeros((0, 3), np.int64), str(file)))
    assert extent(part) == pytest.approx((0.001, 0.002, 0.003))
    assert trimesh.Trimesh(part.vertices, part.faces).volume > 0.0


def test_without_a_visual_shape_a_link_shows_its_collision_shape():
    """And says why, where a mesh is missing."""
    missing = Mesh(np.ones((1, 3)), np.zeros((0, 3), np.int64), 'package://nowhere/a.stl')
    box = LinkGeometry(Box((1.0, 1.0, 1.0)), np.eye(4))
    link = Link('a', collisions=(box,), visuals=(LinkGeometry(missing, np.eye(4)),))
    shapes, complaints = ShapeReader().shapes_of(link)
    assert [shape for shape, _ in shapes] == [box]
    assert 'nowhere' in complaints[0]


@pytest.mark.parametrize('name', ['/etc/passwd', 'file:///etc/hosts', '/dev/zero'])
def test_a_file_that_is_no_mesh_is_not_opened(name):
    """The page hands out no other file of the machine."""
    with pytest.raises(ResourceError, match='is not shown'):
        ShapeReader().parts(Mesh(np.ones((1, 3)), np.zeros((0, 3), np.int64), name))


def test_a_broken_mesh_file_is_named(tmp_path):
    """Its bytes do not fit."""
    file = tmp_path / 'broken.stl'
    file.write_bytes(b'\x00' * 90)
    with pytest.raises(ResourceError, match=r'broken\.stl'):
        ShapeReader().parts(Mesh(np.ones((1, 3)), np.zeros((0, 3), np.int64), str(file)))
