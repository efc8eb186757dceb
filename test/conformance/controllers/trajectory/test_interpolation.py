# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The reference between waypoints, compared with polynomials that SciPy makes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from controller_bench import Bench, feedback_samples, point, Sample, seconds, TrajectoryController
import numpy as np
import pytest
from scipy.interpolate import BPoly
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream
#: Times come as whole nanoseconds, and velocities here stay below 20 rad/s.
EXACT = 1e-6


def samples_of(
    controller: TrajectoryController, trajectory: JointTrajectory,
    enough: Callable[[list[Sample]], bool] = lambda samples: len(samples) >= 5,
) -> list[Sample]:
    """Run a trajectory and return the references that its feedback showed."""
    for _ in range(4):  # a busy machine may show little of a run
        goal = controller.goal(trajectory)
        assert goal.result().status == SUCCEEDED
        samples = [s for s in feedback_samples(goal)[1:] if s.time > 0.0]
        if enough(samples):
            return samples
        controller.reaches(trajectory.points[-1].positions)
        controller.home()
    pytest.fail('too little feedback')


def check(
    samples: Sequence[Sample],
    knots: Sequence[float],
    states: Sequence[Sequence[float]],
) -> None:
    """
    Compare the first joint with the piecewise polynomial through states at knots.

    :param states: (position, velocity, ...) at each knot; as many at both ends of a segment.
    """
    curve = BPoly.from_derivatives(knots, states)
    for sample in samples:
        if sample.time >= knots[-1]:
            continue
        for i, value in enumerate(
            (sample.positions[0], sample.velocities[0], sample.accelerations[0])
        ):
            expected = float(curve(sample.time, nu=i))
            assert value == pytest.approx(expected, abs=EXACT * 50.0**i), sample


@statement('F1', 'F2', 'F5')
@upstream('sample_trajectory_positions')
def test_positions_alone_are_joined_by_straight_lines(sampled: TrajectoryController) -> None:
    """Linear: constant velocity, no acceleration; p(T/4, T/2, 3T/4) are 1/4, 1/2, 3/4."""
    samples = samples_of(sampled, sampled.to([0.4, -0.4], 0.4))
    check(samples, [0.0, 0.4], [[0.0], [0.4]])
    for sample in samples:
        if sample.time < 0.4:
            assert sample.velocities == pytest.approx([1.0, -1.0])
            assert sample.accelerations == pytest.approx([0.0, 0.0])


@statement('F3', 'F5')
@upstream('interpolation_pos_vel')
def test_velocities_give_cubics(sampled: TrajectoryController) -> None:
    """Cubic from rest to rest: p(1/4, 1/2, 3/4) are 0.15625, 0.5, 0.84375 of the way."""
    samples = samples_of(sampled, sampled.trajectory(point(0.4, [0.4, 0.1], [0.0, 0.0])))
    check(samples, [0.0, 0.4], [[0.0, 0.0], [0.4, 0.0]])
    curve = BPoly.from_derivatives([0.0, 2.0], [[0.0, 0.0], [0.4, 0.0]])
    assert curve([0.5, 1.0, 1.5]) == pytest.approx([0.0625, 0.2, 0.3375])


