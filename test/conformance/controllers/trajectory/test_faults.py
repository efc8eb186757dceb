# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints that fail on purpose: tolerances that are violated as they are in life."""

from __future__ import annotations

from collections.abc import Callable
import re

from controller_bench import Bench, duration, point, Result, tolerance, TrajectoryController
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import pytest

from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream
Fault = Callable[..., None]


@statement('U4', 'H7', 'U1')
@upstream('pathToleranceViolation', 'pathToleranceViolationSingleJoint',
          'test_state_tolerances_fail')
def test_a_blocked_joint(bench: Bench, fault: Fault) -> None:
    """The path tolerance is violated; the text names joint, error, limit and time; it holds."""
    c = bench.use('constrained')
    fault('axis_2', 'blocked', True)
    outcome = c.run(c.to([1.0, 1.0], 0.5))
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.PATH_TOLERANCE_VIOLATED
    assert 'axis_2' in outcome.error_string
    error, limit, _ = map(float, re.findall(r'-?\d+\.\d+', outcome.error_string)[:3])
    assert abs(error) >= limit == 0.2
    held = c.newest()
    assert held.reference.positions == pytest.approx(held.feedback.positions, abs=0.05)
    assert held.reference.positions[1] == pytest.approx(0.0, abs=0.01)


@statement('U4', 'H10', 'U1')
@upstream('goalToleranceViolation', 'goalToleranceViolationSingleJoint',
          'test_goal_tolerances_fail')
def test_a_biased_joint(bench: Bench, fault: Fault) -> None:
    """The goal tolerance is violated after goal_time; the text names the joint."""
    c = bench.use('constrained')
    fault('axis_1', 'bias', 0.15)
    outcome = c.run(c.to([0.3, 0.3], 0.2))
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.GOAL_TOLERANCE_VIOLATED
    assert 'goal_time_tolerance' in outcome.error_string
    assert 'axis_1' in outcome.error_string


@statement('U4', 'H2')
def test_a_biased_joint_and_a_generous_goal(bench: Bench, fault: Fault) -> None:
    """A goal's own tolerance makes room for the error."""
    c = bench.use('constrained')
    fault('axis_1', 'bias', 0.15)
    outcome = c.run(c.to([0.3, 0.3], 0.2), goal_tolerance=[tolerance('axis_1', 0.3)])
    assert outcome.status == SUCCEEDED


@statement('U4', 'H9')
def test_a_lagging_joint_arrives_late(bench: Bench, fault: Fault) -> None:
    """Inside the goal time a late joint still succeeds, after the last waypoint."""
    c = bench.use('constrained')
    fault('axis_1', 'lag', 0.1)
    goal = c.goal(
        c.trajectory(point(0.3, [0.15, 0.0])),
        goal_tolerance=[tolerance('axis_1', 0.005)],
        goal_time_tolerance=duration(5.0),
    )
    outcome = goal.result()
    assert outcome.status == SUCCEEDED
    assert goal.feedback[-1].desired.time_from_start.nanosec > 300_000_000


@statement('U4')
def test_diagnostics_show_the_fault(bench: Bench, fault: Fault) -> None:
    """/diagnostics warns of every joint that fails on purpose, and is well again after."""
    topic = bench.client.collect('/diagnostics', DiagnosticArray)

    def shown(level: bytes, word: str) -> Callable[[DiagnosticArray], bool]:
        return lambda message: any(
            status.name.endswith('Fault Injection') and status.level == level
            and word in str([(v.key, v.value) for v in status.values])
            for status in message.status
        )

    fault('axis_1', 'lag', 0.25)
    topic.wait_for(shown(DiagnosticStatus.WARN, "('axis_1', 'lag 0.25 s')"))
    fault('axis_1', 'lag', 0.0)
    topic.clear()
    topic.wait_for(shown(DiagnosticStatus.OK, '[]'))
    topic.close()


@statement('U4')
@pytest.mark.parametrize(('kind', 'value'), [('lag', -1.0), ('bias', float('nan'))])
def test_bad_faults_are_refused(
    bench: Bench, fault: Fault, kind: str, value: float
) -> None:
    """A lag below 0 and numbers that are none are refused."""
    manager = ParameterClient(bench.client, bench.name('controller_manager'))
    assert manager.set(f'faults.axis_1.{kind}', value) != ''
    assert manager.get(f'faults.axis_1.{kind}') == 0.0


def test_the_arm_is_well_afterwards(arm: TrajectoryController) -> None:
    """Faults that were taken back leave nothing behind."""
    assert arm.run(arm.to([0.2, 0.1], 0.2)).status == SUCCEEDED
    arm.settle()
