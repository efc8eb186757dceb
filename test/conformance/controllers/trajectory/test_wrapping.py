# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints that turn without end, and joints that follow others."""

from __future__ import annotations

from collections.abc import Callable
import math

from controller_bench import Bench, point, TrajectoryController
import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream
TURN = 2.0 * math.pi


@pytest.fixture
def wheels(bench: Bench) -> TrajectoryController:
    """Give the continuous joints, brought to a whole number of turns."""
    c = bench.use('wheels', home=False)
    if any(abs(math.remainder(p, TURN)) > 1e-9 for p in c.newest().reference.positions):
        assert c.run(c.to([0.0, 0.0], 0.2)).status == SUCCEEDED
    c.settle()
    return c


def start(c: TrajectoryController) -> list[float]:
    """Return the present reference."""
    return list(c.newest().reference.positions)


def move(c: TrajectoryController, target: list[float], time: float = 0.2) -> list[float]:
    """Move and return by how much each reference changed in all."""
    before = start(c)
    c.states.clear()
    assert c.run(c.to(target, time)).status == SUCCEEDED
    c.next_state(lambda s: max(map(abs, s.reference.velocities)) == 0.0
                 and all(abs(math.remainder(a - b, TURN)) < 1e-6
                         for a, b in zip(s.reference.positions, target, strict=True)))
    c.settle()
    return [a - b for a, b in zip(start(c), before, strict=True)]


@statement('G1', 'C2')
@upstream('continuous_joint_without_urdf_limits')
def test_a_continuous_joint_without_limits_runs(wheels: TrajectoryController) -> None:
    """A continuous joint needs no limit in the URDF; revolute joints do not wrap."""
    assert move(wheels, [0.3, -0.3]) == pytest.approx([0.3, -0.3])


@statement('G2', 'J4')
@upstream('compute_error_angle_wraparound_true', 'position_error_angle_wraparound')
def test_errors_of_continuous_joints_are_short(wheels: TrajectoryController) -> None:
    """The error of a continuous joint never exceeds half a turn."""
    before = start(wheels)
    move(wheels, [b + 0.75 * TURN for b in before])
    for state in wheels.watch(3):
        assert max(map(abs, state.error.positions)) < math.pi


@statement('G2', 'J4')
@upstream('compute_error_angle_wraparound_false', 'position_error_not_angle_wraparound')
def test_errors_of_other_joints_are_plain(arm: TrajectoryController) -> None:
    """The error of a revolute joint is the plain difference."""
    arm.go([4.0, -4.0], 0.6)
    for state in arm.watch(3):
        for reference, feedback, error in zip(
            state.reference.positions, state.feedback.positions, state.error.positions, strict=True
        ):
            assert error == pytest.approx(reference - feedback, abs=1e-9)


@statement('G3')
@upstream('wraparound_single_joint', 'jointWraparound')
@pytest.mark.parametrize('turns', [1, -2])
def test_the_short_way_without_a_step(wheels: TrajectoryController, turns: int) -> None:
    """A target that is whole turns away is reached by the short way, the command continuous."""
    before = start(wheels)
    wheels.states.clear()
    moved = move(wheels, [before[0] + 0.4 + turns * TURN, before[1]])
    assert moved == pytest.approx([0.4, 0.0], abs=1e-6)
    outputs = [s.output.positions[0] for s in wheels.states.messages]
    assert max(outputs) - min(outputs) < 1.0


@statement('G3')
@upstream('wraparound_all_joints', 'wraparound_all_joints_no_offset', 'no_wraparound')
def test_each_joint_takes_its_own_short_way(wheels: TrajectoryController) -> None:
    """The rule holds for each joint by itself."""
    before = start(wheels)
    target = [before[0] + TURN - 0.2, before[1] + 0.3]
    assert move(wheels, target) == pytest.approx([-0.2, 0.3], abs=1e-6)


@statement('G4')
@upstream('jointWraparoundPiSingularity')
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_half_a_turn(wheels: TrajectoryController, sign: float) -> None:
    """Half a turn away is half a turn, never more."""
    before = start(wheels)
    moved = move(wheels, [before[0] + sign * math.pi, before[1]], 0.3)
    assert abs(moved[0]) == pytest.approx(math.pi, abs=1e-6)
    assert moved[0] * sign > 0.0


@statement('G5')
@upstream('jointWraparound', 'jointWrapping')
def test_the_example_of_the_reference(wheels: TrajectoryController) -> None:
    """From (pi/4, pi/2) to (4.5 pi, -1.75 pi) each joint moves only pi/4."""
    move(wheels, [math.pi / 4, math.pi / 2], 0.3)
    moved = move(wheels, [4.5 * math.pi, -1.75 * math.pi], 0.3)
    assert moved == pytest.approx([math.pi / 4, -math.pi / 4], abs=1e-6)


@statement('G6')
def test_turns_inside_a_message_are_followed(wheels: TrajectoryController) -> None:
    """More than a turn from point to point is followed to the letter."""
    before = start(wheels)
    trajectory = wheels.trajectory(
        point(0.05, before), point(0.6, [before[0] + 1.5 * TURN, before[1]])
    )
    assert wheels.run(trajectory).status == SUCCEEDED
    assert wheels.reaches([before[0] + 1.5 * TURN, before[1]])


@statement('G7')
def test_a_mimic_joint_follows(bench: Bench) -> None:
    """It has no command interface, moves with multiplier and offset, and is published."""
    commands = {i.name for i in bench.manager.hardware_interfaces().command_interfaces}
    assert 'finger/position' in commands
    assert not any(name.startswith('twin/') for name in commands)
    states = bench.client.collect(bench.name('joint_states'), JointState)
    for message in states.wait(3):
        joints = dict(zip(message.name, message.position, strict=True))
        assert joints['twin'] == pytest.approx(2.0 * joints['finger'] + 0.01, abs=2e-3)
    states.close()


@statement('G7', 'C2')
def test_a_mimic_joint_cannot_be_controlled(bench: Bench, load: Callable[..., bool]) -> None:
    """A controller that lists a mimic joint fails at the latest when it is activated."""
    ok = load('wants_the_twin', joints=['finger', 'twin'])
    if ok and bench.manager.configure('wants_the_twin'):
        assert not bench.manager.switch(activate=['wants_the_twin']).ok
