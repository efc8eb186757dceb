# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What measurements do to the cells of a map."""

import numpy as np
import pytest
from separation import box_mesh

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, is_inside, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.occupancy.occupancy_map import HIT, Measurement, MISS, OccupancyMap
from armsim_ros.planning.occupancy.solids import changed_bodies, inside_any, known_bodies, Solid
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.octomap import MIDDLE, Octomap
from armsim_ros.planning.scene.octree_data import HIGHEST, Leaves, LOWEST
from armsim_ros.planning.scene.planning_scene import PlanningScene

RESOLUTION = 0.05
SENSOR = pose_matrix((0.02, 0.02, 0.0))


def wall(distance, half=0.4, spacing=0.004):
    """Return the points of a wall before a camera."""
    across = np.arange(-half, half, spacing)
    x, y = np.meshgrid(across, across)
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, distance)], -1).astype(np.float32)


def seen(points, **options):
    """Return a measurement of points."""
    return Measurement(np.asarray(points, dtype=np.float32).reshape(-1, 3), SENSOR, **options)


def after(octomap, *measurements, bodies=()):
    """Return a map after measurements."""
    for each in measurements:
        octomap, _ = octomap.inserted(each, list(bodies))
    return octomap


def odds(octomap):
    """Return cell -> log odds."""
    return dict(zip(map(tuple, octomap.keys.tolist()), octomap.log_odds.tolist(), strict=True))


POINT = (0.01, 0.01, 0.52)
CELL = (0, 0, 10)


def test_a_hit_fills_a_cell_and_three_misses_empty_it():
    """The log odds are OctoMap's."""
    octomap = after(OccupancyMap(RESOLUTION), seen(POINT))
    assert odds(octomap) == {CELL: pytest.approx(HIT)}
    values = []
    for _ in range(3):
        octomap = after(octomap, seen(wall(1.0)))
        values.append(odds(octomap)[CELL])
    assert values == pytest.approx([HIT + k * MISS for k in (1, 2, 3)], abs=1e-5)
    assert [value >= 0 for value in values] == [True, True, False]


def test_a_cell_at_the_upper_clamp_is_emptied_by_nine_misses():
    """However often it was seen."""
    octomap = after(OccupancyMap(RESOLUTION), *[seen(POINT)] * 20)
    assert odds(octomap)[CELL] == pytest.approx(HIGHEST)
    for count in range(1, 10):
        octomap = after(octomap, seen(wall(1.0)))
        assert (odds(octomap)[CELL] >= 0) == (count < 9)
    octomap = after(octomap, *[seen(wall(1.0))] * 20)
    assert odds(octomap)[CELL] == pytest.approx(LOWEST)


def test_a_cell_changes_once_in_a_measurement():
    """A hit wins over a miss, and many points are a single hit."""
    both = np.vstack([wall(1.0), [POINT] * 50])
    octomap = after(OccupancyMap(RESOLUTION), seen(both))
    assert odds(octomap)[CELL] == pytest.approx(HIT)


def test_what_is_behind_or_beside_stays():
    """Rays clear no cell behind their ends, nor one that no ray crosses."""
    before = after(OccupancyMap(RESOLUTION), seen([POINT, (0.01, 3.0, 0.5), (0.01, 0.01, -0.5)]))
    assert odds(after(before, seen(wall(0.3, half=0.1))))[CELL] == pytest.approx(HIT)
    later = odds(after(before, seen(wall(1.0))))
    assert [value == pytest.approx(HIT) for cell, value in sorted(later.items())
            if cell[2] < 20 and cell != CELL] == [True, True]


def test_cells_at_the_border_of_a_picture_are_emptied():
    """What a camera has seen there it sees free again, though the cell's centre is beside."""
    points = wall(1.0, half=0.395)
    octomap = after(OccupancyMap(RESOLUTION), seen(points))
    before = len(octomap.occupied)
    octomap = after(octomap, *[seen(2.0 * points)] * 3)
    near = octomap.occupied[octomap.occupied[:, 2] < 30]
    assert before > 280
    assert not len(near)


def test_points_beyond_the_range_clear_and_are_no_hits():
    """Their rays end at the range; cells behind that stay."""
    octomap = after(OccupancyMap(RESOLUTION), seen([POINT, (0.01, 0.01, 1.4)]))
    octomap, kept = octomap.inserted(seen(wall(2.0), max_range=1.0), [])
    assert not kept.any()
    assert odds(octomap) == {CELL: pytest.approx(HIT + MISS), (0, 0, 28): pytest.approx(HIT)}


def test_rays_that_hit_nothing_clear():
    """Before an empty background, too."""
    octomap = after(OccupancyMap(RESOLUTION), seen(POINT))
    octomap = after(octomap, Measurement(np.zeros((0, 3), np.float32), SENSOR, beyond=wall(3.0)))
    assert odds(octomap)[CELL] == pytest.approx(HIT + MISS)


