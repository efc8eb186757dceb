# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds as text files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cone, Cylinder, Mesh, Plane, Sphere
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.scene_sources.scene_file import read_scene_file, write_scene_file


@pytest.fixture(scope='module')
def model() -> KinematicModel:
    """Give a robot to make scenes of."""
    return KinematicModel(load_robot_model(load_robot_settings('sunday')))


def test_what_is_written_is_read(model: KinematicModel, tmp_path: Path) -> None:
    """SRV-71: every kind of shape, poses and subframes come back."""
    scene = PlanningScene(model, name='kitchen')
    pose = pose_matrix((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    solids = (
        Box((0.1, 0.2, 0.3)), Sphere(0.1), Cylinder(0.1, 0.2), Cone(0.1, 0.2),
        Mesh(np.eye(3), np.array([[0, 1, 2]])), Plane(0.0, 0.0, 1.0, 0.5))
    scene.apply_object(CollisionObject(
        'all of them', frame_id='world', pose=pose,
        shapes=tuple(ObjectShape(solid, pose) for solid in solids), subframes={'grip here': pose}))
    path = tmp_path / 'kitchen.scene'
    write_scene_file(str(path), scene)
    again = PlanningScene(model)
    again.load(read_scene_file(str(path)))
    before, after = scene.objects['all of them'], again.objects['all of them']
    assert after.pose == pytest.approx(before.pose)
    assert [type(one.geometry) for one in after.shapes] == [
        type(one.geometry) for one in before.shapes
    ]
    for one, other in zip(after.shapes, before.shapes, strict=True):
        assert one.pose == pytest.approx(other.pose)
    assert after.subframes['grip here'] == pytest.approx(before.subframes['grip here'])


OBJECT = """* {}
0 0 0
0 0 0 1
1
box
0.1 0.1 0.1
0.5 0 0.2
0 0 0 1
0 0 0 0
1
tip
0 0 0.1
0 0 0 1
"""


def scene_file(path: Path, *names: str) -> str:
    """Write a file with objects of these names; return its path."""
    path.write_text(''.join(['tools\n', *map(OBJECT.format, names), '.\n']), encoding='utf-8')
    return str(path)


def test_an_object_keeps_the_pose_of_the_file(model: KinematicModel, tmp_path: Path) -> None:
    """
    Also with a single shape beside its origin, as planning_scene.cpp, loadGeometryFromStream.

    The pose of a shape becomes that of its object in messages alone.
    """
    scene = PlanningScene(model)
    scene.load(read_scene_file(scene_file(tmp_path / 'tools.scene', 'tool')))
    assert scene.frame_pose('tool') == pytest.approx(np.eye(4))
    assert scene.frame_pose('tool/tip') == pytest.approx(pose_matrix((0.0, 0.0, 0.1)))
    (shape,) = scene.objects['tool'].shapes
    assert shape.pose == pytest.approx(pose_matrix((0.5, 0.0, 0.2)))


def test_a_file_that_the_scene_refuses_adds_nothing(model: KinematicModel, tmp_path: Path) -> None:
    """All objects are added, or none and no name."""
    path = scene_file(tmp_path / 'map.scene', 'tool', '<octomap>')
    scene = PlanningScene(model, name='before')
    before = scene.content
    with pytest.raises(PlanningError, match='octomap'):
        scene.load(read_scene_file(path))
    assert scene.content is before


@pytest.mark.parametrize(('text', 'line'), [
    ('name\ncrate\n', 2), ('name\n* a\n0 0 0\n0 0 0 1\n1\nblob\n', 6),
    ('name\n* a\n0 0 0\n0 0 0 1\n1\nsphere\n-1\n', 7), ('name\n', 1),
    ('name\n* a\n0 0 0\n0 0 0 1\n0\n0\n.\n', 5),
])
def test_mistakes_are_told_with_their_line(tmp_path: Path, text: str, line: int) -> None:
    """A file of another form is refused with file, line and what must stand there."""
    path = tmp_path / 'bad.scene'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(PlanningError, match=rf'bad\.scene:{line}: .*(there must be|allowed)'):
        read_scene_file(str(path))
