# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
No contact is lost, whatever touches whatever, however it is placed.

Placements are those in which collision libraries err: grids of parallel shapes, faces that
coincide, common centres, motions by a hair, contacts of a given depth. What is true is proved by
``separation``, which shares no code with what is tested.
"""

import itertools
import warnings

import numpy as np
from scipy.spatial.transform import Rotation
from separation import box_mesh, Placed, separation, solid

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Mesh, Plane, Sphere
from armsim_ros.model.robot_model import (
    Joint,
    JointLimits,
    JointType,
    Link,
    LinkGeometry,
    RobotModel,
)
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate

#: A contact deeper than this [m] must be found, with this much more for each metre of size.
DEEP, DEEP_SHARE = 1e-6, 1e-11
#: A gap wider than this [m] must not count as contact, with as much more for a metre of size.
WIDE = 5e-6
#: Placements of one test; the option --placements makes more tests.
AT_ONCE = 10_000
#: Placements of one pair of shapes.
BATCH = 80
#: Sizes [m]: usual, equal for all, tiny, thin, and large.
SIZES = ('usual', 'even', 'tiny', 'thin', 'large')
KINDS = (Box, Sphere, Cylinder, Cone, Capsule, Plane, Mesh)
PAIRS = tuple(pair for pair in itertools.combinations_with_replacement(KINDS, 2)
              if pair != (Plane, Plane))
#: Which stages of the robot's checks are asked.
EXACT, HULLS = True, False


def lengths(size, rng):
    """Return three lengths [m]."""
    if size == 'even':
        return np.full(3, 0.1)
    if size == 'tiny':
        return 10.0 ** rng.uniform(-4, -2, 3)
    if size == 'thin':
        return rng.permutation([*rng.choice([0.1, 0.5, 2.0], 2), rng.choice([1e-4, 1e-3])])
    if size == 'large':
        return rng.choice([0.2, 2.0, 10.0, 50.0], 3)
    return rng.choice([0.05, 0.1, 0.2, 0.3, 0.4], 3)


def made(kind, size, rng):
    """Return a shape of a kind."""
    x, y, z = lengths(size, rng)
    if kind is Box:
        return Box((x, y, z))
    if kind is Sphere:
        return Sphere(0.5 * x)
    if kind is Plane:
        return Plane(*rng.choice([[0, 0, 1], [1, 0, 0], [0.6, -0.8, 0], [0, 0, -2]]),
                     rng.choice([0.0, 0.1]))
    if kind is not Mesh:
        return kind(0.5 * x, z)
    if rng.random() < 0.5:
        return box_mesh((x, y, z))
    # A prism or pyramid over a regular polygon, all in triangles.
    count = rng.integers(3, 6)
    ring = np.linspace(0, 2 * np.pi, count, endpoint=False)
    base = np.column_stack([0.5 * x * np.cos(ring), 0.5 * y * np.sin(ring), 0 * ring - 0.5 * z])
    tip = [[0, 0, 0.5 * z]]
    sides = [(k, (k + 1) % count, count) for k in range(count)]
    floor = [(0, k + 1, k) for k in range(1, count - 1)]
    return Mesh(np.vstack([base, tip]), np.array([*sides, *floor]))


def probe(shape, link='probe'):
    """Return a robot whose link 'probe' goes everywhere; that or another link has a shape."""
    limits = JointLimits(-1e4, 1e4, 1.0)
    names = ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
    links = {name: Link(name) for name in ('base', *names[:-1], 'probe')}
    links[link] = Link(link, collisions=(LinkGeometry(shape, np.eye(4)),))
    joints = {}
    for k, (name, parent) in enumerate(zip(names, links, strict=False)):
        kind = JointType.PRISMATIC if k < 3 else JointType.REVOLUTE
        joints[name] = Joint(name, kind, parent, 'probe' if k == 5 else name, np.eye(4),
                             np.eye(3)[k % 3], limits)
    return RobotModel('probe', links, joints, 'base', SemanticModel('probe', {}))


def turns(count, rng):
    """Return rotations: none, by right angles, about an axis, by a hair, or any."""
    mode = rng.integers(6)
    if mode < 2:
        return Rotation.identity(count)
    if mode == 2:
        return Rotation.from_euler('xyz', rng.integers(0, 4, (count, 3)) * np.pi / 2)
    if mode == 3:
        return Rotation.from_euler('xyz'[rng.integers(3)], rng.uniform(-3, 3, (count, 1)))
    if mode == 4:
        return Rotation.from_rotvec(
            rng.normal(size=(count, 3)) * rng.choice([1e-9, 1e-7, 1e-5, 1e-3]))
    return Rotation.random(count, random_state=rng)


def ways(one, other, rotations, rng):
    """Return where the first shape is seen from the second (k, 3) [m]."""
    count = len(rotations)
    still = Placed(other, np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)))
    turned = Placed(one, rotations, np.zeros((count, 3)))
    extent = np.zeros((count, 3))
    axes = np.tile(np.eye(3), (count, 1, 1))
    for each in (still, turned):
        if hasattr(each.form, 'support'):
            extent += 0.5 * (each.reach(axes) + each.reach(-axes))
    extent = np.where(extent > 0, extent, 1.0)
    found = np.zeros((count, 3))
    fifth = count // 5
    # On a grid, whose pitch divides the shapes or is a centimetre.
    part = slice(0, 2 * fifth)
    pitch = rng.choice([0.01, 0.05, float(extent.min()) / 4])
    found[part] = rng.integers(-10, 11, (2 * fifth, 3)) * pitch * rng.integers(
        0, 2, (2 * fifth, 3))
    # Faces that coincide, and common centres.
    part = slice(2 * fifth, 3 * fifth)
    found[part] = extent[part] * rng.choice([-1, 0, 0.5, 1], (fifth, 3))
    found[2 * fifth:2 * fifth + 3] = 0.0
    part = slice(3 * fifth, 4 * fifth)
    found[part] = rng.uniform(-1, 1, (fifth, 3)) * extent[part]
    jitter = rng.choice([0.0, 0.0, *10.0 ** np.arange(-9, -2)])
    found += jitter * rng.choice([-1, 0, 1], (count, 3))
    # Outmost points of both meet, at a given distance or depth.
    part = slice(4 * fifth, count)
    number = count - 4 * fifth
    way = rng.normal(size=(number, 3))
    way[::3] = np.eye(3)[rng.integers(0, 3, len(way[::3]))] * rng.choice([-1, 1])
    way /= np.linalg.norm(way, axis=1)[:, None]
    gap = rng.choice([-1, -1, 1], number) * 10.0 ** rng.uniform(-5.9, -2, number)
    if hasattr(one, 'support') and hasattr(other, 'support'):
        ours = Placed(one, rotations[part], np.zeros((number, 3))).support(-way)
        theirs = Placed(other, still.turn[part], np.zeros((number, 3))).support(way)
        found[part] = theirs + gap[:, None] * way - ours
    return found


def placements(shape, other, rng):
    """Return forms, poses of the first (rotations, positions), and the pose of the other."""
    one, two = solid(shape), solid(other)
    relative = turns(BATCH, rng)
    frame = Rotation.identity() if rng.random() < 0.5 else Rotation.random(random_state=rng)
    away = rng.normal(size=3) * rng.integers(0, 2)
    where = frame.apply(ways(one, two, relative.as_matrix(), rng)) + away
    return frame * relative, where, frame, away


def scene_with(shape, other, frame, away, role, padding):
    """Return a scene in which the first shape is the probe's and the other one stands."""
    pose = pose_matrix((0, 0, 0))
    pose[:3, :3], pose[:3, 3] = frame.as_matrix(), away
    scene = PlanningScene(KinematicModel(probe(shape)))
    item = CollisionObject('other', pose=pose, shapes=(ObjectShape(other),))
    if role == 'world':
        scene.apply(SceneUpdate(link_padding={'probe': padding}))
        scene.apply_object(item)
    else:
        scene.apply_attached(AttachedObject('base', item, ('base',)))
    return scene


