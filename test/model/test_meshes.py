"""Mesh files: STL in both forms, OBJ, and what is said of others."""

import struct

import numpy as np
import pytest

from armsim_ros.errors import ResourceError
from armsim_ros.model.meshes import load_mesh

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def binary_stl():
    """Return a tetrahedron as binary STL, whose header begins with 'solid' as some do."""
    data = b'solid binary'.ljust(80, b' ') + struct.pack('<I', len(FACES))
    for face in FACES:
        data += struct.pack('<12fH', 0, 0, 0, *CORNERS[list(face)].ravel(), 0)
    return data


def text_stl():
    """Return the same as text."""
    facets = ''.join('facet normal 0 0 0\n outer loop\n' + ''.join(
        '  vertex {} {} {}\n'.format(*CORNERS[index]) for index in face)
        + ' endloop\nendfacet\n' for face in FACES)
    return f'solid t\n{facets}endsolid t\n'.encode()


def obj():
    """Return the same as OBJ, one index counted from the end."""
    lines = ['v {} {} {}'.format(*corner) for corner in CORNERS]
    lines += ['f ' + ' '.join(f'{index + 1}//1' for index in face) for face in FACES[:3]]
    return '\n'.join([*lines, 'f -3 -2 -1']).encode()


def signed_volume(mesh):
    """Return the volume by the divergence theorem; below 0 where triangles face inwards."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return float(np.einsum('ij,ij->i', a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize(('name', 'data'), [
    ('t.stl', binary_stl()), ('T.STL', text_stl()), ('t.obj', obj())])
def test_the_same_tetrahedron_from_each_form(tmp_path, name, data):
    """Vertices are joined, triangles face outwards, the scale is applied."""
    (tmp_path / name).write_bytes(data)
    mesh = load_mesh(name, (2.0, 1.0, 1.0), base=tmp_path)
    assert sorted(map(tuple, mesh.vertices)) == sorted(map(tuple, CORNERS * (2, 1, 1)))
    assert len(mesh.triangles) == 4
    assert signed_volume(mesh) == pytest.approx(2 / 6)
    assert mesh.uri == name


def test_a_mirrored_mesh_still_faces_outwards(tmp_path):
    """A negative scale turns the triangles round."""
    (tmp_path / 't.stl').write_bytes(binary_stl())
    assert signed_volume(load_mesh('t.stl', (-1.0, 1.0, 1.0), base=tmp_path)) > 0.0


def test_packages(tmp_path):
    """package:// is looked up in the folders given."""
    folder = tmp_path / 'my_description' / 'meshes'
    folder.mkdir(parents=True)
    (folder / 't.stl').write_bytes(binary_stl())
    mesh = load_mesh('package://my_description/meshes/t.stl', packages=[tmp_path])
    assert len(mesh.vertices) == 4


@pytest.mark.parametrize(('name', 'data', 'message'), [
    ('t.step', b'x', r"mesh 't.step': \.step is not read; allowed: \.stl, \.obj, \.dae.*convert"),
    ('t.dae', b'<COLLADA/>', r"mesh 't.dae' cannot be read"),
    ('t.stl', b'short', 'cannot be read: 5 bytes do not fit'),
    ('t.stl', b'solid x\nendsolid x\n' * 9, 'has no triangles'),
    ('t.stl', b'B' + binary_stl()[1:-7], 'do not fit the 4 triangles that it announces'),
    ('t.obj', b'v 0 0 0\nf 1 2 3\n', 'a face names a vertex that is not there'),
    ('t.obj', b'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n', "mesh 't.obj' has no surface"),
    ('t.obj', b'v 0 nan 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n', 'has a vertex that is not finite'),
])
def test_a_file_that_is_no_mesh(tmp_path, name, data, message):
    """The message names the mesh and what is wrong."""
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ResourceError, match=message):
        load_mesh(name, base=tmp_path)


def test_a_mesh_that_is_not_there(tmp_path):
    """A missing file and a missing package are named."""
    with pytest.raises(ResourceError, match=r'gone\.stl'):
        load_mesh('gone.stl', base=tmp_path)
    with pytest.raises(ResourceError, match="package 'no_such_package' is not found"):
        load_mesh('package://no_such_package/a.stl')