@statement('F4', 'F5')
@upstream('interpolation_pos_vel_accel')
def test_accelerations_give_quintics(sampled: TrajectoryController) -> None:
    """Quintic from rest to rest: 0.103515625, 0.5, 0.896484375 of the way."""
    samples = samples_of(
        sampled, sampled.trajectory(point(0.4, [0.4, 0.1], [0.0, 0.0], [0.0, 0.0]))
    )
    check(samples, [0.0, 0.4], [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    curve = BPoly.from_derivatives([0.0, 2.0], [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    assert curve([0.5, 1.0, 1.5]) == pytest.approx([0.04140625, 0.2, 0.35859375])


@statement('F1')
def test_extra_fields_at_one_end_are_ignored(sampled: TrajectoryController) -> None:
    """The degree is what both ends have: accelerations at one end alone change nothing."""
    samples = samples_of(
        sampled,
        sampled.trajectory(
            point(0.2, [0.1, 0.1], [0.8, 0.8]),
            point(0.4, [0.3, 0.3], [0.0, 0.0], [9.0, 9.0]),
        ),
    )
    check(samples, [0.0, 0.2, 0.4], [[0.0, 0.0], [0.1, 0.8], [0.3, 0.0]])


@statement('F6')
def test_a_velocity_on_the_way(sampled: TrajectoryController) -> None:
    """A via point's velocity is met: the curve of the check values, five times as fast."""
    samples = samples_of(
        sampled,
        sampled.trajectory(
            point(0.2, [0.3, 0.0], [1.5, 0.0]), point(0.4, [0.6, 0.0], [0.0, 0.0])
        ),
    )
    check(samples, [0.0, 0.2, 0.4], [[0.0, 0.0], [0.3, 1.5], [0.6, 0.0]])
    slow = BPoly.from_derivatives([0.0, 1.0, 2.0], [[0.0, 0.0], [0.3, 0.3], [0.6, 0.0]])
    assert slow([0.25, 0.5, 0.75]) == pytest.approx([0.0328125, 0.1125, 0.2109375])
    assert slow([1.25, 1.5, 1.75]) == pytest.approx([0.3890625, 0.4875, 0.5671875])


def derivatives(polynomial: np.polynomial.Polynomial, time: float, count: int) -> list[float]:
    """Return value, velocity ... of a polynomial."""
    return [float(polynomial.deriv(i)(time)) if i else float(polynomial(time))
            for i in range(count)]


@statement('F7')
@upstream('interpolation_pos_vel', 'interpolation_pos_vel_accel')
@pytest.mark.parametrize('levels', [2, 3], ids=['cubic', 'quintic'])
def test_polynomials_of_the_reference(bench: Bench, levels: int) -> None:
    """Between two points of x^3 - 2x, or x(x-1)(x-2)(x-3)(x-4), the reference is the curve."""
    P = np.polynomial.Polynomial
    curve = P([0.0, -2.0, 0.0, 1.0]) if levels == 2 else P.fromroots([0, 1, 2, 3, 4]) * 0.1
    c = bench.use('integrating')  # takes a last point that moves
    begin, end = derivatives(curve, 0.0, levels), derivatives(curve, 2.0, levels)
    quick = 4.0  # the same curve in a quarter of the time
    states = [[v * quick**i for i, v in enumerate(values)] for values in (begin, end)]
    first = point(0.2, *[[value, 0.0] for value in states[0]])
    last = point(0.2 + 2.0 / quick, *[[value, 0.0] for value in states[1]])
    rest = point(0.9, *[[states[1][0], 0.0], [0.0, 0.0], [0.0, 0.0]][:levels])
    goal = c.goal(c.trajectory(first, last, rest))
    assert goal.result().status == SUCCEEDED
    for sample in feedback_samples(goal):
        x = (sample.time - 0.2) * quick
        if 0.01 < x < 1.99:
            assert sample.positions[0] == pytest.approx(float(curve(x)), abs=1e-5)
            assert sample.velocities[0] == pytest.approx(
                float(curve.deriv()(x)) * quick, abs=1e-4
            )
            assert sample.accelerations[0] == pytest.approx(
                float(curve.deriv(2)(x)) * quick**2, abs=1e-2
            )


@statement('F8', 'F13')
@upstream('sample_trajectory_positions')
def test_after_the_last_point_it_stands_there(sampled: TrajectoryController) -> None:
    """After the end the reference is the last point with zero derivatives."""
    assert sampled.run(sampled.to([0.2, 0.1], 0.1)).status == SUCCEEDED
    assert sampled.reaches([0.2, 0.1])
    for state in sampled.watch(3):
        assert state.reference.positions == pytest.approx([0.2, 0.1])
        assert state.reference.velocities == pytest.approx([0.0, 0.0])
        assert state.reference.accelerations == pytest.approx([0.0, 0.0])


@statement('F9', 'B13')
@upstream('skip_interpolation')
def test_without_interpolation_the_next_waypoint_is_taken(bench: Bench) -> None:
    """Method 'none': the start state until the first point, then always the next waypoint."""
    c = bench.use('stepping')
    trajectory = c.trajectory(
        point(0.3, [0.01, 0.0]), point(0.6, [0.02, 0.0]), point(0.9, [0.03, 0.0])
    )

    def within(samples: list[Sample]) -> list[tuple[int, Sample]]:
        """Return the samples apart from the waypoints, with the numbers of their segments."""
        return [(min(int(sample.time / 0.3), 2), sample) for sample in samples
                if abs(sample.time / 0.3 - round(sample.time / 0.3)) > 1e-6]

    samples = samples_of(c, trajectory, lambda found: {k for k, _ in within(found)} == {0, 1, 2})
    for segment, sample in within(samples):
        assert sample.positions[0] == pytest.approx([0.0, 0.02, 0.03][segment]), sample
        assert sample.velocities[0] == 0.0


@statement('F10', 'B7')
@upstream('sample_trajectory_velocity_with_interpolation',
          'sample_trajectory_acceleration_with_interpolation')
@pytest.mark.parametrize('kind', ['velocities', 'accelerations'])
def test_derivatives_alone_are_integrated(bench: Bench, kind: str) -> None:
    """The trapezoid rule between points gives the missing levels."""
    c = bench.use('integrating')
    if kind == 'velocities':
        points = [point(0.0, (), [0.0, 0.0]), point(0.2, (), [1.0, 0.0]),
                  point(0.4, (), [0.0, 0.0])]
        expected = 0.2
    else:
        points = [point(0.0, (), (), [2.0, 0.0]), point(0.2, (), (), [2.0, 0.0]),
                  point(0.4, (), (), [2.0, 0.0])]
        expected = 0.16
    assert c.run(c.trajectory(*points)).status == SUCCEEDED
    c.next_state(lambda s: s.reference.velocities[0] == 0.0)
    c.next_state(lambda s: abs(s.reference.positions[0] - expected) < 2e-2)


@statement('F11')
def test_effort_is_linear_and_apart(bench: Bench) -> None:
    """Efforts are interpolated linearly, whatever the positions do."""
    c = bench.use('with_effort')
    c.states.clear()
    goal = c.goal(
        c.trajectory(
            point(0.0, [0.0, 0.0], [0.0, 0.0], effort=[0.0, 0.0]),
            point(0.4, [0.1, 0.1], [0.0, 0.0], effort=[2.0, 0.0]),
        )
    )
    assert goal.result().status == SUCCEEDED
    shown = [message.desired for message in goal.feedback]
    for desired in shown:
        time = seconds(desired.time_from_start)
        if 0.0 < time < 0.4 and len(desired.effort):
            assert desired.effort[0] == pytest.approx(5.0 * time, abs=1e-6)


@statement('F8')
@upstream('update_trajectory')
def test_a_second_trajectory_is_sampled_from_its_own_start(
    sampled: TrajectoryController
) -> None:
    """Times of a new trajectory count from its start, positions from where the old one was."""
    sampled.goal(sampled.to([0.6, 0.0], 0.6)).wait_for_feedback(3)
    goal = sampled.goal(sampled.to([0.0, 0.4], 1.6))
    assert goal.result().status == SUCCEEDED
    samples = [s for s in feedback_samples(goal)[1:] if s.time < 1.6]
    assert samples, 'no feedback'
    for sample in samples:
        assert sample.positions[1] == pytest.approx(sample.time / 4, abs=1e-6)
    slopes = {round(s.velocities[0], 6) for s in samples}
    assert len(slopes) == 1
    start = samples[0].positions[0] - samples[0].time * samples[0].velocities[0]
    assert 0.0 < start < 0.6


@statement('E8')
@upstream('fill_point_before_with_same_degree_as_traj')
def test_a_start_without_derivatives_is_at_rest(bench: Bench) -> None:
    """The lead-in has the degree of the first point though the start has positions alone."""
    c = bench.use('positions_only')
    c.states.clear()
    assert c.run(c.trajectory(point(1.2, [0.4, 0.0], [0.0, 0.0], [0.0, 0.0]))).status == SUCCEEDED
    curve = BPoly.from_derivatives([0.0, 1.2], [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])
    shown = [state.reference for state in c.states.messages]
    between = [(seconds(reference.time_from_start), reference.positions[0]) for reference in shown
               if 1e-4 < reference.positions[0] < 0.3999]
    assert between, 'no state while it moved'
    for time, position in between:
        assert position == pytest.approx(float(curve(time)), abs=1e-6)


@statement('F1')
@upstream('sample_velocity_only_skipped_last_segment_deduces_positions',
          'sample_velocity_only_all_segments_skipped_returns_false')
def test_very_short_segments(sampled: TrajectoryController) -> None:
    """Segments that are shorter than an update do no harm."""
    points = [point(0.001 * (i + 1), [1e-4 * (i + 1), 0.0]) for i in range(100)]
    assert sampled.run(sampled.trajectory(*points)).status == SUCCEEDED
    assert sampled.reaches([0.01, 0.0])
    one = sampled.trajectory(point(0.001, [0.0105, 0.0]))
    assert sampled.run(one).status == SUCCEEDED

