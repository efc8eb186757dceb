# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``control_msgs/msg/JointTolerance`` to the core's tolerances."""

from __future__ import annotations

from collections.abc import Iterable

from control_msgs.msg import JointTolerance as JointToleranceMessage

from armsim_ros.control.trajectory.tolerances import JointTolerance


def tolerances_from_messages(
    messages: Iterable[JointToleranceMessage],
) -> tuple[JointTolerance, ...]:
    """Return tolerances unchanged: 0 keeps the default, -1 erases it."""
    return tuple(
        JointTolerance(
            name=message.name,
            position=message.position,
            velocity=message.velocity,
            acceleration=message.acceleration,
        )
        for message in messages
    )
