# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Definitions of messages as recordings carry them."""

import pytest

from armsim_ros.errors import ResourceError
from armsim_ros.recording.message_definitions import message_definition


def test_a_definition_has_those_of_all_types_in_it():
    """Nested types follow the first one, each once, under its name."""
    text = message_definition('tf2_msgs/msg/TFMessage')
    first, *rest = text.split('=' * 80)
    assert first.strip() == 'geometry_msgs/TransformStamped[] transforms'
    names = [part.strip().splitlines()[0] for part in rest]
    assert names == ['MSG: geometry_msgs/TransformStamped', 'MSG: std_msgs/Header',
                     'MSG: builtin_interfaces/Time', 'MSG: geometry_msgs/Transform',
                     'MSG: geometry_msgs/Vector3', 'MSG: geometry_msgs/Quaternion']


def test_constants_and_defaults_stay():
    """Constants of a type are part of its definition, comments are not."""
    text = message_definition('rcl_interfaces/msg/Log')
    assert 'ERROR=40' in text.replace(' ', '')
    assert '#' not in text


def test_a_type_that_is_not_installed_is_named():
    """A package that is not there is named."""
    with pytest.raises(ResourceError, match='no_such_msgs'):
        message_definition('no_such_msgs/msg/Thing')
