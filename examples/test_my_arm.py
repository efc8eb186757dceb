# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An integration test of an arm: ``python -m pytest examples/test_my_arm.py``."""

import pytest

from armsim_ros.testing import assert_no_collision, assert_reached


@pytest.mark.armsim(robot='sunday')
def test_reaches_scan_food(arm):
    """The arm gets from its start to scan_food and touches nothing on its way."""
    arm.move_to('scan_food')
    assert_reached(arm, 'scan_food')
    assert_no_collision(arm)
