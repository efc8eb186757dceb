# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Octomaps as files."""

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest
from small_arms import planar_arm

from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.nodes.move_group.scene.scene_services import MapFiles
from armsim_ros.planning.scene.octomap import octomap_from_cells, write_map_file
from armsim_ros.planning.scene.planning_scene import PlanningScene

MAP = octomap_from_cells(
    np.array([[0, 0, 5]]), np.ones(1, dtype=np.float32), 0.1, np.eye(4))


class MoveGroup:
    """The parts of move_group that the services need; each job is done at once."""

    def __init__(self, folder):
        self.services, self.errors = {}, []
        self.scene = PlanningScene(KinematicModel(planar_arm()))
        self.planning_parameters = PlanningParameters(geometry_folder=str(folder))
        self.logger = SimpleNamespace(error=self.errors.append)
        self.edits = self
        MapFiles(self, self.scene.set_octomap)

    def serve(self, kind, name, fill):
        self.services[name] = kind, fill

    async def submit(self, job):
        return job()

    def call(self, name, filename):
        """Return whether a service succeeds with a file."""
        kind, fill = self.services[name]
        response = kind.Response()
        asyncio.run(fill(kind.Request(filename=str(filename)), response))
        return response.success


@pytest.fixture
def move_group(tmp_path):
    """Return services whose files are in a folder."""
    return MoveGroup(tmp_path / 'scenes')


def test_a_map_is_read_from_any_path(move_group, tmp_path):
    """
    Also outside of the folder where maps are written.

    moveit_ros occupancy_map_monitor.cpp, loadMapCallback.
    """
    file = tmp_path / 'cell.bt'
    file.write_bytes(write_map_file(MAP))
    assert move_group.call('load_map', file)
    np.testing.assert_allclose(move_group.scene.octomap.boxes[0], MAP.boxes[0])


def test_a_map_is_written_in_its_folder_alone(move_group, tmp_path):
    """A path elsewhere is refused; a relative one begins in the folder, for both services."""
    move_group.scene.set_octomap(MAP)
    assert not move_group.call('save_map', tmp_path / 'cell.bt')
    assert 'geometry_folder' in move_group.errors[0]
    assert not (tmp_path / 'cell.bt').exists()
    assert move_group.call('save_map', 'cell.bt')
    move_group.scene.set_octomap(None)
    assert move_group.call('load_map', 'cell.bt')
    assert move_group.scene.octomap is not None


@pytest.mark.parametrize('content', [None, b'no map'])
def test_a_file_that_is_no_map_leaves_the_map(move_group, tmp_path, content):
    """A missing file is refused like one of another kind; the log has the reason."""
    move_group.scene.set_octomap(MAP)
    if content is not None:
        (tmp_path / 'cell.bt').write_bytes(content)
    assert not move_group.call('load_map', tmp_path / 'cell.bt')
    assert move_group.scene.octomap is MAP
    assert move_group.errors
