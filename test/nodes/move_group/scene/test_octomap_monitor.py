# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which messages of sensors are added to the map, when, and what is said of the others."""

from types import SimpleNamespace

import numpy as np
from octomap_bench import Bench, Node
import pytest

from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.config.sensors_3d import OctomapSettings, PointCloudSensor
from armsim_ros.config.simulation import CameraSettings, SimulationSettings
from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.move_group.scene.octomap_monitor import octomap_settings
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.octomap import octomap_from_cells
from armsim_ros.planning.scene.octree_data import HIGHEST, LOWEST


@pytest.fixture
def bench(monkeypatch):
    """Return a monitor with a sensor of clouds."""
    return Bench(monkeypatch)


FAR = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0]]


def test_cloud_waits_for_the_state_of_its_time(bench):
    """Then its points are in the map; a timer runs only meanwhile."""
    bench.state(1.0)
    assert not bench.node.waits
    bench.send(FAR, 1.5)
    assert bench.node.waits
    bench.node.retry()
    assert bench.cells == 0
    bench.state(2.0)
    bench.node.retry()
    assert not bench.node.waits
    bench.work()
    assert bench.cells == 2


def test_only_the_newest_of_a_sensor_is_added(bench):
    """What comes while the map is busy replaces what waits."""
    bench.state(9.0)
    for k in range(5):
        bench.send([[0.0, 0.0, 5.0 + k]], 1.0 + k if k == 0 else 9.0)
    bench.state(9.0)
    bench.work()
    assert bench.cells == 1
    assert np.allclose(bench.scene.octomap.boxes[0][:, 2], 9.025)


def test_in_lockstep_all_are_added_and_waited_for(monkeypatch):
    """A step is answered when those that came before are in the scene."""
    bench = Bench(monkeypatch, lockstep=True)
    bench.state(2.0)
    for k in range(7):
        bench.send([[0.0, 0.0, 5.0 + k]], 2.0 + (k == 6))
    response = SimpleNamespace(success=False)
    waits = bench.sync(None, response)
    waits.send(None)
    bench.work()
    waits.send(None)
    assert bench.cells == 6
    bench.state(3.0)
    bench.node.retry()
    bench.work()
    with pytest.raises(StopIteration):
        waits.send(None)
    assert response.success
    assert bench.cells == 7


def test_in_lockstep_nothing_is_waited_for_at_the_end(monkeypatch):
    """A message whose transform never comes does not keep the program."""
    bench = Bench(monkeypatch, lockstep=True)
    bench.state(2.0)
    bench.send(FAR, 3.0)
    waits = bench.sync(None, SimpleNamespace(success=False))
    waits.send(None)
    bench.ends = True
    with pytest.raises(PlanningError, match='ends'):
        waits.send(None)


def test_what_came_before_a_clear_is_not_brought_back(bench):
    """clear_octomap holds for what is under way, too."""
    bench.state(1.0)
    bench.send(FAR, 1.0)
    bench.monitor.forget()
    bench.work()
    assert bench.scene.octomap is None
    bench.send(FAR, 1.0)
    bench.work()
    assert bench.cells == 2
    bench.scene.set_octomap(None)
    bench.send([[0.0, 0.0, 7.0]], 1.0)
    bench.work()
    assert bench.cells == 1


@pytest.mark.parametrize(('parts', 'text'), [
    ({'frame': 'nowhere'}, "frame 'nowhere'"),
    ({'fields': []}, 'no field x, y, z'),
    ({'width': 99}, 'need 1188'),
    ({'seconds': 0.1}, 'older than the oldest robot state'),
])
def test_bad_clouds_are_one_warning_in_ten_seconds(bench, parts, text):
    """The map stays as it was."""
    bench.state(1.0)
    bench.send(FAR, 1.0)
    bench.work()
    for _ in range(3):
        bench.send(FAR, **{'seconds': 1.0, **parts})
        bench.work()
        bench.now += 3.0
        bench.node.retry()
    bench.now += 3.0
    bench.node.retry()
    warnings = [line for line in bench.lines if 'dropped' in line]
    assert len(warnings) == 1
    assert text in warnings[0]
    assert bench.cells == 2
    assert not bench.node.waits


def test_a_map_of_a_client_is_replaced_by_the_next_cloud(bench):
    """Sensors know better; until then the client's map counts."""
    bench.state(1.0)
    bench.send(FAR, 1.0)
    bench.work()
    bench.scene.set_octomap(octomap_from_cells(
        np.array([[0, 0, 9]]), np.ones(1, dtype=np.float32), 0.1, np.eye(4)))
    assert bench.cells == 1
    bench.send(FAR, 1.0)
    bench.work()
    assert bench.cells == 2
    assert bench.scene.octomap.resolution == 0.05


def test_more_than_five_do_not_wait(bench):
    """The oldest is dropped."""
    bench.state(1.0)
    for k in range(7):
        bench.send(FAR, 2.0 + 0.1 * k)
    assert 'too many wait' in bench.lines[-1]
    bench.state(3.0)
    bench.node.retry()
    bench.work()
    assert bench.cells == 2


