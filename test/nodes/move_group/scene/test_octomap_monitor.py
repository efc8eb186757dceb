# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which messages of sensors are added to the map, when, and what is said of the others."""

from array import array
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data, QoSReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from small_arms import planar_arm

from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.config.sensors_3d import DepthImageSensor, OctomapSettings, PointCloudSensor
from armsim_ros.config.simulation import CameraSettings, SimulationSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.move_group.scene import octomap_monitor
from armsim_ros.nodes.move_group.scene.octomap_monitor import octomap_settings, OctomapMonitor
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.octomap import octomap_from_cells
from armsim_ros.planning.scene.octree_data import HIGHEST, LOWEST
from armsim_ros.planning.scene.planning_scene import PlanningScene

SECOND = 1_000_000_000


class Works:
    """A worker whose jobs a test lets run."""

    def __init__(self, name, executor):
        self.jobs = []
        Works.last = self

    def submit(self, job):
        self.jobs.append(job)

    def run(self):
        while self.jobs:
            self.jobs.pop(0)()

    def close(self):
        pass


class Node:
    """Has topics and a timer."""

    def __init__(self):
        self.executor = object()
        self.advertised, self.published, self.listeners = {}, [], 0
        self.parameters = {}

    def create_timer(self, period, call, clock):
        self.retry = call
        self.waits = True
        return SimpleNamespace(
            cancel=lambda: setattr(self, 'waits', False),
            reset=lambda: setattr(self, 'waits', True), is_canceled=lambda: not self.waits)

    def create_publisher(self, kind, topic, profile):
        self.advertised[topic] = profile
        return SimpleNamespace(publish=self.published.append,
                               get_subscription_count=lambda: self.listeners)

    def has_parameter(self, name):
        return name in self.parameters

    def get_parameters_by_prefix(self, prefix):
        return {name: Parameter(name, value=value) for name, value in self.parameters.items()}


class Bench:
    """A monitor with a sensor, and the parts of move_group that it needs."""

    def __init__(self, monkeypatch, sensor=None, *, lockstep=False, sensorless=False):
        monkeypatch.setattr(octomap_monitor, 'Worker', Works)
        self.node, self.now, self.lines, self.topics = Node(), 0.0, [], {}
        self.ends = False
        self.scene = PlanningScene(KinematicModel(planar_arm()))
        logger = SimpleNamespace(info=self.lines.append, warning=self.lines.append)
        self.states = SimpleNamespace(recorders=[], now_ns=lambda: round(self.now * SECOND))
        self.context = SimpleNamespace(
            node=self.node, scene=self.scene, states=self.states, logger=logger,
            clock=lambda: self.now, frame=self.scene.model_frame,
            settings=SimpleNamespace(simulation=SimpleNamespace(deterministic=lockstep)),
            serve=lambda kind, name, answer: setattr(self, 'sync', answer),
            ticker=SimpleNamespace(next=_Tick), check_ending=self._check_ending,
            subscribe=lambda kind, topic, take, profile: self.topics.update({topic: take}))
        sensor = sensor or PointCloudSensor(point_cloud_topic='/cloud')
        self.monitor = OctomapMonitor(self.context, OctomapSettings(
            sensors={} if sensorless else {'eye': sensor}, octomap_resolution=0.05))
        self.frame = self.scene.model_frame

    def _check_ending(self, source):
        if self.ends:
            raise PlanningError(MoveItErrorCode.FAILURE, 'the program ends', source)

    def state(self, seconds):
        for record in self.states.recorders:
            record(round(seconds * SECOND), self.scene.kinematic_model.positions(self.scene.q))

    def send(self, points, seconds, frame=None, **parts):
        data = np.asarray(points, dtype='<f4').reshape(-1, 3)
        message = PointCloud2(
            height=1, width=len(data), point_step=12, row_step=12 * len(data),
            fields=[PointField(name=name, offset=4 * k, datatype=7, count=1)
                    for k, name in enumerate('xyz')], data=array('B', data.tobytes()))
        message.header.frame_id = frame or self.frame
        message.header.stamp.sec = int(seconds)
        message.header.stamp.nanosec = round(seconds % 1 * SECOND)
        for name, value in parts.items():
            setattr(message, name, value)
        self.topics['/cloud'](message)

    def work(self):
        Works.last.run()

    @property
    def cells(self):
        octomap = self.scene.octomap
        return 0 if octomap is None else len(octomap.boxes[0])


class _Tick:
    """A wait of a coroutine."""

    def __await__(self):
        yield


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


def test_rate_and_filtered_cloud(monkeypatch):
    """Clouds that come too soon are not read; what is left of the others is published."""
    bench = Bench(monkeypatch, PointCloudSensor(
        point_cloud_topic='/cloud', max_update_rate=2.0, max_range=6.0,
        filtered_cloud_topic='left', ns='eye'))
    bench.state(1.0)
    bench.node.listeners = 1
    for _ in range(4):
        bench.send([*FAR, [0.0, 0.0, 8.0]], 1.0)
        bench.work()
        bench.now += 0.3
    assert bench.node.advertised == {'eye/left': qos_profile_sensor_data}
    assert [message.width for message in bench.node.published] == [2, 2]


def test_a_filtered_image_has_its_camera_info_beside_it(monkeypatch):
    """
    Both are reliable and have the stamp of the image that was measured.

    moveit_ros depth_image_octomap_updater.cpp, start and depthImageCallback.
    """
    bench = Bench(monkeypatch, DepthImageSensor(
        image_topic='/eye/depth', filtered_cloud_topic='left/image', ns='eye'))
    bench.node.listeners = 1
    bench.state(1.0)
    info = CameraInfo(width=32, height=24, k=[30.0, 0.0, 16.0, 0.0, 30.0, 12.0, 0.0, 0.0, 1.0])
    bench.topics['/eye/camera_info'](info)
    image = Image(width=32, height=24, encoding='32FC1', step=128,
                  data=array('B', np.full(32 * 24, 2.0, dtype=np.float32).tobytes()))
    image.header.frame_id, image.header.stamp.sec = bench.frame, 1
    bench.topics['/eye/depth'](image)
    bench.work()
    assert {topic: profile.reliability for topic, profile in bench.node.advertised.items()} == {
        'eye/left/image': QoSReliabilityPolicy.RELIABLE,
        'eye/left/camera_info': QoSReliabilityPolicy.RELIABLE}
    filtered, beside = bench.node.published
    assert filtered.header == beside.header == image.header
    assert list(beside.k) == list(info.k)


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
    bench = Bench(monkeypatch, sensorless=True)
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
