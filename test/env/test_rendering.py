# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of an environment."""

import os
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[2]

PROGRAM = """
import sys
from armsim_ros import ArmsimError
from armsim_ros.env import ArmEnv

env = ArmEnv(render_mode='rgb_array', view={
    'width': 160, 'height': 120, 'lookat': (0.16, 0.25, 1.04), 'distance': 0.4,
    'azimuth': 90, 'elevation': -60})
try:
    for color in ((1, 0, 0), (0, 1, 0)):
        env.reset(seed=0, options={'objects': {'cube': {'color': color}}})
        picture = env.render().astype(int)
        assert picture.shape == (120, 160, 3)
        red, green, blue = picture.reshape(-1, 3).T
        print(int(((red > 80) & (red > 2 * green) & (red > 2 * blue)).sum()),
              int(((green > 80) & (green > 2 * red) & (green > 2 * blue)).sum()))
    env.close()
except ArmsimError as error:
    sys.exit(str(error))
"""


def drawn(way):
    """Return the program's end, drawing in one of MuJoCo's ways."""
    environment = {**os.environ, 'PYTHONPATH': str(ROOT), 'MUJOCO_GL': way}
    environment.pop('DISPLAY', None)
    return subprocess.run([sys.executable, '-W', 'ignore', '-c', PROGRAM], check=False,
                          env=environment, capture_output=True, text=True)


def test_a_picture_shows_the_objects_in_their_colours():
    """The cube is red in one episode and green in the next."""
    child = drawn('egl')
    if 'pictures need OpenGL' in child.stderr:
        pytest.skip(child.stderr)
    assert child.returncode == 0, child.stderr
    first, second = (list(map(int, line.split())) for line in child.stdout.splitlines())
    assert first[0] > 100 > first[1]
    assert second[1] > 100 > second[0]


def test_without_opengl_the_packages_are_named():
    """A machine that cannot draw gets one sentence that says what to install."""
    child = drawn('glfw')
    assert child.returncode == 1
    assert 'install libegl1' in child.stderr
    assert 'Traceback' not in child.stderr


def test_no_picture_is_made_where_none_is_wanted(new_env):
    """Without a render mode there is none."""
    env = new_env()
    env.reset(seed=0)
    assert env.render() is None
