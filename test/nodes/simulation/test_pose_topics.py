# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Poses that are published as transforms."""

import math

import pytest

from armsim_ros.nodes.simulation.controllers.sensor_topics import is_pose


@pytest.mark.parametrize(
    ('values', 'sent'),
    [
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], True),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.004, 1.0], True),
        ([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0], True),
        ([math.nan, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], False),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0], False),
        ([1.0, 2.0, 3.0, 0.0, 0.0, 0.5, 1.0], False),
    ],
)
def test_an_invalid_pose_is_no_transform(values, sent):
    """The pose is published, the transform is not (pose_broadcaster.cpp, is_pose_valid)."""
    assert is_pose(values) is sent
