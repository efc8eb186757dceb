# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Quality-of-service profiles of every endpoint.

A publisher offers as much as it can (reliable, and the last value kept where it is a state), a
subscription asks for as little as it can, so that any client's choice matches. What Fast DDS
makes of the "system default" profile was measured: reliable and transient-local for a
publisher, best effort, volatile and of depth 1 for a subscription.
"""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)


def _profile(
    reliability: QoSReliabilityPolicy,
    durability: QoSDurabilityPolicy,
    depth: int,
    history: QoSHistoryPolicy = QoSHistoryPolicy.KEEP_LAST,
    **more: Duration,
) -> QoSProfile:
    return QoSProfile(
        reliability=reliability, durability=durability, depth=depth, history=history, **more
    )


STATE = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Publishers of a state that is renewed all the time: joint_states, controller_state."""

LATCHED = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Publishers of a text or state that late subscribers must get: robot_description, tf_static."""

EVENTS = _profile(
    QoSReliabilityPolicy.RELIABLE,
    QoSDurabilityPolicy.TRANSIENT_LOCAL,
    1,
    lifespan=Duration(seconds=10),
)
"""
Publishers of rare events, the last of which matters for a while to late subscribers:
rejected_goals.
"""

CLOCK = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 1)
"""Publisher of /clock; the subscription of rclcpp and rclpy is best effort, depth 1."""

TF = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 100)
"""Publisher of /tf, as tf2_ros has it."""

DIAGNOSTICS = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 10)
"""Publisher of /diagnostics, as diagnostic_updater has it."""

PICTURES = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.VOLATILE, 2)
"""Publishers of camera pictures and of what belongs to them."""

COMMAND = _profile(QoSReliabilityPolicy.BEST_EFFORT, QoSDurabilityPolicy.VOLATILE, 1)
"""
Subscriptions to commands: match every publisher, and only the newest message counts, as with
upstream's "system default".
"""

SERVICES = _profile(
    QoSReliabilityPolicy.RELIABLE,
    QoSDurabilityPolicy.VOLATILE,
    0,
    QoSHistoryPolicy.KEEP_ALL,
)
"""Services: a burst of requests loses none."""

ACTION_SERVICES = dict.fromkeys(
    ('goal_service_qos_profile', 'result_service_qos_profile', 'cancel_service_qos_profile'),
    SERVICES,
)
"""Arguments of an action server, for the same."""

DESCRIPTION = _profile(QoSReliabilityPolicy.RELIABLE, QoSDurabilityPolicy.TRANSIENT_LOCAL, 1)
"""Subscriptions to a latched text."""
