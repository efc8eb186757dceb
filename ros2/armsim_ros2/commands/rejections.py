# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Prints why move_group refuses a change of its scene; neither topic nor service returns that."""

from __future__ import annotations

from collections.abc import Callable
import sys
import time
from typing import Any

from armsim_ros2.session import Session

_KINDS = {'CollisionObject', 'AttachedCollisionObject', 'PlanningScene', 'PlanningSceneWorld',
          'ApplyPlanningScene'}
#: Time to find the publisher of the reasons, and for the last reason to arrive [s].
_PATIENCE = 0.5


def print_rejections(session: Session, name: str, kind: type[Any]) -> Callable[[], None]:
    """
    Print the reasons for which what is sent is refused, while the session spins.

    :param name: of the topic or service; the reasons come on ``rejected_scene_changes`` beside it.
    :param kind: its type.
    :returns: waits for the last reason.
    """
    if kind.__name__ not in _KINDS or not kind.__module__.startswith('moveit_msgs'):
        return lambda: None
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    reasons: list[str] = []
    start = time.time_ns()

    def receive(message: Any, info: Any) -> None:
        if info['source_timestamp'] > start:  # a late subscriber gets the last reason, too
            reasons.append(message.data)
            print(f'rejected: {message.data}', file=sys.stderr, flush=True)

    with_info: Any = receive  # rclpy's annotations lack the second argument
    reports = session.node.create_subscription(
        String, f'{name.rpartition("/")[0]}/rejected_scene_changes', with_info,
        QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    if not session.spin(lambda: reports.get_publisher_count() > 0, _PATIENCE):
        return lambda: None

    def wait() -> None:
        session.spin(lambda: bool(reasons), _PATIENCE)

    return wait