def test_nothing_seen_changes_nothing():
    """A cloud without a point is no error."""
    octomap = after(OccupancyMap(RESOLUTION), seen(POINT))
    assert odds(after(octomap, seen([]))) == odds(octomap)


def test_sensor_that_sees_all_around_clears():
    """A lidar's rays go to all sides."""
    way = np.random.default_rng(0).normal(size=(200_000, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    points = np.vstack([0.5 * way[:1], [[-0.5, 0.01, 0.01]]])
    octomap = after(OccupancyMap(RESOLUTION), seen(points))
    assert len(octomap.occupied) == 2
    octomap = after(octomap, *[seen(2.0 * way)] * 3)
    assert all(value < 0 or max(map(abs, cell)) > 20 for cell, value in odds(octomap).items())


def test_known_bodies_are_free():
    """A cell with a point inside of a body is free at once, whatever else is in it."""
    octomap = after(OccupancyMap(RESOLUTION), *[seen(POINT)] * 5)
    body = (Solid(Sphere(0.05), 1.0, 0.02), SENSOR @ pose_matrix((0.0, 0.0, 0.52)))
    cloud = np.vstack([wall(1.0), [POINT, (0.015, 0.015, 0.545), (0.01, 0.2, 0.52)]])
    octomap, kept = octomap.inserted(seen(cloud), [body])
    assert odds(octomap)[CELL] == pytest.approx(LOWEST)
    assert kept[-3:].tolist() == [False, False, True]
    assert kept[:-3].all()


@pytest.mark.parametrize('shape', [
    Box((0.2, 0.3, 0.4)), Sphere(0.2), Cylinder(0.15, 0.3), Cone(0.2, 0.4), Capsule(0.1, 0.2)])
def test_solids_hold_what_is_inside(shape):
    """Without growth they are the shapes; with growth all within that distance is inside."""
    points = np.random.default_rng(0).uniform(-0.4, 0.4, (500, 3))
    inside = Solid(shape, 1.0, 0.0).holds(points)
    assert inside.tolist() == [is_inside(shape, point) for point in points]
    ways = np.random.default_rng(1).normal(size=(500, 3))
    ways *= 0.0499 / np.linalg.norm(ways, axis=1)[:, None]
    assert Solid(shape, 1.0, 0.05).holds((points + ways)[inside]).all()
    grown = Solid(shape, 1.5, 0.0).holds(1.5 * points)
    assert (grown == inside).all()
    solid = Solid(shape, 1.2, 0.1)
    held = solid.holds(2.0 * points)
    assert (np.linalg.norm(2.0 * points - solid.centre, axis=1)[held] <= solid.radius).all()


def bin_mesh():
    """Return a box without a lid, 0.4 m wide, with walls of 0.02 m, as a closed mesh."""
    parts = [((0.4, 0.4, 0.02), (0, 0, 0)), ((0.02, 0.4, 0.4), (0.19, 0, 0.2)),
             ((0.02, 0.4, 0.4), (-0.19, 0, 0.2)), ((0.4, 0.02, 0.4), (0, 0.19, 0.2)),
             ((0.4, 0.02, 0.4), (0, -0.19, 0.2))]
    meshes = [box_mesh(size) for size, _ in parts]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.vstack([mesh.vertices + at for mesh, (_, at) in zip(meshes, parts, strict=True)]),
        np.vstack([mesh.triangles + start for mesh, start in zip(
            meshes, starts[:-1], strict=True)]))


def test_what_is_in_a_bin_is_seen():
    """A mesh that is not convex counts as it is, to within a voxel."""
    solid = Solid(bin_mesh(), 1.0, 0.02)
    points = np.array([[0, 0, 0.15], [0.1, 0.1, 0.04], [0, 0, 0.022], [0.165, 0, 0.2],
                       [0.19, 0, 0.2], [0.0, 0.0, 0.0], [0.15, 0, 0.2], [0.0, 0.0, 0.5]])
    assert solid.holds(points).tolist() == [False, False, True, True, True, True, False, False]
    assert not Solid(bin_mesh(), 1.0, 0.0).holds(points)[[0, 1, 2, 3, 6, 7]].any()
    assert Solid(bin_mesh(), 1.0, 0.0).holds(points)[[4, 5]].all()


@pytest.mark.parametrize('side', [-1, 1])
def test_a_wall_of_a_bin_is_where_it_is(side):
    """Points half a voxel to both sides of a wall's inner face are told apart."""
    points = np.array([[side * 0.183, 0.0, 0.2], [side * 0.176, 0.0, 0.2]])
    assert Solid(bin_mesh(), 1.0, 0.0).holds(points).tolist() == [True, False]


def test_convex_meshes_count_and_a_plane_not(make_cube):
    """By the planes of their faces."""
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (500, 3))
    cube = np.abs(points).max(axis=1)
    assert (Solid(make_cube(0.2), 1.0, 0.0).holds(points) == (cube <= 0.1)).all()
    assert (Solid(make_cube(0.2), 1.0, 0.03).holds(points) == (cube <= 0.13)).all()
    flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
    assert Solid(flat, 1.0, 0.01).holds(np.array([[0.2, 0.2, 0.005], [0.2, 0.2, 0.02]])
                                        ).tolist() == [True, False]
    assert not inside_any(points, [(Solid(Plane(0, 0, 1, 0), 1.0, 0.1), np.eye(4))]).any()


