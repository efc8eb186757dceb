# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Interpolation between waypoints, starts and ends of motions."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicHermiteSpline

from armsim_ros.control.trajectory.sampling import PreparedTrajectory
from armsim_ros.control.trajectory.waypoints import Waypoints

REST = np.zeros(3)


def motion(trajectory, *points, start=REST, time=0.0, joints=('a',), **options):
    """Return the motion of one joint through points, from a start state on."""
    given_points = trajectory(*points, joints=joints)
    prepared = PreparedTrajectory(Waypoints.of(given_points, joints), **options)
    state = np.asarray(start, dtype=float)
    return prepared.begin(time, state, state[: len(joints)])


@pytest.mark.parametrize(
    ('point', 'expected'),
    [
        (([0.4],), [(0.1, 0.2, 0), (0.2, 0.2, 0), (0.3, 0.2, 0)]),
        (([0.4], [0]), [(0.0625, 0.225, 0.3), (0.2, 0.3, 0), (0.3375, 0.225, -0.3)]),
        (
            ([0.4], [0], [0]),
            [(0.04140625, 0.2109375, 0.5625), (0.2, 0.375, 0), (0.35859375, 0.2109375, -0.5625)],
        ),
    ],
    ids=['linear', 'cubic', 'quintic'],
)
def test_degree_follows_what_the_points_give(trajectory, point, expected):
    """F1, F2, F3, F4, F5: line, cubic or quintic from rest to rest."""
    m = motion(trajectory, (2.0, *point))
    for time, values in zip((0.5, 1.0, 1.5), expected, strict=True):
        np.testing.assert_allclose(m.at(time), values, atol=1e-12)


def test_extra_fields_at_one_end_are_ignored(trajectory):
    """F1: accelerations at only one end of a segment leave a cubic."""
    m = motion(trajectory, (1.0, [0.0], [0.0], [0.0]), (3.0, [0.4], [0.0]))
    np.testing.assert_allclose(m.at(1.5), [0.0625, 0.225, 0.3], atol=1e-12)


def test_via_velocity(trajectory):
    """F6: cubics through a point with a velocity."""
    m = motion(trajectory, (1.0, [0.3], [0.3]), (2.0, [0.6], [0.0]))
    times = (0.25, 0.5, 0.75, 1.25, 1.5, 1.75)
    expected = (0.0328125, 0.1125, 0.2109375, 0.3890625, 0.4875, 0.5671875)
    np.testing.assert_allclose([m.at(t)[0] for t in times], expected, atol=1e-12)


def test_known_polynomials(trajectory):
    """F7: cubic and quintic give back the polynomials whose ends they match."""
    m = motion(trajectory, (2.0, [4.0], [10.0]), start=[0.0, -2.0, 0.0])
    root = math.sqrt(2.0)
    np.testing.assert_allclose(m.at(root), [0.0, 4.0, 6 * root], atol=1e-12)
    p = np.poly([0, 1, 2, 3, 4])
    ends = [[np.polyval(np.polyder(p, k), t) for k in range(3)] for t in (0.0, 2.0)]
    m = motion(trajectory, (2.0, [ends[1][0]], [ends[1][1]], [ends[1][2]]), start=ends[0])
    np.testing.assert_allclose(m.at(1.0), [0.0, -6.0, 10.0], atol=1e-11)


numbers = st.floats(-3.0, 3.0)
durations = st.floats(0.01, 20.0)


knots = st.tuples(durations, numbers, numbers, numbers)


@settings(deadline=None)
@given(st.lists(knots, min_size=1, max_size=6), st.data())
def test_equals_the_polynomials_of_scipy(trajectory, segments, data):
    """F3, F4: cubics and quintics equal scipy's to 1e-9, with their derivatives."""
    times = np.cumsum([s[0] for s in segments])
    breaks = np.concatenate(([0.0], times))
    for derivatives in (1, 2):
        points = [
            (t, *([value] for value in s[1 : 2 + derivatives]))
            for t, s in zip(times, segments, strict=True)
        ]
        m = motion(trajectory, *points)
        values = np.array([[0.0] * 3, *[s[1:] for s in segments]])
        time = data.draw(st.floats(0.0, float(times[-1])))
        if derivatives == 1:
            spline = CubicHermiteSpline(breaks, values[:, 0], values[:, 1])
        else:
            spline = BPoly.from_derivatives(breaks, values[:, :3], orders=5)
        sampled = m.at(time)
        for k in range(2):
            assert sampled[k] == pytest.approx(float(spline(time, nu=k)), abs=1e-9, rel=1e-9)


