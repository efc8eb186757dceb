# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint states that are refilled in place."""

import numpy as np
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from armsim_ros.nodes.conversions.trajectory import DynamicJointStateBuffer, serialized_joint_state


def test_a_serialized_message_has_the_new_values() -> None:
    """Positions, velocities and efforts are written in this order; all else stays."""
    buffer = serialized_joint_state(('a', 'b'), 'base_link')
    for time_ns, numbers in ((1, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
                             (2_000_000_003, [5.0, 6.0, 0.0, -1.0, 7.0, 8.0])):
        buffer.set_numbers(np.array(numbers))
        message = deserialize_message(buffer.at(time_ns), JointState)
        assert list(message.name) == ['a', 'b']
        assert message.header.frame_id == 'base_link'
        assert message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec == time_ns
        assert [*message.position, *message.velocity, *message.effort] == numbers


def test_dynamic_states_keep_each_joints_own_interfaces() -> None:
    """Joints may have different interfaces."""
    buffer = DynamicJointStateBuffer({'a': ('position', 'velocity'), 'b': ('position',)})
    message = buffer.fill(1, [[1.0, 2.0], [3.0]])
    assert list(message.joint_names) == ['a', 'b']
    assert list(message.interface_values[0].interface_names) == ['position', 'velocity']
    assert list(message.interface_values[0].values) == [1.0, 2.0]
    assert list(message.interface_values[1].values) == [3.0]
