# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A monitor of sensors that build an octomap, with the parts of move_group that it needs."""

from array import array
from types import SimpleNamespace

import numpy as np
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2, PointField
from small_arms import planar_arm

from armsim_ros.config.sensors_3d import OctomapSettings, PointCloudSensor
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.nodes.move_group.scene import octomap_monitor
from armsim_ros.nodes.move_group.scene.octomap_monitor import OctomapMonitor
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

    def resolve_topic_name(self, topic):
        return f"/{topic.lstrip('/')}"

    def has_parameter(self, name):
        return name in self.parameters

    def get_parameters_by_prefix(self, prefix):
        return {name: Parameter(name, value=value) for name, value in self.parameters.items()}


class Bench:
    """A monitor with a sensor, and the parts of move_group that it needs."""

    def __init__(self, monkeypatch, sensor=None, *, lockstep=False, settings=None):
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
        self.monitor = OctomapMonitor(self.context, settings or OctomapSettings(
            sensors={'eye': sensor}, octomap_resolution=0.05))
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