def test_last_point_holds_after_the_end(trajectory):
    """F8: after the end the last point's fields hold, those not given are 0."""
    m = motion(trajectory, (1.0, [0.5], [0.2]))
    np.testing.assert_array_equal(m.at(1.5), [0.5, 0.2, 0.0])


def test_none_takes_the_next_waypoint(trajectory):
    """F9: the start state until the first point's time, then always the next point."""
    m = motion(trajectory, (1.0, [0.3], [0.1]), (2.0, [0.6]), splines=False, start=[0.1, 0, 0])
    assert [m.at(t)[0] for t in (0.5, 1.0, 1.5, 2.0, 2.5)] == [0.1, 0.1, 0.6, 0.6, 0.6]
    assert m.at(1.5)[1] == 0.0


def test_velocities_are_integrated(trajectory):
    """F10: points with velocities alone get positions by the trapezoid rule."""
    m = motion(trajectory, (1.0, [], [1.0]), (2.0, [], [3.0]), start=[0.5, 0, 0])
    np.testing.assert_allclose([m.at(t)[0] for t in (1.0, 2.0)], [1.0, 3.0])


def test_velocities_are_integrated_from_rest(trajectory):
    """A start without velocity is at rest: the first segment is cubic (trajectory.cpp, sample)."""
    m = motion(trajectory, (1.0, [], [1.0]), (2.0, [], [2.0]), (3.0, [], [1.0]))
    np.testing.assert_allclose(m.at(0.0), [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(m.at(0.5)[:2], [0.125, 0.5])
    np.testing.assert_allclose([m.at(t)[0] for t in (1.0, 2.0, 3.0)], [0.5, 2.0, 3.5])


def test_accelerations_are_integrated_twice(trajectory):
    """F10: points with accelerations alone get velocities, then positions."""
    m = motion(trajectory, (1.0, [], [], [2.0]), (2.0, [], [], [0.0]))
    np.testing.assert_allclose(m.at(1.0)[:2], [0.5, 1.0])
    np.testing.assert_allclose(m.at(2.0)[:2], [2.0, 2.0])


@pytest.mark.parametrize(
    ('point', 'expected'),
    [(([], [1.0]), [(1.0, 0.0), (1.125, 0.5), (1.5, 1.0)]),
     (([], [], [1.0]), [(1.0, 0.0), (1.0625, 0.28125), (1.25, 0.5)])],
    ids=['cubic', 'quintic'],
)
def test_a_segment_to_an_integrated_point_begins_at_rest(trajectory, point, expected):
    """
    If the point before gives no derivatives; the segment to that point remains a line.

    trajectory.cpp, deduce_from_derivatives: what the first state lacks becomes 0.
    """
    m = motion(trajectory, (1.0, [1.0]), (2.0, *point))
    np.testing.assert_allclose(m.at(0.9)[:2], [0.9, 1.0])
    values = [m.at(t)[:2] for t in (1.0 + 1e-12, 1.5, 2.0)]
    np.testing.assert_allclose(values, expected, atol=1e-9)


def test_a_first_point_at_the_start_is_left_at_rest_towards_an_integrated_one(trajectory):
    """The same rule where the segment begins in the state at the start."""
    m = motion(trajectory, (0.0, [0.0]), (1.0, [], [1.0]))
    np.testing.assert_allclose([m.at(t)[:2] for t in (0.0, 0.5, 1.0)],
                               [(0.0, 0.0), (0.125, 0.5), (0.5, 1.0)], atol=1e-12)


def test_effort_is_linear_by_itself(trajectory):
    """F11: effort runs on a line, whatever the degree; a point without it counts as 0."""
    m = motion(
        trajectory, (1.0, [1.0], [0], [0], [4.0]), (2.0, [1.0], [0], [0]),
        start=np.zeros(4), effort=True,
    )
    assert [m.at(t)[3] for t in (0.5, 1.0, 1.5)] == pytest.approx([2.0, 4.0, 2.0])


def test_lead_in_takes_the_degree_of_the_first_point(trajectory):
    """E8: the start state has velocity and acceleration, so that the lead-in is a quintic."""
    m = motion(trajectory, (2.0, [0.4], [0.0], [0.0]))
    assert m.at(0.5)[0] == pytest.approx(0.04140625)


def test_points_of_the_past_are_left_out(trajectory):
    """E5: from a time inside the trajectory a segment leads to the first point still ahead."""
    m = motion(trajectory, (1.0, [5.0]), (2.0, [1.0]), time=1.5, start=[0.0, 0, 0])
    assert m.at(1.5)[0] == 0.0
    assert m.at(1.75)[0] == pytest.approx(0.5)
    assert m.end == 2.0


def test_first_point_at_the_start_gives_its_derivatives_only(trajectory):
    """E6: a first point at time 0 sets the velocity; a small step in position is blended out."""
    m = motion(trajectory, (0.0, [0.01], [1.0]), (1.0, [1.0], [0.0]))
    np.testing.assert_allclose(m.at(0.0)[:2], [0.0, 1.0])


def test_one_point_at_time_zero(trajectory):
    """E10: a single point is a trajectory, at time 0 too."""
    m = motion(trajectory, (0.0, [0.01]))
    assert m.at(0.0)[0] == 0.01
    assert m.end == 0.0


def test_very_short_segments(trajectory):
    """A microsecond between points is sampled without a hitch; one by one or all at once."""
    m = motion(trajectory, (1.0, [1.0]), (1.000001, [1.1]), (2.0, [0.0]))
    times = np.linspace(0.0, 2.5, 2501)
    np.testing.assert_array_equal(m.samples(times), [m.at(time) for time in times])
    assert np.abs(np.diff(m.samples(times)[:, 0])).max() < 0.11


@pytest.mark.parametrize(
    ('start', 'target', 'travel'),
    [
        (math.pi / 4, 4.5 * math.pi, math.pi / 4),
        (math.pi / 2, -1.75 * math.pi, -math.pi / 4),
        (0.0, math.pi, math.pi),
        (0.0, -math.pi, -math.pi),
        (0.0, 3 * math.pi, math.pi),
        (1.0, 1.0 + 6 * math.pi, 0.0),
    ],
)
def test_continuous_joints_take_the_short_way(trajectory, start, target, travel):
    """G3, G4, G5: at most half a turn; exactly half a turn keeps its direction."""
    m = motion(trajectory, (1.0, [target]), start=[start, 0, 0], continuous=np.array([0]))
    assert m.at(0.0)[0] == start
    assert m.at(1.0)[0] - start == pytest.approx(travel, abs=1e-12)


def test_more_than_a_turn_inside_a_message_is_followed(trajectory):
    """G6: only the start is wrapped; the motion from point to point is literal."""
    m = motion(
        trajectory, (1.0, [2 * math.pi]), (2.0, [7 * math.pi]),
        continuous=np.array([0]),
    )
    assert m.at(2.0)[0] - m.at(1.0)[0] == pytest.approx(5 * math.pi)
    assert m.at(1.0)[0] == pytest.approx(0.0)


def test_continuous_lead_in_is_never_more_than_half_a_turn(trajectory):
    """G3: for any start and target."""

    @settings(deadline=None)
    @given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
    def check(start, target):
        m = motion(trajectory, (1.0, [target]), start=[start, 0, 0], continuous=np.array([0]))
        travel = m.at(1.0)[0] - start
        assert abs(travel) <= math.pi + 1e-9
        assert math.remainder(start + travel - target, 2 * math.pi) == pytest.approx(0, abs=1e-9)

    check()
