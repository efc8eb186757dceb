# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of what a program sees that uses the package as a library."""

from pathlib import Path
import re
import subprocess
import sys

import pytest

import armsim_ros

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope='module')
def program():
    """Return the examples of the page as one program."""
    page = (ROOT / 'docs' / 'library.md').read_text(encoding='utf-8')
    return '\n\n'.join(re.findall(r'```python\n(.*?)```', page, re.DOTALL))


def test_the_examples_run(program):
    """The examples of the page, one after the other, do what they say."""
    names = {}
    exec(compile(program, 'library.md', 'exec'), names)
    sim = names['sim']
    assert names['response'].success
    assert sim.joint_positions == pytest.approx(
        sim.model.semantic.named_states['manipulator']['scan_food'], abs=1e-3)
    assert 'post' not in sim.scene.objects


def test_the_examples_pass_a_type_checker(program, tmp_path):
    """A user's program that is checked strictly finds annotations for all that it uses."""
    pytest.importorskip('mypy')
    path = tmp_path / 'program.py'
    path.write_text(program, encoding='utf-8')
    checked = subprocess.run(
        [sys.executable, '-m', 'mypy', '--strict', '--follow-imports=silent', str(path)],
        cwd=ROOT, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_every_public_name_is_there():
    """What the package offers can be imported, and nothing else can."""
    for name in armsim_ros.__all__:
        assert getattr(armsim_ros, name).__name__ == name
    with pytest.raises(AttributeError, match='ArmSin'):
        armsim_ros.ArmSin  # noqa: B018


def test_nothing_is_imported_before_it_is_needed():
    """A program of one branch does not load the other: the package itself imports nothing."""
    code = 'import sys, armsim_ros; print([name for name in sys.modules if "mujoco" in name])'
    said = subprocess.run(
        [sys.executable, '-c', code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert said.stdout.strip() == '[]'


def test_goals_of_numbers():
    """Joint positions and a pose become constraints with their tolerances."""
    joints = armsim_ros.Constraints.of_joints({'a': 1.0}, tolerance=0.1)
    assert [(each.joint_name, each.position, each.tolerance_above, each.tolerance_below)
            for each in joints.joint_constraints] == [('a', 1.0, 0.1, 0.1)]
    pose = armsim_ros.pose_matrix((1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    posed = armsim_ros.Constraints.of_pose('tip', pose, 'base', position_tolerance=0.02)
    position, = posed.position_constraints
    orientation, = posed.orientation_constraints
    assert (position.link_name, position.frame_id) == ('tip', 'base')
    assert position.regions[0].shape.radius == 0.02
    assert orientation.quat_xyzw == pytest.approx((0.0, 0.0, 0.2474, 0.9689), abs=1e-4)
