# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects without thickness, and objects that cannot be."""

import numpy as np
import pytest

from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Box, Mesh, Sphere
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.geoms import LEAST_THICKNESS, volume
from armsim_ros.sim.simulation import Simulation

CORNERS = 0.5 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
UP = np.array([0.0, 0.0, 1.0])
SHEET = np.array([[0, 1, 2], [0, 2, 3]])
BOX = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], *(
    corners for k in range(4) for corners in ([k, (k + 1) % 4, 4 + (k + 1) % 4],
                                              [k, 4 + (k + 1) % 4, 4 + k]))])
FLAT = {
    'triangle': Mesh(CORNERS[:3], SHEET[:1]),
    'one side': Mesh(CORNERS, SHEET),
    'two sides': Mesh(CORNERS, np.vstack([SHEET, SHEET[:, ::-1]])),
    'box of zero thickness': Mesh(np.vstack([CORNERS, CORNERS]), BOX),
}
ANGLES = np.linspace(0.0, np.pi, 9)
ARCH = np.array([[np.cos(angle), y, np.sin(angle)] for angle in ANGLES for y in (0.0, 1.0)])
STRIP = np.array([[k, k + 1, k + 2] if k % 2 else [k + 1, k, k + 2] for k in range(16)])
INERTIAL = Inertial(0.5, np.eye(4), np.diag([1e-3, 1e-3, 2e-3]))


@pytest.fixture
def world(arm, settings):
    """Return the world of an arm, without objects."""
    return Simulation(arm, settings).world


def thing(name, geometry, xyz=(3.0, 0.0, 0.1), mass=None, **fields):
    """Return an object of one shape."""
    return WorldObject(
        name, pose_matrix(xyz), (LinkGeometry(geometry, np.eye(4)),), mass, **fields)


@pytest.mark.parametrize('kind', FLAT)
@pytest.mark.parametrize(('mass', 'inertial'), [(None, None), (0.1, None), (0.5, INERTIAL)])
def test_a_flat_mesh_is_a_thin_sheet(arm, settings, kind, mass, inertial):
    """However many sides it has, it is a shape like any other: a ball lies on it."""
    simulation = Simulation(arm, settings)
    simulation.world.add(thing('sheet', FLAT[kind], mass=mass, inertial=inertial))
    simulation.world.add(thing('marble', Sphere(0.05), (3.1, -0.1, 0.2), 0.1))
    for _ in range(1000):
        simulation.step()
    height = 0.1 if mass is None else 0.0
    assert simulation.world.pose('marble')[2, 3] == pytest.approx(height + 0.05, abs=2e-3)


@pytest.mark.parametrize('kind', ['one side', 'two sides', 'box of zero thickness'])
@pytest.mark.parametrize('height', [0.0, 2.0])
def test_a_flat_mesh_has_the_volume_of_its_sheet(kind, height):
    """Its sides do not matter, nor where it is."""
    mesh = FLAT[kind]
    moved = Mesh(mesh.vertices + height * UP, mesh.triangles)
    # MuJoCo's vertices have single precision.
    assert volume(moved) == pytest.approx(1.0 * LEAST_THICKNESS, rel=0.01)


def test_a_bent_sheet_with_two_sides_has_the_volume_of_its_hull():
    """It encloses nothing, and the physics takes its hull."""
    arch = Mesh(ARCH, np.vstack([STRIP, STRIP[:, ::-1]]))
    assert volume(arch) == pytest.approx(0.5 * np.pi, rel=0.03)


def test_a_solid_mesh_has_the_volume_that_it_encloses():
    """A box of triangles has that of a box, wherever it is."""
    corners = np.vstack([CORNERS, CORNERS + 0.2 * UP]) + 3.0
    assert volume(Mesh(corners, BOX)) == pytest.approx(0.2)


@pytest.mark.parametrize('shape', [
    Mesh(np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]), SHEET[:1]), Box((0.1, 0.0, 0.1))])
def test_a_shape_that_encloses_nothing_cannot_have_mass(world, shape):
    """Corners in a line, or a box without height, are refused; the next object is added."""
    with pytest.raises(SimulationError):
        world.add(thing('line', shape, mass=0.1))
    world.add(thing('line', Box((0.1, 0.1, 0.1)), mass=0.1))
    assert world.names == ('line',)


@pytest.mark.parametrize('mass', [None, 0.1])
def test_any_failure_leaves_the_world_as_it_was(world, mass):
    """Also one in the middle of an object: what came before it is taken out, the rest is back."""
    world.add(thing('old', Box((0.1, 0.1, 0.1)), (2.0, 0.0, 0.1)))
    parts = (LinkGeometry(FLAT['one side'], np.eye(4)),
             LinkGeometry(Sphere(0.1), np.eye(4), rgba=('red',)))
    with pytest.raises((TypeError, ValueError)):
        world.stage([thing('new', Sphere(0.1)), WorldObject('bad', np.eye(4), parts, mass)],
                    ['old'])
    assert world.names == ('old',)
    for name in ('new', 'bad'):
        world.add(thing(name, FLAT['one side'], mass=mass))
    world.remove('old')
    assert world.names == ('new', 'bad')
