# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What may touch what, and from how near: the allowed collision matrix, padding."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from move_group_bench import xyz
from moveit_msgs.msg import AllowedCollisionEntry, LinkPadding, PlanningSceneComponents
import pytest
from shape_msgs.msg import Plane
from wire import at, box, quiet_diff, thing

Part = PlanningSceneComponents


def blocked(arm: Any) -> bool:
    """Return whether the present state collides."""
    return not arm.validity(arm.positions(), '').valid


def around_the_tip(arm: Any) -> Any:
    """Return a box that the tip is in."""
    pose = arm.pose()
    return thing('wrap', pose.header.frame_id, [box(0.02, 0.02, 0.02)], pose=pose.pose)


@pytest.mark.statement('SCN-13', 'PM-8')
def test_allowing_a_pair(arm: Any) -> None:
    """The matrix of a diff replaces the old one; what it allows is not checked."""
    arm.add(around_the_tip(arm))
    assert blocked(arm)
    assert arm.allow('wrap', arm.links)
    assert not blocked(arm)


@pytest.mark.statement('SCN-13')
def test_defaults_alone_are_ignored_in_a_diff(arm: Any) -> None:
    """A diff whose matrix has only defaults leaves the matrix as it is."""
    before = arm.scene().allowed_collision_matrix
    scene = quiet_diff()
    scene.allowed_collision_matrix.default_entry_names = [arm.tip]
    scene.allowed_collision_matrix.default_entry_values = [True]
    arm.apply(scene)
    assert arm.scene().allowed_collision_matrix == before


def test_a_matrix_without_the_links_warns_of_their_pairs(arm: Any, log: Any) -> None:
    """
    It replaces the whole matrix, and pairs that the SRDF allows are checked again.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    before, seen = arm.scene().allowed_collision_matrix, len(log.output)
    scene = quiet_diff()
    scene.allowed_collision_matrix.entry_names = ['gripper', 'box']
    scene.allowed_collision_matrix.entry_values = [
        AllowedCollisionEntry(enabled=[False, True]), AllowedCollisionEntry(enabled=[True, False])]
    assert arm.apply(scene)
    log.wait_for_line('the allowed collision matrix replaces the whole matrix', after=seen)
    scene.allowed_collision_matrix = before
    assert arm.apply(scene)
    assert arm.scene().allowed_collision_matrix == before


@pytest.mark.statement('SCN-13a')
def test_a_matrix_that_is_not_square_is_refused(arm: Any) -> None:
    """The rules stay as they were, and apply answers false."""
    before = arm.scene().allowed_collision_matrix
    scene = quiet_diff()
    scene.allowed_collision_matrix.entry_names = ['a', 'b']
    scene.allowed_collision_matrix.entry_values = [AllowedCollisionEntry(enabled=[True])]
    assert not arm.apply(scene)
    assert arm.scene().allowed_collision_matrix == before


@pytest.mark.statement('SCN-12', 'CFG-1')
def test_the_first_matrix_comes_from_the_srdf(arm: Any) -> None:
    """disable_collisions of the SRDF are allowed, and other pairs are not."""
    text = arm.parameters.get('robot_description_semantic')
    srdf = ElementTree.fromstring(text)
    pairs = [
        (one.get('link1'), one.get('link2')) for one in srdf.findall('disable_collisions')
    ]
    matrix = arm.scene().allowed_collision_matrix
    place = {name: k for k, name in enumerate(matrix.entry_names)}
    allowed = {
        frozenset((a, b)) for a in place for b in place
        if a != b and matrix.entry_values[place[a]].enabled[place[b]]
    }
    assert allowed == {frozenset(pair) for pair in pairs if set(pair) <= set(place)}


@pytest.mark.statement('SCN-14')
def test_padding_counts_against_the_world(arm: Any) -> None:
    """A padded link keeps away from objects; paddings come back."""
    pose = arm.pose()
    tip = xyz(pose.pose.position)
    far = at(tip[0] + 0.25, tip[1], tip[2])
    arm.add(thing('wall', arm.frame, [box(0.02, 0.02, 0.02)], pose=far))
    assert not blocked(arm)
    scene = quiet_diff()
    scene.link_padding = [LinkPadding(link_name=arm.tip, padding=0.4)]
    assert arm.apply(scene)
    assert blocked(arm)
    paddings = {one.link_name: one.padding for one in arm.scene().link_padding}
    assert paddings[arm.tip] == pytest.approx(0.4)


@pytest.mark.statement('M12')
def test_a_plane_is_infinitely_thin(arm: Any) -> None:
    """A plane collides with what crosses it, and with nothing on either side."""
    tip = arm.pose().pose.position.z
    for height, crosses in ((tip, True), (50.0, False), (-50.0, False)):
        sheet = thing('sheet', arm.frame)
        sheet.planes, sheet.plane_poses = [Plane(coef=[0.0, 0.0, 1.0, -height])], [at()]
        assert arm.add(sheet)
        assert blocked(arm) == crosses, height
