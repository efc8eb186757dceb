# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of grippers and how they end."""

from __future__ import annotations

from dataclasses import dataclass

from armsim_ros.control.action_goal import ActionGoal


@dataclass(frozen=True, slots=True)
class GripperResult:
    """
    How a gripper goal ended.

    :param position: measured [rad or m].
    :param velocity: measured [rad/s or m/s].
    :param effort: commanded, or the bound where a position is commanded [N*m or N].
    """

    position: float
    velocity: float
    effort: float
    stalled: bool
    reached_goal: bool


class GripperGoal(ActionGoal[GripperResult]):
    """
    A position to move to.

    :param position: [rad or m].
    :param effort: not to be exceeded, 0 for no bound [N*m or N].
    :param velocity: not to be exceeded, 0 for no bound [rad/s or m/s].
    """

    def __init__(self, position: float, effort: float, velocity: float = 0.0) -> None:
        super().__init__()
        self.position = position
        self.effort = effort
        self.velocity = velocity


@dataclass(frozen=True, slots=True)
class GripperResponse:
    """The answer to a gripper goal; with the reason of a refusal."""

    accepted: bool
    reason: str = ''
    goal: GripperGoal | None = None
