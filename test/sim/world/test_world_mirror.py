# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What has to be told of a world that changes."""

import numpy as np
import pytest

from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.world.world_mirror import Holder, WorldMirror, WorldSnapshot, WorldWatch


def thing(name, mass=0.1):
    """Return a box."""
    return WorldObject.of_shape(name, Box((0.1, 0.1, 0.1)), np.eye(4), mass=mass)


ROW = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
CUBE, BALL = thing('cube'), thing('ball')
TIP = Holder('tip', ('tip',))


def snapshot(objects, epoch=0, held=None, **rows):
    """Return a world in which all stand at one place but for those that are named."""
    poses = {one.name: rows.get(one.name, ROW) for one in objects}
    return WorldSnapshot(epoch, {one.name: one for one in objects}, poses, held or {})


@pytest.fixture
def mirror():
    """Return one that has told of a cube and a ball."""
    mirror = WorldMirror()
    assert [one.name for one, _ in mirror.news(snapshot([CUBE, BALL])).added] == ['cube', 'ball']
    return mirror


def test_at_rest_there_is_silence(mirror):
    """What was told is not told again, unless all of it is wanted."""
    assert mirror.news(snapshot([CUBE, BALL])).empty
    assert len(mirror.news(snapshot([CUBE, BALL]), whole=True).added) == 2


@pytest.mark.parametrize(('way', 'turn', 'told'), [
    (9e-4, 0.0, False), (1.1e-3, 0.0, True), (0.0, np.radians(0.4), False),
    (0.0, np.radians(0.6), True),
])
def test_a_millimetre_or_half_a_degree(mirror, way, turn, told):
    """Less is not told."""
    row = ROW.copy()
    row[0], row[3], row[6] = way, np.cos(0.5 * turn), np.sin(0.5 * turn)
    assert bool(mirror.news(snapshot([CUBE, BALL], cube=row)).moved) is told


def test_what_creeps_is_told_in_the_end(mirror):
    """The way counts since it was last told."""
    moves = 0
    for step in range(1, 41):
        row = ROW + np.array([1e-4 * step, 0, 0, 0, 0, 0, 0])
        moves += len(mirror.news(snapshot([CUBE, BALL], cube=row)).moved)
    assert moves == 3


def test_objects_come_and_go(mirror):
    """A new one of the same name is told as a new one."""
    news = mirror.news(snapshot([thing('cube'), thing('late')]))
    assert [one.name for one, _ in news.added] == ['cube', 'late']
    assert news.removed == ('ball',)


def test_a_new_epoch_is_told_from_the_beginning(mirror):
    """All of it."""
    assert len(mirror.news(snapshot([CUBE, BALL], epoch=1)).added) == 2


@pytest.mark.parametrize('way', [0.0, 1e-4])
def test_what_is_held_goes_with_its_link(mirror, way):
    """Its pose is told as it is taken, and when it is let go, however little it has moved."""
    row = ROW + np.array([way, 0, 0, 0, 0, 0, 0])
    news = mirror.news(snapshot([CUBE, BALL], held={'cube': TIP}, cube=row))
    assert news.grasped == (('cube', TIP),)
    assert [name for name, _ in news.moved] == (['cube'] if way else [])
    assert mirror.news(snapshot([CUBE, BALL], held={'cube': TIP}, cube=row + 1.0)).empty
    news = mirror.news(snapshot([CUBE, BALL], cube=ROW))
    assert news.released == (('cube', TIP),)
    assert [one.name for one, _ in news.added] == ['cube']


def test_a_watch_sees_the_world_as_it_is(simulation):
    """Free objects where they are, and fixed ones when they are moved."""
    watch = WorldWatch(simulation.world)
    simulation.world.add(WorldObject.of_shape(
        'wall', Box((0.1, 0.1, 0.1)), pose_matrix((2, 0, 1))))
    simulation.world.add(WorldObject.of_shape(
        'ball', Box((0.1, 0.1, 0.1)), pose_matrix((3, 0, 1)), mass=0.1))
    seen = watch.look()
    assert set(seen.objects) - {'floor'} == {'wall', 'ball'}
    np.testing.assert_allclose(seen.poses['ball'][:3], (3, 0, 1))
    simulation.world.set_pose('wall', pose_matrix((2, 0, 2)))
    np.testing.assert_allclose(watch.look().poses['wall'][:3], (2, 0, 2))
