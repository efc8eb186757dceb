# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The referee of the planning benchmark finds what the planner under test must not touch."""

import itertools
from types import SimpleNamespace

import pytest

from benchmarks.planning.referee import Referee

EDGE = 0.1
URDF = f"""<robot name="probe">
  <link name="base"/><link name="x"/><link name="y"/>
  <link name="z"><collision><geometry>
    <box size="{EDGE} {EDGE} {EDGE}"/></geometry></collision></link>
  {''.join(f'''<joint name="move_{child}" type="prismatic">
    <parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>''' for parent, child, axis in
    (('base', 'x', '1 0 0'), ('x', 'y', '0 1 0'), ('y', 'z', '0 0 1')))}
</robot>"""


@pytest.fixture(scope='module')
def referee(tmp_path_factory):
    """Return the referee of a box that moves along three axes."""
    folder = tmp_path_factory.mktemp('referee')
    (folder / 'probe.urdf').write_text(URDF)
    (folder / 'probe.srdf').write_text('<robot name="probe"/>')
    return Referee(folder / 'probe.urdf', folder / 'probe.srdf',
                   ['move_x', 'move_y', 'move_z'], velocity=1.0, acceleration=1.0)


def test_the_referee_finds_boxes_that_overlap_on_a_grid(referee):
    """Equal boxes parallel to each other touch wherever they are less than an edge apart."""
    box = {'type': 'box', 'size': (EDGE,) * 3, 'id': 'box', 'position': (0.0, 0.0, 0.0),
           'quat_xyzw': (0.0, 0.0, 0.0, 1.0)}
    for steps in itertools.product(range(-8, 13, 2), range(-8, 13, 2), (-2, 0, 2)):
        at = [0.01 * step for step in steps]
        problem = SimpleNamespace(start=at, goal=at, obstacles=[box])
        touches = all(abs(step) < 10 for step in steps)
        if touches or any(abs(step) > 10 for step in steps):
            assert referee.path(problem, [at, at]).clean != touches, at
