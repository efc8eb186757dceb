# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of what a program sees that uses the package as a library."""

from pathlib import Path
import subprocess
import sys

from page_types import examples
import pytest

import armsim_ros

ROOT = Path(__file__).parents[1]


def test_the_examples_run():
    """The examples of the page, one after the other, do what they say."""
    names = {}
    exec(compile(examples(), 'library.md', 'exec'), names)
    sim = names['sim']
    assert names['response'].success
    assert sim.joint_positions == pytest.approx(
        sim.model.semantic.named_states['manipulator']['scan_food'], abs=1e-3)
    assert 'post' not in sim.scene.objects


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
