"""The tolerance check against a plain comparison of every value with its limit."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np

from armsim_ros.control.trajectory.tolerances import (
    JointTolerance,
    SegmentTolerances,
    ToleranceCheck,
)

JOINTS = ('a', 'b', 'c')
QUANTITIES = ('position', 'velocity', 'acceleration')

limits = st.one_of(st.just(np.inf), st.floats(1e-6, 1e3))
#: Around the limits, so that both sides and equality are met.
shares = st.one_of(st.sampled_from([-1.0, 0.0, 1.0]), st.floats(-3.0, 3.0))


def tables(values):
    """Draw a (3, 3) table: position, velocity and acceleration of three joints."""
    return st.lists(values, min_size=9, max_size=9).map(lambda rows: np.reshape(rows, (3, 3)))


def exceeded(errors, limits, computed):
    """Return which errors of the computed quantities are above their limits."""
    return (np.abs(errors) > limits) & np.array(computed)[:, None]


@settings(deadline=None)
@given(tables(limits), tables(shares), st.lists(st.booleans(), min_size=3, max_size=3))
def test_a_violation_is_an_error_above_its_limit(limits, shares, computed):
    """An error equal to its limit is allowed; a quantity without an error is not checked."""
    errors = np.where(np.isfinite(limits), shares * np.where(np.isfinite(limits), limits, 0), 1e9)
    check = ToleranceCheck(JOINTS, limits, computed)
    assert check.violated(errors) == exceeded(errors, limits, computed).any()


@settings(deadline=None)
@given(tables(limits), tables(shares))
def test_the_reported_violation_has_the_largest_share(limits, shares):
    """The violation names the joint and quantity with the largest ratio of error to limit."""
    errors = np.where(np.isfinite(limits), shares * np.where(np.isfinite(limits), limits, 0), 1e9)
    check = ToleranceCheck(JOINTS, limits, [True] * 3)
    if not check.violated(errors):
        return
    worst = check.worst(errors)
    row, column = QUANTITIES.index(worst.quantity), JOINTS.index(worst.joint)
    assert (worst.error, worst.limit) == (errors[row, column], limits[row, column])
    assert abs(worst.error) / worst.limit == np.max(np.abs(errors) / limits)


own = st.one_of(st.sampled_from([0.0, -1.0, -1.0 + 1e-8, -0.5, np.nan]), st.floats(-2.0, 10.0))
tolerances = st.lists(
    st.builds(JointTolerance, st.sampled_from([*JOINTS, 'x']), own, own, own), max_size=3)


@settings(deadline=None, max_examples=300)
@given(tables(limits), tables(limits), tolerances, tolerances, own)
def test_a_goal_replaces_tolerances_value_by_value_or_none(path, goal, own_path, own_goal, time):
    """A single illegal value or unknown joint leaves all defaults; else each value counts."""
    defaults = SegmentTolerances(path, goal, 0.7)
    result, complaint = defaults.overridden(JOINTS, own_path, own_goal, time)
    given_values = [(table, each.name, row, getattr(each, quantity))
                    for table, each_table in ((0, own_path), (1, own_goal)) for each in each_table
                    for row, quantity in enumerate(QUANTITIES)]
    legal = [value >= 0.0 or abs(value + 1.0) < 1e-7
             for value in (*(value for *_, value in given_values), time)]
    if not all(legal) or any(name == 'x' for _, name, *_ in given_values):
        assert complaint
        assert result is defaults
        return
    expected = [path.copy(), goal.copy()]
    for table, name, row, value in given_values:
        if value:
            expected[table][row, JOINTS.index(name)] = np.inf if value < 0.0 else value
    assert complaint == ''
    np.testing.assert_array_equal([result.path, result.goal], expected)
    assert result.goal_time == (0.7 if time == 0.0 else max(time, 0.0))
