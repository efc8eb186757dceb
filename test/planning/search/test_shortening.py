# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of shorter paths, on a square with a round obstacle."""

from itertools import pairwise

import numpy as np
import pytest

from armsim_ros.planning.search.shortening import (
    path_length,
    with_corners_cut,
    with_shortcuts,
    without_repeats,
)

DETOUR = np.array([
    [0.0, 0.5], [0.1, 0.9], [0.15, 0.6], [0.3, 0.95], [0.7, 0.9], [0.9, 0.95], [1.0, 0.5]])


def past_the_disc(a, b):
    """Return whether a motion keeps out of a disc of radius 0.3 in the middle."""
    states = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)
    return bool(np.all(np.linalg.norm(states - 0.5, axis=1) > 0.3))


def never():
    """Do not stop."""
    return False


class Square:
    """A square in which some motions are free, and some of those that cut a corner."""

    def __init__(self, motion_free, corner_free=None):
        self.motion_free = self.shortcut_free = motion_free
        self.corner_free = corner_free or motion_free

    def join(self, first, second):
        return np.empty((0, 2)) if self.motion_free(first, second) else None


class Round(Square):
    """A square in which states are joined by a detour."""

    def join(self, first, second):
        middle = 0.5 * (first + second) + np.array([0.0, 0.01])
        return middle[None]


class Counted(Square):
    """A square that counts the motions whose freedom is asked for."""

    def __init__(self):
        self.asked = 0
        super().__init__(self.count)

    def count(self, first, second):
        self.asked += 1
        return True


def shortened(path, space, rng, stop):
    """Return a path with shortcuts and its corners cut."""
    return with_corners_cut(with_shortcuts(path, space, rng, stop), space, stop)


@pytest.mark.parametrize('seed', range(10))
def test_shorter_and_free(seed):
    """The path stays free, keeps its ends and comes close to the shortest one."""
    path = shortened(DETOUR, Square(past_the_disc), np.random.default_rng(seed), never)
    assert all(past_the_disc(a, b) for a, b in pairwise(path))
    assert np.array_equal(path[[0, -1]], DETOUR[[0, -1]])
    tangent = 2.0 * (np.sqrt(0.5**2 - 0.3**2) + 0.3 * np.arcsin(0.3 / 0.5))
    assert tangent <= path_length(path) < 1.1 * tangent


def test_corners_are_cut_where_that_is_free_too():
    """What cuts a corner is asked for apart, and what it does not allow is left as it is."""
    asked = []

    def refuse(a, b):
        asked.append((a, b))
        return False

    def cut(corner_free):
        return shortened(
            DETOUR, Square(past_the_disc, corner_free), np.random.default_rng(0), never)

    assert path_length(cut(past_the_disc)) < path_length(cut(refuse))
    assert asked


def test_straight_where_nothing_is():
    """Without obstacles only the ends are left."""
    path = shortened(DETOUR, Square(lambda a, b: True), np.random.default_rng(0), never)
    assert np.array_equal(path, DETOUR[[0, -1]])


def test_blocked_shortcuts_leave_the_path():
    """A path without shortcuts stays as it is, and the search for them ends."""
    path = shortened(DETOUR, Square(lambda a, b: False), np.random.default_rng(0), never)
    assert np.array_equal(path, DETOUR)


def test_shortcuts_that_are_no_straight_lines():
    """What joins two points becomes part of the path."""
    space = Round(lambda a, b: False)
    path = shortened(DETOUR, space, np.random.default_rng(0), never)
    assert np.array_equal(path[[0, -1]], DETOUR[[0, -1]])
    assert path_length(path) < 0.9 * path_length(DETOUR)


def test_no_time_left():
    """When it is told to stop nothing is tried."""
    def refuse(a, b):
        raise AssertionError

    assert np.array_equal(
        shortened(DETOUR, Square(refuse), np.random.default_rng(0), lambda: True), DETOUR)


def test_repeats():
    """Points that equal the one before go, the ends stay."""
    points = np.array([[0.0], [0.0], [1.0], [1.0 + 1e-9]])
    assert without_repeats(points) == pytest.approx(np.array([[0.0], [1.0 + 1e-9]]))


def test_a_straight_path_needs_no_checks():
    """Waypoints at which a path goes on straight are left out unchecked, corners are not."""
    space = Counted()
    ends = np.array([[0.1, 0.2], [0.8, 0.4]])
    line = ends[0] + np.linspace(0.0, 1.0, 7)[:, None] ** 2 * (ends[1] - ends[0])
    assert np.array_equal(shortened(line, space, np.random.default_rng(0), never), ends)
    assert space.asked == 0
    bent = np.concatenate([line, [[0.9, 0.9]]])
    shortened(bent, space, np.random.default_rng(0), never)
    assert space.asked > 0
