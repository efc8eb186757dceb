# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes that are scaled."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np

from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, is_inside, Mesh, scaled, Sphere

TETRAHEDRON = Mesh(0.3 * np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
                   np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
SHAPES = st.sampled_from([Box((0.2, 0.4, 0.6)), Sphere(0.3), Cylinder(0.2, 0.6), Cone(0.3, 0.6),
                          Capsule(0.1, 0.4), TETRAHEDRON])


@settings(max_examples=200, deadline=None)
@given(SHAPES, st.floats(0.1, 10.0), st.tuples(*[st.integers(-35, 35)] * 3))
def test_a_scaled_shape_holds_the_scaled_points(shape, scale, hundredths):
    """A point is inside of a shape where the point scaled with it is inside of the scaled one."""
    # Beside the grid on which the shapes have their faces.
    point = 0.01 * np.array(hundredths) + (0.0031, 0.0017, 0.0023)
    assert is_inside(scaled(shape, scale), scale * point) is is_inside(shape, point)
