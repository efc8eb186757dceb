# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint states that are refilled in place."""

import numpy as np

from armsim_ros.nodes.conversions.joint_state import DynamicJointStateBuffer, JointStateBuffer


def test_a_refilled_message_has_the_new_values() -> None:
    """The same message carries each new state; a missing interface stays NaN."""
    buffer = JointStateBuffer(('a', 'b'), 'base_link')
    first = buffer.fill(1, np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.full(2, np.nan))
    assert all(np.isnan(first.effort))
    assert list(first.position) == [1.0, 2.0]
    again = buffer.fill(2_000_000_003, np.array([5.0, 6.0]), np.zeros(2), np.zeros(2))
    assert again is first
    assert list(again.name) == ['a', 'b']
    assert again.header.frame_id == 'base_link'
    assert (again.header.stamp.sec, again.header.stamp.nanosec) == (2, 3)
    assert list(again.position) == [5.0, 6.0]
    assert list(again.velocity) == [0.0, 0.0]


def test_dynamic_states_keep_each_joints_own_interfaces() -> None:
    """Joints may have different interfaces."""
    buffer = DynamicJointStateBuffer({'a': ('position', 'velocity'), 'b': ('position',)})
    message = buffer.fill(1, [[1.0, 2.0], [3.0]])
    assert list(message.joint_names) == ['a', 'b']
    assert list(message.interface_values[0].interface_names) == ['position', 'velocity']
    assert list(message.interface_values[0].values) == [1.0, 2.0]
    assert list(message.interface_values[1].values) == [3.0]
