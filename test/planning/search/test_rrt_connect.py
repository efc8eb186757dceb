# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the search with two trees, on a square with a wall."""

from itertools import pairwise

import numpy as np
import pytest

from armsim_ros.planning.search.rrt_connect import RRTConnect, SamplePool, SearchTree, ShorterPaths

LOW, HIGH = np.zeros(2), np.ones(2)
START, GOAL = np.array([0.1, 0.5]), np.array([0.9, 0.5])


def past_the_wall(a, b):
    """Return whether a motion keeps clear of a wall from below up to y = 0.9."""
    states = a + np.linspace(0.0, 1.0, 50)[:, None] * (b - a)
    return not np.any((np.abs(states[:, 0] - 0.5) < 0.05) & (states[:, 1] < 0.9))


def search(seed=0, free=past_the_wall):
    """Return a search on the square."""
    def steer(state, target, distance, longest):
        following = state + (target - state) * min(1.0, longest / distance)
        return following[None] if free(state, following) else np.empty((0, 2))

    return RRTConnect(LOW, HIGH, steer, 0.1, np.random.default_rng(seed))


def never():
    """Do not stop."""
    return False


@pytest.mark.parametrize('seed', range(5))
def test_way_around_a_wall(seed):
    """A path of free motions, none longer than an extension, leads from start to goal."""
    path = search(seed).find(START, [GOAL], never)
    assert path[0] == pytest.approx(START)
    assert path[-1] == pytest.approx(GOAL)
    assert all(past_the_wall(a, b) for a, b in pairwise(path))
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 0.1 + 1e-12


def test_same_seed_same_path():
    """A search is repeatable."""
    assert np.array_equal(
        search(3).find(START, [GOAL], never), search(3).find(START, [GOAL], never))


def test_any_goal_is_enough():
    """Of several goals one that can be reached is enough."""
    def free(a, b):
        return past_the_wall(a, b) and max(a[1], b[1]) < 0.9

    near = np.array([0.1, 0.1])
    path = search(free=free).find(START, [GOAL, near], never)
    assert path[-1] == pytest.approx(near)


@pytest.mark.parametrize('seed', range(5))
def test_a_shorter_path_is_looked_for_where_it_can_be(seed):
    """No state of a path is where only longer paths than the given length pass."""
    path = search(seed).find(START, [GOAL], never, shorter_than=1.3)
    assert all(past_the_wall(a, b) for a, b in pairwise(path))
    ways = np.linalg.norm(path - START, axis=1) + np.linalg.norm(path - GOAL, axis=1)
    assert ways.max() < 1.3


def test_stop():
    """A search without a way ends when it is told to."""
    asked = iter(range(1000))
    found = search(free=lambda a, b: False).find(START, [GOAL], lambda: next(asked) > 50)
    assert found is None


def test_few_motions_into_walls():
    """States whose motions fail are tried less and less."""
    ways = search(1)
    ways.find(START, [GOAL], never)
    assert ways.motions < 400


def test_tree_grows_and_finds_the_nearest():
    """A tree finds its nearest state and the way back to its root, however large it is."""
    rng = np.random.default_rng(0)
    states = rng.uniform(size=(300, 3))
    tree = SearchTree(states[:1])
    for number, values in enumerate(states[1:]):
        assert tree.add(number, values) == number + 1
    wanted = rng.uniform(size=3)
    distances = np.linalg.norm(states - wanted, axis=1)
    assert tree.nearest(wanted) == (distances.argmin(), pytest.approx(distances.min()))
    assert tree.branch(299) == pytest.approx(states[::-1])


def test_samples_beyond_the_radius_are_left_out():
    """The first sample within the radius of its nearest state is taken, until none is left."""
    tree = SearchTree(np.array([[0.0, 0.0], [1.0, 0.0]]))
    tree.radii[:2] = 0.1, 0.5
    samples = np.array([[0.0, 0.3], [1.0, 0.4], [0.0, 0.05], [0.0, 0.2]])
    pool = SamplePool(tree, lambda count: samples)
    taken = [pool.take(), pool.take(), pool.take()]
    assert [each[1:] for each in taken[:2]] == [
        (1, pytest.approx(0.4)), (0, pytest.approx(0.05))]
    assert taken[0][0] == pytest.approx(samples[1])
    assert taken[2] is None


def test_samples_follow_the_tree():
    """States that come later are found as the nearest ones, too."""
    rng = np.random.default_rng(0)
    tree = SearchTree(np.zeros((1, 3)))
    pool = SamplePool(tree, lambda count: rng.uniform(size=(count, 3)))
    states, checked = [np.zeros(3)], 0
    for count in (0, 1, 1, 5, 0, 40, 1) * 20:
        for values in rng.uniform(size=(count, 3)):
            tree.add(0, values)
            states.append(values)
        found = pool.take()
        if found is None:
            continue
        sample, near, distance = found
        distances = np.linalg.norm(np.array(states) - sample, axis=1)
        assert near == distances.argmin()
        assert distance == pytest.approx(distances.min())
        checked += 1
    assert checked > 10


@pytest.mark.parametrize('length', [0.82, 1.1, 1.9, 4.0])
def test_states_of_shorter_paths(length):
    """States are drawn evenly from all that are within bounds and on a way short enough."""
    goals = np.array([GOAL, [0.1, 0.9]])
    rng = np.random.default_rng(0)
    states = ShorterPaths(LOW, HIGH, START, goals[:1], length, rng).draw(4000)
    assert ((states >= LOW) & (states <= HIGH)).all()

    def passed(places):
        ways = np.linalg.norm(places - START, axis=1)
        ways += np.linalg.norm(places - GOAL, axis=1)
        return places[ways < length + 1e-9]

    assert len(passed(states)) == len(states) > 1000
    everywhere = passed(rng.uniform(LOW, HIGH, (100000, 2)))
    assert states.mean(axis=0) == pytest.approx(everywhere.mean(axis=0), abs=0.03)
    assert np.cov(states.T) == pytest.approx(np.cov(everywhere.T), abs=0.01)
    several = ShorterPaths(LOW, HIGH, START, goals, length, rng).draw(4000)
    assert np.linalg.norm(several - goals[1], axis=1).min() < 0.05
    assert np.linalg.norm(several - goals[0], axis=1).min() < 0.05