def test_time_that_jumps_back_starts_anew(bench):
    """After a reset of the simulation clouds of the new time are taken."""
    bench.state(100.0)
    bench.send(FAR, 100.0)
    bench.work()
    bench.state(1.0)
    bench.send([[0.0, 1.0, 6.0]], 1.0)
    bench.work()
    assert bench.cells == 3


def test_the_map_of_a_camera_on_the_arm_stays_where_it_was_seen(bench):
    """
    The map is in the model frame, whatever the frames of the clouds.

    moveit_ros planning_scene_monitor.cpp, startWorldGeometryMonitor and octomapUpdateCallback.
    """
    places = []
    for seconds, angle in ((1.0, 0.0), (2.0, np.pi / 2)):
        bench.scene.set_positions({'axis1': angle})
        bench.state(seconds)
        bench.send([[0.0, 0.0, 5.0 + seconds]], seconds, frame='tool')
        bench.work()
        places.append((bench.scene.frame_pose('tool') @ (0.0, 0.0, 5.0 + seconds, 1.0))[:3])
    octomap = bench.scene.octomap
    assert np.allclose(octomap.pose, np.eye(4))
    centres, _ = octomap.boxes
    for place in places:
        assert np.abs(centres - place).max(axis=1).min() <= 0.5 * octomap.resolution + 1e-9


LOADED = octomap_from_cells(
    np.array([[0, 0, 9], [0, 0, 10]]), np.array([HIGHEST, LOWEST], dtype=np.float32), 0.1,
    np.eye(4))


def test_clouds_are_added_to_a_loaded_map(bench):
    """
    A loaded map takes the place of what was seen before, and has its own resolution.

    moveit_ros occupancy_map_monitor.cpp, loadMapCallback.
    """
    bench.state(1.0)
    bench.send(FAR, 1.0)
    bench.work()
    bench.monitor.load(LOADED)
    assert bench.scene.octomap is LOADED
    bench.send([[1.0, 0.0, 7.0]], 1.0)
    bench.work()
    assert bench.scene.octomap.resolution == 0.1
    np.testing.assert_allclose(
        sorted(bench.scene.octomap.boxes[0].tolist()), [(0.05, 0.05, 0.95), (1.05, 0.05, 7.05)])


def test_an_object_frees_the_cells_of_a_loaded_map(bench):
    """They are as good as cells that a sensor has seen."""
    bench.monitor.load(LOADED)
    bench.scene.apply_object(CollisionObject(
        'box', pose=pose_matrix((0.05, 0.05, 0.95)), shapes=(ObjectShape(Box((0.3, 0.3, 0.3))),)))
    assert bench.cells == 0


def test_a_map_is_loaded_without_sensors(monkeypatch):
    """It is the scene's; an empty one leaves none."""
    bench = Bench(monkeypatch, settings=OctomapSettings())
    bench.monitor.load(LOADED)
    assert bench.scene.octomap is LOADED
    none = np.zeros((0, 3), dtype=np.int64)
    bench.monitor.load(octomap_from_cells(none, np.zeros(0, dtype=np.float32), 0.1, np.eye(4)))
    assert bench.scene.octomap is None


def settings(parameters=None, *, given=None, cameras=None, octomap=False):
    """Return the settings of parameters, a file and cameras, and what is logged."""
    node, lines = Node(), []
    node.parameters = parameters or {}
    context = SimpleNamespace(
        node=node, frame='world', logger=SimpleNamespace(warning=lines.append),
        planning_parameters=PlanningParameters(octomap=octomap),
        settings=SimpleNamespace(
            octomap=given or OctomapSettings(),
            simulation=SimulationSettings(cameras=cameras or {})))
    return octomap_settings(context), lines


def test_parameters_of_a_launch_file_win_over_the_file():
    """They are flat, as MoveItConfigsBuilder returns them."""
    of_file = OctomapSettings(sensors={'a': PointCloudSensor(point_cloud_topic='/a')})
    assert settings(given=of_file)[0] is of_file
    found, lines = settings({
        'sensors': ['kinect', 'other'], 'octomap_resolution': 0.02, 'octomap_frame': 'odom',
        'kinect.sensor_plugin': 'occupancy_map_monitor/PointCloudOctomapUpdater',
        'kinect.point_cloud_topic': '/k/points', 'kinect.max_range': 5,
        'other.sensor_plugin': 'x/Y'}, given=of_file)
    assert list(found.sensors) == ['kinect']
    assert found.sensors['kinect'].max_range == 5.0
    assert found.octomap_resolution == 0.02
    line, = lines
    assert "plugin 'x/Y' is not known" in line
    assert 'PointCloudOctomapUpdater, occupancy_map_monitor/DepthImageOctomapUpdater' in line
    assert not settings({'sensors': ['']}, given=of_file)[0].sensors


def test_cameras_of_the_simulation_are_sensors():
    """octomap:=true has a cloud of each."""
    found, _ = settings(cameras={'wrist': CameraSettings(link='tool')}, octomap=True)
    assert found.sensors['wrist'].point_cloud_topic == '/wrist/depth/points'
    assert found.octomap_resolution == 0.025
    found, lines = settings(octomap=True)
    assert not found.sensors
    assert 'has no camera' in lines[0]
