# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The findings of a cycle, in the codes and wording of moveit_servo."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum


class ServoStatus(IntEnum):
    """Codes of ``moveit_msgs/msg/ServoStatus``."""

    INVALID = -1
    NO_WARNING = 0
    DECELERATE_FOR_APPROACHING_SINGULARITY = 1
    HALT_FOR_SINGULARITY = 2
    DECELERATE_FOR_LEAVING_SINGULARITY = 3
    DECELERATE_FOR_COLLISION = 4
    HALT_FOR_COLLISION = 5
    JOINT_BOUND = 6


#: What clients of upstream's servo compare messages with.
TEXTS: dict[ServoStatus, str] = {
    ServoStatus.INVALID: 'Invalid',
    ServoStatus.NO_WARNING: 'No warnings',
    ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY:
        'Moving closer to a singularity, decelerating',
    ServoStatus.HALT_FOR_SINGULARITY: 'Very close to a singularity, emergency stop',
    ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY:
        'Moving away from a singularity, decelerating',
    ServoStatus.DECELERATE_FOR_COLLISION: 'Close to a collision, decelerating',
    ServoStatus.HALT_FOR_COLLISION: 'Collision detected, emergency stop',
    ServoStatus.JOINT_BOUND: 'Close to a joint bound (position or velocity), halting',
}

_PRECEDENCE = (
    ServoStatus.INVALID,
    ServoStatus.HALT_FOR_COLLISION,
    ServoStatus.DECELERATE_FOR_COLLISION,
    ServoStatus.JOINT_BOUND,
    ServoStatus.HALT_FOR_SINGULARITY,
    ServoStatus.DECELERATE_FOR_APPROACHING_SINGULARITY,
    ServoStatus.DECELERATE_FOR_LEAVING_SINGULARITY,
    ServoStatus.NO_WARNING,
)


@dataclass(frozen=True, slots=True)
class Finding:
    """
    A finding about a cycle.

    :param detail: names joint, pair, field or number; may be ''.
    """

    code: ServoStatus
    detail: str = ''

    @property
    def message(self) -> str:
        """Upstream's words, with the detail behind them."""
        text = TEXTS[self.code]
        return f'{text}: {self.detail}' if self.detail else text


NOTHING = Finding(ServoStatus.NO_WARNING)


def weightiest(findings: Iterable[Finding]) -> Finding:
    """Return the finding that a status reports, of several."""
    return min(findings, key=lambda finding: _PRECEDENCE.index(finding.code), default=NOTHING)
