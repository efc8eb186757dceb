# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Regions of entity filters, as messages hold them."""

from geometry_msgs.msg import Vector3
import numpy as np
import pytest
from simulation_interfaces.msg import Bounds, Result

from armsim_ros.nodes.simulation.world.answers import box, RefusedError
from armsim_ros.nodes.simulation.world.entity_services import region

LOWER, UPPER = Vector3(x=-1.0, y=-1.0, z=-1.0), Vector3(x=1.0, y=1.0, z=1.0)


@pytest.mark.parametrize('points', [[UPPER, LOWER], [LOWER, UPPER]], ids=['upper', 'lower'])
def test_the_corners_of_a_box_may_come_in_any_order(points):
    """The standard has the upper right first, clients send both. Bounds.msg, TYPE_BOX."""
    overlaps = region(Bounds(type=Bounds.TYPE_BOX, points=points))
    assert overlaps(np.full(3, 0.9), np.full(3, 1.1))
    assert not overlaps(np.array([0.0, 0.0, 1.1]), np.array([0.1, 0.1, 1.2]))


def test_the_upper_corner_of_a_box_comes_first():
    """simulation_interfaces Bounds.msg, TYPE_BOX."""
    message = box(np.full(3, -1.0), np.full(3, 1.0))
    assert message == Bounds(type=Bounds.TYPE_BOX, points=[UPPER, LOWER])


def test_a_region_of_another_type_is_an_unsupported_feature():
    """simulation_interfaces EntityFilters.msg, bounds."""
    with pytest.raises(RefusedError, match='TYPE_SPHERE') as caught:
        region(Bounds(type=Bounds.TYPE_CONVEX_HULL, points=[LOWER, UPPER, Vector3()]))
    assert caught.value.code == Result.RESULT_FEATURE_UNSUPPORTED
