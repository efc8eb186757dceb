# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of the formats that a library reads."""

import numpy as np
import pytest
import trimesh

from armsim_ros.model import meshes
from armsim_ros.model.meshes import load_mesh

COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="x" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 100 0 0 0 200 0 0 0 300</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>10 0 0</translate>
<scale>2 1 1</scale><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep what is read in a folder of the test's own."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    return tmp_path / 'cache'


def box(mesh):
    """Return the corners of a mesh's bounding box."""
    return np.array([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])


@pytest.mark.parametrize('up', ['X_UP', 'Y_UP', 'Z_UP'])
def test_unit_and_nodes_apply_and_the_up_axis_does_not(tmp_path, up):
    """A COLLADA file has the extents of its STL twin to a millimetre."""
    (tmp_path / 'a.DAE').write_text(COLLADA.format(unit='0.001', up=up))
    mesh = load_mesh('a.DAE', (1.0, 1.0, -1.0), base=tmp_path)
    assert box(mesh) == pytest.approx(np.array([[0.01, 0, -0.3], [0.21, 0.2, 0]]), abs=1e-3)
    assert len(mesh.triangles) == 4


@pytest.mark.parametrize('ending', ['glb', 'ply'])
def test_other_formats(tmp_path, ending):
    """What Assimp reads has the size that was written."""
    trimesh.creation.box((0.2, 0.4, 0.6)).export(tmp_path / f'a.{ending}')
    mesh = load_mesh(f'a.{ending}', base=tmp_path)
    assert box(mesh)[1] == pytest.approx([0.1, 0.2, 0.3], abs=1e-6)


def test_a_mesh_is_read_once(tmp_path, cache, monkeypatch):
    """The second time it comes from the cache; a changed file is read anew."""
    file = tmp_path / 'a.dae'
    file.write_text(COLLADA.format(unit='1', up='Z_UP'))
    first = load_mesh('a.dae', base=tmp_path)
    read = meshes._read
    monkeypatch.setattr(meshes, '_read', None)
    again = load_mesh('a.dae', base=tmp_path)
    np.testing.assert_array_equal(first.vertices, again.vertices)
    np.testing.assert_array_equal(first.triangles, again.triangles)
    monkeypatch.setattr(meshes, '_read', read)
    file.write_text(COLLADA.format(unit='0.1', up='Z_UP'))
    assert box(load_mesh('a.dae', base=tmp_path))[1][2] == pytest.approx(30.0)
    assert len(list((cache / 'armsim_ros/meshes').iterdir())) == 2


def test_a_broken_cache_is_no_obstacle(tmp_path, cache):
    """What was cut off is read again, and a folder that cannot be written is left alone."""
    (tmp_path / 'a.dae').write_text(COLLADA.format(unit='1', up='Z_UP'))
    load_mesh('a.dae', base=tmp_path)
    (kept,) = (cache / 'armsim_ros/meshes').iterdir()
    kept.write_bytes(kept.read_bytes()[:100])
    assert len(load_mesh('a.dae', base=tmp_path).triangles) == 4


def test_no_cache_folder(tmp_path, monkeypatch):
    """A home that is a file keeps nobody from reading a mesh."""
    (tmp_path / 'file').touch()
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    (tmp_path / 'a.dae').write_text(COLLADA.format(unit='1', up='Z_UP'))
    assert len(load_mesh('a.dae', base=tmp_path).triangles) == 4
