# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Motions of the arm that tests look at while they go on."""

from __future__ import annotations

from typing import Any

from move_group_bench import seconds

#: Slow enough for whatever a test does meanwhile, also at several times the wall's pace.
SLOW = {'max_velocity_scaling_factor': 0.02, 'max_acceleration_scaling_factor': 0.3}


def target(arm: Any) -> dict[str, float]:
    """Return a state some way off."""
    first, second = list(arm.states.values())[:2]
    return {name: 0.5 * (first[name] + second[name]) for name in first}


def until_moving(arm: Any, least: float = 0.02) -> None:
    """Wait until a joint has moved [rad]."""
    first = arm.positions()
    for _ in range(2000):
        now = arm.positions()
        if max(abs(now[name] - first[name]) for name in first) > least:
            return
    raise AssertionError('the arm does not move')


def until_at_rest(arm: Any) -> float:
    """Wait until the arm stands still and return how long that took by the stamps [s]."""
    arm.joint_states.clear()
    first = last = arm.joint_states.wait(1)[-1]
    for _ in range(100):
        arm.joint_states.clear()
        now = arm.joint_states.wait(5)[-1]
        if max(abs(a - b) for a, b in zip(now.position, last.position, strict=True)) < 2e-4:
            return seconds(now.header.stamp) - seconds(first.header.stamp)
        last = now
    raise AssertionError('the arm does not come to rest')
