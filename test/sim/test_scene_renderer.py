# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures against the geometry that they show."""

import os
from pathlib import Path
import subprocess
import sys

import draw_balls
import numpy as np
import pytest


@pytest.fixture(scope='module')
def pictures(drawing, tmp_path_factory):
    """Return what a program of its own has drawn."""
    file = tmp_path_factory.mktemp('pictures') / 'balls.npz'
    subprocess.run([sys.executable, draw_balls.__file__, str(file)], check=True, timeout=300,
                   env={**os.environ, 'MUJOCO_GL': drawing,
                        'PYTHONPATH': str(Path(__file__).parents[3])})
    with np.load(file) as content:
        return dict(content)


@pytest.mark.parametrize('number', range(len(draw_balls.SIZES)))
def test_a_point_is_seen_where_it_projects_to(pictures, number):
    """Within a pixel, and its depth within 4 mm."""
    width, height = draw_balls.SIZES[number]
    colour, depth = pictures[f'colour{number}'], pictures[f'depth{number}']
    assert colour.shape == (height, width, 3)
    red = colour[..., 0].astype(int) - colour[..., 1] > 60
    focal = 0.9666 * height
    for x, y, z in pictures['centres']:
        u, v = focal * x / z + (width - 1) / 2, focal * y / z + (height - 1) / 2
        reach = int(focal * draw_balls.RADIUS / z) + 3
        left, top = round(u) - reach, round(v) - reach
        lines, columns = np.nonzero(red[top : top + 2 * reach + 1, left : left + 2 * reach + 1])
        assert abs(columns.mean() + left - u) < 1.0
        assert abs(lines.mean() + top - v) < 1.0
        distance = np.linalg.norm((x, y, z))
        surface = z * (distance - draw_balls.RADIUS) / distance
        assert abs(depth[round(v), round(u)] - surface) < 0.004


@pytest.mark.parametrize('number', range(len(draw_balls.SIZES)))
def test_where_nothing_is_the_depth_is_infinite(pictures, number):
    """All that is not red is nothing."""
    colour, depth = pictures[f'colour{number}'], pictures[f'depth{number}']
    assert (np.isposinf(depth) == (colour.sum(axis=-1) == 0)).all()


@pytest.mark.parametrize('number', range(len(draw_balls.SIZES)))
def test_the_same_state_gives_the_same_picture(pictures, number):
    """It is the same to the bit."""
    assert pictures[f'same{number}']
