# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bodies that are known."""

import pytest
from separation import box_mesh
from small_arms import planar_arm


@pytest.fixture
def make_cube():
    """Return the function that makes a cube of triangles."""
    return lambda edge: box_mesh((edge, edge, edge))


@pytest.fixture
def arm():
    """Return a planar arm."""
    return planar_arm()
