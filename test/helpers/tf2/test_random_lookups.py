# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Look-ups in random trees equal a computation with matrices and scipy's interpolation."""

import bisect

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from stamped_transforms import at, numbers, stamped
from tf2_py import BufferCore

#: Stamps of today, where a float of seconds has no nanoseconds any more [ns].
_EPOCH = 1_780_000_000_000_000_000


class RandomTree:
    """
    A tree of moving and static frames in a buffer, and the same as arrays.

    :param random: numpy's generator.
    """

    def __init__(self, random):
        self._random = random
        self._count = int(random.integers(2, 20))
        self.names = [f'frame_{index}' for index in range(self._count)]
        self._parents = [int(random.integers(max(0, index - 3), index))
                         for index in range(1, self._count)]
        self.buffer = BufferCore()
        self._tracks = [self._add(child) for child in range(1, self._count)]

    def poses(self, time):
        """Return the 4 x 4 matrix of every frame in the root."""
        world = [np.eye(4)]
        for parent, track in zip(self._parents, self._tracks, strict=True):
            world.append(world[parent] @ _interpolated(track, time))
        return world

    def time(self):
        """Return a time that every moving frame has data for; often a stamp of one [ns]."""
        start = max(track[0][0] for track in self._tracks)
        end = min(track[0][-1] for track in self._tracks)
        track = self._tracks[int(self._random.integers(len(self._tracks)))]
        between = [stamp for stamp in track[0] if start <= stamp <= end]
        if between and self._random.random() < 0.3:
            return int(self._random.choice(between))
        return int(self._random.integers(start, end, endpoint=True))

    def _add(self, child):
        random = self._random
        parent = self.names[self._parents[child - 1]]
        is_static = random.random() < 0.2
        count = 1 if is_static else int(random.integers(2, 12))
        inner = [] if is_static else random.integers(1, 9_000_000_000, count)
        last = 9_000_000_000 + int(random.integers(10**9))
        stamps = np.unique([0, *inner, last]) + _EPOCH
        rotations = Rotation.random(len(stamps), random_state=random)
        places = random.uniform(-2, 2, (len(stamps), 3))
        if is_static:
            rotations, places = rotations[[0, 0]], places[[0, 0]]
        send = self.buffer.set_transform_static if is_static else self.buffer.set_transform
        for index in random.permutation(len(stamps)):
            send(stamped(parent, self.names[child], int(stamps[index]), places[index],
                         rotations[index].as_quat()), 'test')
        return [int(stamp) for stamp in stamps], rotations, places


def _interpolated(track, time):
    stamps, rotations, places = track
    after = min(max(bisect.bisect_right(stamps, time), 1), len(stamps) - 1)
    ratio = (time - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
    pose = np.eye(4)
    pose[:3, :3] = Slerp([0, 1], rotations[[after - 1, after]])(ratio).as_matrix()
    pose[:3, 3] = (1 - ratio) * places[after - 1] + ratio * places[after]
    return pose


def _matrix(message):
    translation, rotation = numbers(message)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(rotation).as_matrix()
    pose[:3, 3] = translation
    return pose


@pytest.mark.parametrize('seed', range(5))
def test_random_lookups_equal_products_of_matrices(seed):
    """Two thousand look-ups each: translation and rotation to 1e-9, the stamp exactly."""
    random = np.random.default_rng(seed)
    for _ in range(20):
        tree = RandomTree(random)
        for _ in range(5):
            time = tree.time()
            world = tree.poses(time)
            for _ in range(20):
                target, source = map(int, random.integers(len(world), size=2))
                found = tree.buffer.lookup_transform_core(
                    tree.names[target], tree.names[source], at(time))
                np.testing.assert_allclose(
                    _matrix(found), np.linalg.inv(world[target]) @ world[source], atol=1e-9)
                assert at(time) == at(found.header.stamp.sec * 10**9 + found.header.stamp.nanosec)


def test_lookups_over_time_equal_products_of_matrices():
    """The source moves to the fixed frame at its time, and from there at the target's."""
    random = np.random.default_rng(5)
    for _ in range(20):
        tree = RandomTree(random)
        for _ in range(3):
            times = tree.time(), tree.time()
            then, now = (tree.poses(time) for time in times)
            target, source, fixed = map(int, random.integers(len(now), size=3))
            found = tree.buffer.lookup_transform_full_core(
                tree.names[target], at(times[1]), tree.names[source], at(times[0]),
                tree.names[fixed])
            np.testing.assert_allclose(
                _matrix(found), np.linalg.inv(now[target]) @ now[fixed]
                @ np.linalg.inv(then[fixed]) @ then[source], atol=1e-9)
            assert at(found.header.stamp.sec * 10**9 + found.header.stamp.nanosec) == (
                at(times[1]))