def lost_and_false(pair, size, seed):
    """Return what is wrong with the answers about one batch, and how many were proved."""
    rng = np.random.default_rng(seed)
    shape, other = made(pair[0], size, rng), made(pair[1], size, rng)
    if rng.random() < 0.3 and pair[0] is pair[1]:
        other = shape
    if pair[0] is Plane or (rng.random() < 0.5 and pair[1] is not Plane):
        shape, other = other, shape
    rotations, where, frame, away = placements(shape, other, rng)
    role = 'world' if isinstance(other, Plane) or rng.random() < 0.7 else 'attached'
    padding = rng.choice([0.0, 0.0, 0.01]) if role == 'world' else 0.0
    clearance = rng.choice([0.0, 0.0, 0.003])
    scene = scene_with(shape, other, frame, away, role, padding)
    checker = CollisionChecker(scene)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')  # any angles of a rotation will do
        states = np.hstack([where, rotations.as_euler('XYZ')])
    turned = Rotation.from_euler('XYZ', states[:, 3:]).as_matrix()
    margin = padding + clearance
    faults, proved = [], 0
    for exact in (EXACT, HULLS):
        # Hulls stand for meshes of the robot and of what it carries.
        first = solid(shape, surface=exact)
        second = solid(other, surface=exact or role == 'world')
        still = np.tile(frame.as_matrix(), (BATCH, 1, 1))
        low, high = separation(
            Placed(first, turned, where), Placed(second, still, np.tile(away, (BATCH, 1))))
        slack = DEEP_SHARE * (first.size + second.size + np.abs(where).max())
        touch = high < margin - DEEP - slack
        wide = WIDE * (1.0 + first.size + second.size)
        if isinstance(shape, Capsule) and isinstance(other, Capsule):
            wide += min(max(shape.length, other.length), 3e-7 / min(shape.length, other.length))
        apart = low > margin + wide
        found = np.array([checker.in_collision(q, clearance=clearance, exact=exact)
                          for q in states])
        proved += int(touch.sum() + apart.sum())
        measured = np.array([
            min((pair.distance for pair in checker.pair_distances(q, 0.01, exact=exact)),
                default=np.inf) for q in states[::5]])
        found[::5] &= measured <= clearance + WIDE
        for name, wrong in (('lost', touch & ~found), ('false', apart & found)):
            faults += [
                f'{name}: {shape} and {other}, {size}, seed {seed}, exact={exact}, {role}, '
                f'margin {margin}: {low[k]:.3g} .. {high[k]:.3g} m, number {k}'
                for k in np.flatnonzero(wrong)]
    return faults, proved