def test_scene_knows_links_loads_and_objects(arm):
    """All of them are left out, each where it is in the state."""
    scene = PlanningScene(KinematicModel(arm))
    q = np.full(scene.kinematic_model.n, 0.3)
    scene.apply_object(CollisionObject(
        'crate', pose=pose_matrix((2, 0, 0)), shapes=(ObjectShape(Sphere(0.1)),)))
    load = CollisionObject('load', frame_id='tool', pose=pose_matrix((0, 0, 0.5)),
                           shapes=(ObjectShape(Sphere(0.1)),))
    scene.apply_attached(AttachedObject('tool', load))
    bodies = known_bodies(scene.kinematic_model, scene.content, q, 1.0, 0.0)
    load = scene.kinematic_model.link_pose(q, 'tool') @ pose_matrix((0, 0, 0.5))
    link = next(name for name, each in arm.links.items() if each.collisions)
    middle = scene.kinematic_model.link_pose(q, link) @ arm.links[link].collisions[0].origin
    points = np.array([[2.05, 0, 0], load[:3, 3], middle[:3, 3], [2.2, 0, 0], [0, 0, 9]])
    assert inside_any(points, bodies).tolist() == [True, True, True, False, False]
    # At 2 m from a sensor at the origin that looks along x, by 0.01 m/m^2 * (2 m)^2.
    bodies = known_bodies(scene.kinematic_model, scene.content, q, 1.0, 0.0, 0.01, pose_matrix(
        (0, 0, 0), (0, np.pi / 2, 0)))
    assert inside_any(np.array([[2.139, 0, 0], [2.141, 0, 0]]), bodies).tolist() == [True, False]


def test_a_changed_object_empties_its_cells(arm):
    """Only what is new or elsewhere does."""
    scene = PlanningScene(KinematicModel(arm))
    ball = (ObjectShape(Sphere(0.1)),)
    scene.apply_object(CollisionObject('old', pose=pose_matrix((0, 0, 1)), shapes=ball))
    before = scene.content
    scene.apply_object(CollisionObject('new', pose=pose_matrix((0.5, 0, 1)), shapes=ball))
    bodies = changed_bodies(scene.kinematic_model, before, scene.content, 0.02)
    octomap = after(OccupancyMap(RESOLUTION), seen([[0.0, 0.0, 1.0], [0.5, 0.0, 1.0]]))
    assert octomap.emptied(bodies).occupied.tolist() == [[0, 0, 20]]
    assert octomap.emptied([]) is octomap


def test_large_leaves_of_an_octomap_become_cells():
    """A leaf of a higher level is the cells that it covers; free leaves are left out."""
    corners = np.array([[0, 0, 0], [2, 0, 0], [4, 0, 0]]) + MIDDLE
    octomap = Octomap(RESOLUTION, Leaves(
        corners, np.array([1, 0, 1]), np.array([HIGHEST, HIT, LOWEST], dtype=np.float32)))
    found = odds(OccupancyMap.of_occupied(octomap))
    cube = {tuple(cell): HIGHEST for cell in np.indices((2, 2, 2)).reshape(3, -1).T.tolist()}
    assert found == pytest.approx({**cube, (2, 0, 0): HIT})


def test_an_octomap_of_too_many_cells_is_refused():
    """It names how many it has."""
    octomap = Octomap(RESOLUTION, Leaves(
        np.full((1, 3), MIDDLE), np.array([10]), np.array([HIT], dtype=np.float32)))
    with pytest.raises(PlanningError, match=f'{8 ** 10} occupied cells'):
        OccupancyMap.of_occupied(octomap)


def test_equal_measurements_give_equal_maps():
    """Bit by bit."""
    points = np.random.default_rng(2).uniform(-1, 1, (5000, 3)) + np.array([0, 0, 2])
    first, second = (after(OccupancyMap(0.02), *[seen(points[k::3]) for k in range(3)])
                     for _ in range(2))
    assert first.octomap().full_data() == second.octomap().full_data()
