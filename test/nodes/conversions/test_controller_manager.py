# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""States of controllers and hardware, to messages and back."""

from lifecycle_msgs.msg import State
import pytest

from armsim_ros.nodes.conversions.controller_manager import state_label


@pytest.mark.parametrize(('number', 'label', 'expected'), [
    (State.PRIMARY_STATE_INACTIVE, 'active', 'inactive'),
    (State.PRIMARY_STATE_ACTIVE, '', 'active'),
    (State.PRIMARY_STATE_UNKNOWN, 'inactive', 'inactive'),
    (State.PRIMARY_STATE_UNKNOWN, '', 'unknown'),
    (State.TRANSITION_STATE_ACTIVATING, 'active', 'unknown'),
])
def test_the_number_of_a_state_counts_before_its_label(
    number: int, label: str, expected: str
) -> None:
    """
    A label counts where the number is 0.

    Upstream: resource_manager.cpp, ResourceManager::set_component_state.
    """
    assert state_label(State(id=number, label=label)) == expected