def pytest_generate_tests(metafunc):
    """Make a test of each ten thousand placements."""
    if 'part' not in metafunc.fixturenames:
        return
    wanted = int(metafunc.config.getoption('placements', None) or AT_ONCE)
    first = int(metafunc.config.getoption('placement_seed', None) or 0)
    metafunc.parametrize('part', range(first, first + -(-wanted // AT_ONCE)))


def test_no_contact_is_lost(part):
    """Contacts deeper than a micrometre are found, gaps wider than five are none."""
    faults, proved = [], 0
    batches = AT_ONCE // BATCH
    for seed in range(part * batches, (part + 1) * batches):
        wrong, sure = lost_and_false(PAIRS[seed % len(PAIRS)], SIZES[seed % len(SIZES)], seed)
        faults += wrong
        proved += sure
    assert not faults, '\n'.join([f'{len(faults)} of {proved}', *faults[:20]])
    assert proved > 0.8 * 2 * BATCH * batches


def test_no_contact_on_one_joint_is_lost():
    """Shapes that no joint moves against each other are checked once for all states."""
    proved = 0
    for seed, pair in enumerate(PAIRS * 2):
        rng = np.random.default_rng(seed)
        shape, other = (made(kind, 'usual', rng) for kind in pair[::1 if Plane in pair else -1])
        rotations, where, _, _ = placements(shape, other, rng)
        low, high = separation(
            Placed(solid(shape), rotations.as_matrix(), where),
            Placed(solid(other), np.tile(np.eye(3), (BATCH, 1, 1)), np.zeros((BATCH, 3))))
        sure = np.flatnonzero((high < -2.0 * DEEP) | (low > 3.0 * WIDE))
        scene = PlanningScene(KinematicModel(probe(shape, 'base')))
        checker = CollisionChecker(scene)
        for k in rng.choice(sure, min(5, len(sure)), replace=False):
            # The other shape stands in the world, where it is as seen from the first one.
            turned = rotations[k].inv()
            pose = pose_matrix((0, 0, 0))
            pose[:3, :3], pose[:3, 3] = turned.as_matrix(), -turned.apply(where[k])
            scene.apply_object(
                CollisionObject('other', pose=pose, shapes=(ObjectShape(other),)))
            assert checker.in_collision(scene.q) == (high[k] < 0.0), (
                shape, other, seed, int(k), low[k], high[k])
            proved += 1
    assert proved > 200
