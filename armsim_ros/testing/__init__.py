# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Tests of a robot arm: assertions, a pytest plugin, and small clients of a running stack.

Nothing here sleeps: every wait is for a condition or for simulated time, and has a limit.
"""

from armsim_ros.testing.assertions import (
    assert_no_collision,
    assert_no_contact,
    assert_reached,
    assert_rejected,
)

__all__ = ['assert_no_collision', 'assert_no_contact', 'assert_reached', 'assert_rejected']
