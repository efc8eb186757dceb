# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Depths and points as REP 118 and PCL have them."""

import numpy as np

from armsim_ros.sim.camera import Camera, measured, Picture, points

CAMERA = Camera('camera', 'body', tuple(np.eye(4).ravel()), '', 4, 2, 2.0, (0.1, 10.0), 1)


def test_what_is_out_of_range_is_infinite():
    """Too far is +inf, too near -inf, the rest as it is."""
    depth = measured(np.array([[0.05, 0.1, 3.0, 11.0, 100.0]], np.float32), CAMERA.range)
    np.testing.assert_array_equal(
        depth, np.array([[-np.inf, 0.1, 3.0, np.inf, np.inf]], np.float32))


def test_points_lie_where_the_pixels_show_them():
    """They project back to their pixels, and have their colours."""
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 256, (2, 4, 3), dtype=np.uint8)
    depth = rng.uniform(0.5, 2.0, (2, 4)).astype(np.float32)
    found = points(Picture(colour, depth), CAMERA)
    u, v = CAMERA.centre
    lines, columns = np.mgrid[:2, :4]
    np.testing.assert_allclose(CAMERA.focal * found[..., 0] / found[..., 2] + u, columns,
                               atol=1e-5)
    np.testing.assert_allclose(CAMERA.focal * found[..., 1] / found[..., 2] + v, lines, atol=1e-5)
    np.testing.assert_array_equal(found[..., 2], depth)
    blue_green_red = found[..., 3].copy().view(np.uint8).reshape(2, 4, 4)[..., :3]
    np.testing.assert_array_equal(blue_green_red[..., ::-1], colour)


def test_where_no_depth_is_there_is_no_point():
    """Infinite depths become NaN."""
    depth = np.array([[np.inf, -np.inf, 1.0, 1.0]] * 2, np.float32)
    found = points(Picture(np.zeros((2, 4, 3), np.uint8), depth), CAMERA)
    assert np.isnan(found[:, :2, :3]).all()
    assert np.isfinite(found[:, 2:, :3]).all()
