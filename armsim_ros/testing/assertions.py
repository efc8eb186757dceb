# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Assertions about an arm that name the failure: joint, body, distance, limit, time."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsim_ros.testing.arm import Arm, Points, Target, Touch


def assert_reached(arm: Arm, goal: Target, tolerance: float = 1e-3) -> None:
    """
    Fail unless every joint of the goal is where the goal has it.

    :param goal: a named state, or joint -> position [rad or m].
    :param tolerance: [rad or m].
    """
    __tracebackhide__ = True
    joint, error = arm.distance(goal)
    if not abs(error) <= tolerance:
        name = f"'{goal}'" if isinstance(goal, str) else 'the goal'
        raise AssertionError(
            f"{arm.name} has not reached {name}: joint '{joint}' is {error:+.6f} off, "
            f'tolerance {tolerance:g}, at {arm.time:.3f} s')


def assert_no_collision(arm: Arm, since: float | None = None) -> None:
    """
    Fail where a link of the robot touched a link or an object that it does not rest on.

    :param since: simulated time from which on it counts [s]; None is the start of the test.
    """
    __tracebackhide__ = True
    own = f'{arm.name}/'
    hits = [touch for touch in arm.touches(since)
            if any(name.startswith(own) for name in touch.bodies)]
    if hits:
        raise AssertionError(f'{arm.name} was in collision: {_described(hits)}')


def assert_no_contact(
    arm: Arm, first: str, second: str | None = None, since: float | None = None
) -> None:
    """
    Fail where a body touched another.

    :param first: a link or an object.
    :param second: the other body; None is any.
    :param since: simulated time from which on it counts [s]; None is the start of the test.
    """
    __tracebackhide__ = True
    hits = [
        touch for touch in arm.touches(since)
        if touch.names(first) and (second is None or touch.names(second))]
    if hits:
        raise AssertionError(f"'{first}' was touched: {_described(hits)}")


def assert_holds(arm: Arm, name: str) -> None:
    """
    Fail unless fingers or a suction cup hold an object.

    :param name: of the object.
    """
    __tracebackhide__ = True
    held = arm.held()
    if name not in held:
        raise AssertionError(
            f"{arm.name} does not hold '{name}' but {', '.join(held) or 'nothing'}; "
            f'{arm.summary()}')


def assert_rejected(arm: Arm, points: Points, match: str = '') -> str:
    """
    Fail unless the controllers refuse a trajectory, and return their reason.

    :param points: as ``arm.follow`` takes them.
    :param match: a part of the reason.
    """
    __tracebackhide__ = True
    from armsim_ros.errors import ControllerError

    try:
        arm.follow(points)
    except ControllerError as error:
        reason = str(error)
    else:
        raise AssertionError(f'{arm.name} ran a trajectory that should have been refused')
    if match not in reason:
        raise AssertionError(f"the reason does not contain '{match}': {reason}")
    return reason


def _described(touches: list[Touch]) -> str:
    lines = [
        f"'{touch.bodies[0]}' and '{touch.bodies[1]}' overlapped by {touch.depth * 1e3:.2f} mm "
        f'from {touch.start:.3f} to {touch.end:.3f} s'
        for touch in touches[:5]]
    if len(touches) > 5:
        lines.append(f'and {len(touches) - 5} more')
    return '; '.join(lines)
