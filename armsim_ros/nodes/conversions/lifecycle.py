# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lifecycle states by name to ``lifecycle_msgs/msg/State`` and back."""

from __future__ import annotations

from lifecycle_msgs.msg import State

STATE_IDS = {
    'unknown': State.PRIMARY_STATE_UNKNOWN,
    'unconfigured': State.PRIMARY_STATE_UNCONFIGURED,
    'inactive': State.PRIMARY_STATE_INACTIVE,
    'active': State.PRIMARY_STATE_ACTIVE,
    'finalized': State.PRIMARY_STATE_FINALIZED,
}
_LABELS = {number: label for label, number in STATE_IDS.items()}


def state_message(label: str) -> State:
    """Return the message of a state; an unknown state is ``unknown``."""
    return State(id=STATE_IDS.get(label, State.PRIMARY_STATE_UNKNOWN), label=label)


def state_label(message: State) -> str:
    """Return the name of a state; clients fill in either its label or its number."""
    return message.label or _LABELS.get(message.id, 'unknown')
