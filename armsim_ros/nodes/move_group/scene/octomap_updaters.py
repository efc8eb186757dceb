# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a sensor that builds an octomap."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.qos import qos_profile_sensor_data, QoSProfile
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from armsim_ros.arrays import Mask
from armsim_ros.config.sensors_3d import DepthImageSensor, PointCloudSensor, Sensor
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.measurements import (
    cloud_of_points,
    image_of_kept,
    points_of_cloud,
    points_of_depth,
)
from armsim_ros.nodes.move_group.context import Context

Receive = Callable[[str, Any], None]
_NONE = np.zeros((0, 3), dtype=np.float32)
#: Messages that lockstep may be behind.
_LOCKSTEP_DEPTH = 100


@dataclass(frozen=True, eq=False)
class Parsed:
    """
    A message in arrays.

    :param points: (k, 3) [m] in the sensor's frame.
    :param max_range: farther points are no hits [m].
    :param beyond: (j, 3) [m] where rays end that have hit nothing.
    :param pixels: (k,) places of the points in an image.
    """

    points: NDArray[np.float32]
    max_range: float
    beyond: NDArray[np.float32]
    pixels: NDArray[np.int64] | None = None


class Outputs:
    """What the updaters publish: the middleware allows one type of message on a topic."""

    def __init__(self, context: Context) -> None:
        self._context = context
        #: Topic -> name of its first sensor, and type.
        self._owners: dict[str, tuple[str, Any]] = {}

    def publisher(self, name: str, kind: Any, topic: str, profile: QoSProfile) -> Any:
        """
        Return a publisher; None, with a warning, where another type of message has the topic.

        :param name: of the sensor.
        :param kind: of the messages.
        """
        node = self._context.node
        owner, owned = self._owners.setdefault(node.resolve_topic_name(topic), (name, kind))
        if owned is kind:
            return node.create_publisher(kind, topic, profile)
        self._context.logger.warning(
            f"octomap, sensor '{name}': no {kind.__name__} is published on '{topic}', since "
            f"sensor '{owner}' publishes {owned.__name__} there; change 'filtered_cloud_topic' "
            'of one of the two')
        return None


class Updater:
    """
    The topics of a sensor.

    :param name: of the sensor.
    :param kind: of its messages.
    :param topic: of its messages.
    :param receive: called with the sensor's name and each message that counts.
    :param outputs: give the publisher of the points that are left.
    :param profile: of that publisher.
    """

    def __init__(
        self, context: Context, name: str, sensor: Sensor, kind: Any, topic: str,
        receive: Receive, outputs: Outputs, profile: QoSProfile,
    ) -> None:
        self._context, self._name, self._receive = context, name, receive
        self._period_ns = 1e9 / sensor.max_update_rate if sensor.max_update_rate else 0.0
        self._last_ns: int | None = None
        self.topic = topic
        #: Of the points that are left; '' where they are not published.
        self.filtered_topic = sensor.filtered_cloud_topic
        if self.filtered_topic and sensor.ns:
            self.filtered_topic = f'{sensor.ns}/{self.filtered_topic}'
        self._filtered: Any = None
        if self.filtered_topic:
            self._filtered = outputs.publisher(name, kind, self.filtered_topic, profile)
        # In lockstep a picture counts as published when its reliable subscriptions have it.
        lockstep = context.settings.simulation.deterministic
        context.subscribe(
            kind, topic, self._take, _LOCKSTEP_DEPTH if lockstep else qos_profile_sensor_data)

    def _take(self, message: Any) -> None:
        now = self._context.states.now_ns()
        if self._last_ns is not None and 0 <= now - self._last_ns < self._period_ns:
            return
        self._last_ns = now
        self._receive(self._name, message)

    def parse(self, message: Any) -> Parsed:
        """
        Return a message in arrays.

        :raises ValueError: with the reason why it cannot be used.
        """
        raise NotImplementedError

    def publish_filtered(self, message: Any, parsed: Parsed, kept: Mask) -> None:
        """Publish the points (k,) that are within range and outside of all bodies."""
        if self._filtered is not None and self._filtered.get_subscription_count():
            self._filtered.publish(self._of_kept(message, parsed, kept))

    def _of_kept(self, message: Any, parsed: Parsed, kept: Mask) -> Any:
        raise NotImplementedError


class PointCloudUpdater(Updater):
    """Takes point clouds."""

    def __init__(
        self, context: Context, name: str, sensor: PointCloudSensor, receive: Receive,
        outputs: Outputs,
    ) -> None:
        super().__init__(context, name, sensor, PointCloud2, sensor.point_cloud_topic, receive,
                         outputs, qos_profile_sensor_data)
        self._sensor = sensor

    def parse(self, message: PointCloud2) -> Parsed:
        """Return the points of a cloud."""
        points = points_of_cloud(message, self._sensor.point_subsample)
        return Parsed(points, self._sensor.max_range, _NONE)

    def _of_kept(self, message: PointCloud2, parsed: Parsed, kept: Mask) -> PointCloud2:
        return cloud_of_points(parsed.points[kept], message)


class DepthImageUpdater(Updater):
    """Takes depth images, and the camera_info beside them."""

    def __init__(
        self, context: Context, name: str, sensor: DepthImageSensor, receive: Receive,
        outputs: Outputs,
    ) -> None:
        super().__init__(
            context, name, sensor, Image, sensor.image_topic, receive, outputs, qos.PICTURES)
        self._sensor = sensor
        self._info: CameraInfo | None = None
        context.subscribe(CameraInfo, _info_topic(sensor.image_topic), self._take_info,
                          qos_profile_sensor_data)
        self._filtered_info: Any = None
        if self._filtered is not None:
            self._filtered_info = outputs.publisher(
                name, CameraInfo, _info_topic(self.filtered_topic), qos.PICTURES)

    def _take_info(self, message: CameraInfo) -> None:
        self._info = message

    def parse(self, message: Image) -> Parsed:
        """Return the points of a depth image."""
        if self._info is None:
            raise ValueError('no camera_info has come yet')
        found = points_of_depth(message, self._info, self._sensor)
        return Parsed(found.points, np.inf, found.beyond, found.pixels)

    def publish_filtered(self, message: Image, parsed: Parsed, kept: Mask) -> None:
        """Publish the image of the points that are left, and its camera_info."""
        super().publish_filtered(message, parsed, kept)
        if self._filtered_info is not None:
            info = copy(self._info)
            assert info is not None
            info.header = message.header
            self._filtered_info.publish(info)

    def _of_kept(self, message: Image, parsed: Parsed, kept: Mask) -> Image:
        assert parsed.pixels is not None
        return image_of_kept(message, parsed.pixels, kept)


def _info_topic(topic: str) -> str:
    """Return the topic of the camera_info beside a topic of images."""
    parent, slash, _ = topic.rpartition('/')
    return f'{parent}{slash}camera_info'


def updaters_of(
    context: Context, sensors: Mapping[str, Sensor], receive: Receive
) -> dict[str, Updater]:
    """
    Return the updaters of sensors.

    :param sensors: by name; a topic that two of them would publish with different types is the
        first one's.
    """
    outputs = Outputs(context)
    return {name: PointCloudUpdater(context, name, sensor, receive, outputs)
            if isinstance(sensor, PointCloudSensor)
            else DepthImageUpdater(context, name, sensor, receive, outputs)
            for name, sensor in sensors.items()}
