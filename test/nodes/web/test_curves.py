# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories as curves."""

import numpy as np
import pytest

from armsim_ros.nodes.web.curves import curves_of, MOST_POINTS, Trace


def test_between_two_points_the_curve_is_smooth():
    """Of rest to rest, the cubic is in the middle half way; any cubic is met."""
    curves = curves_of(['a'], [0.0, 2.0], [[0.0], [1.0]], [[0.0], [0.0]], [[0.0], [0.0]])
    assert curves.at(1.0) == {'a': pytest.approx(0.5)}
    assert curves.at(-1.0) == {'a': 0.0}
    assert curves.at(9.0) == {'a': 1.0}
    curves = curves_of(['a'], [0.0, 2.0], [[1.0], [27.0]], [[3.0], [27.0]], [[0.0], [0.0]])
    assert curves.at(0.5) == {'a': pytest.approx(1.5**3)}


def test_derivatives_that_are_not_given_are_computed():
    """A controller may publish positions alone."""
    times = np.linspace(0.0, 1.0, 101)
    curves = curves_of(['a'], times, np.sin(times)[:, None])
    assert np.allclose(curves.velocities[:, 0], np.cos(times), atol=1e-2)


def test_a_panel_gets_no_more_points_than_it_can_show():
    """The first and the last are among them."""
    times = np.arange(5000.0)
    form = curves_of(['a'], times, times[:, None]).form()
    assert len(form['times']) <= MOST_POINTS
    assert (form['times'][0], form['times'][-1]) == (0.0, 4999.0)


@pytest.mark.parametrize(('times', 'positions'), [
    ([0.0], [[1.0, 2.0]]), ([], []), ([0.0], [[float('nan')]])])
def test_points_that_do_not_fit_are_refused(times, positions):
    """A plan of a stranger's planner may be anything."""
    with pytest.raises(ValueError):
        curves_of(['a'], times, positions)


def test_a_trace_counts_time_from_its_first_report():
    """Whatever the clock showed then."""
    trace = Trace()
    for time in (1000.0, 1000.5):
        trace.add(time, ['a', 'b'], [1.0, 2.0], [0.9, 2.0], [0.1, 0.0])
    trace.add(1001.0, ['a', 'b'], [1.0], [], [])
    assert trace.form()['a'] == {
        'times': [0.0, 0.5], 'desired': [1.0, 1.0], 'actual': [0.9, 0.9], 'error': [0.1, 0.1]}
