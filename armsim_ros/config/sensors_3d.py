# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The sensors that build an octomap (``sensors_3d.yaml``)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from armsim_ros.config.base import parameter, read_settings, Settings
from armsim_ros.config.yaml_node import is_ros2_file, parameters_of_node, YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Location, nearest, Problem, Severity

FILE = 'sensors_3d.yaml'
CLOUDS = 'occupancy_map_monitor/PointCloudOctomapUpdater'
DEPTH_IMAGES = 'occupancy_map_monitor/DepthImageOctomapUpdater'
#: Keys that upstream reads of a depth sensor only where all others are given.
_AFTER_ALL_OTHERS = ('filtered_cloud_topic', 'ns')
#: Edge of a cell where no file gives it [m], as upstream.
USUAL_RESOLUTION = 0.1
#: Noise of a depth image by the square of the depth [m/m^2]: an eighth of a pixel of disparity
#: at a focal length of 525 pixels and a base line of 75 mm, upstream's model of every camera.
DEPTH_NOISE = 0.125 / (525.0 * 0.075)
#: With the cameras of simulation.yaml and no file.
CAMERA_RESOLUTION = 0.025


class PointCloudSensor(Settings):
    """A sensor whose point clouds are added to the map."""

    sensor_plugin: str = parameter(CLOUDS, 'the kind of updater')
    point_cloud_topic: str = parameter(description='topic of the clouds', min_length=1)
    max_range: float = parameter(float('inf'), 'farther points are no hits [m]', gt=0.0)
    padding_offset: float = parameter(
        0.0, 'robot and objects are grown by this much where points are left out [m]', ge=0.0)
    padding_scale: float = parameter(1.0, 'and are so many times as large', gt=0.0)
    point_subsample: int = parameter(1, 'every n-th row and column counts', ge=1)
    max_update_rate: float = parameter(0.0, 'clouds a second at most; 0 takes all [Hz]', ge=0.0)
    filtered_cloud_topic: str = parameter('', 'topic of the points that are left; none: not sent')
    ns: str = parameter('', 'prefix of that topic')


class DepthImageSensor(Settings):
    """A sensor whose depth images are added to the map."""

    sensor_plugin: str = parameter(DEPTH_IMAGES, 'the kind of updater')
    image_topic: str = parameter(
        'depth', 'topic of the images, with camera_info beside it', min_length=1)
    queue_size: int = parameter(5, 'images that wait for their transforms', ge=1, le=100)
    near_clipping_plane_distance: float = parameter(0.3, 'nearest depth that counts [m]', ge=0.0)
    far_clipping_plane_distance: float = parameter(5.0, 'farthest depth that counts [m]', gt=0.0)
    shadow_threshold: float = parameter(
        0.04, 'depth behind the robot that is left out [m]: has no effect, as the robot itself is '
        'left out exactly', ge=0.0)
    padding_offset: float = parameter(
        0.02, 'robot and objects are grown by this much where points are left out [m]', ge=0.0)
    padding_scale: float = parameter(
        0.0, f'and by this times {DEPTH_NOISE:g} of the square of their depth [m]', ge=0.0)
    skip_vertical_pixels: int = parameter(4, 'rows left out above and below', ge=0)
    skip_horizontal_pixels: int = parameter(6, 'columns left out left and right', ge=0)
    max_update_rate: float = parameter(0.0, 'images a second at most; 0 takes all [Hz]', ge=0.0)
    filtered_cloud_topic: str = parameter(
        '', 'topic of the image without the robot (16UC1) [mm]; none: not sent')
    ns: str = parameter('', 'prefix of that topic')


Sensor = PointCloudSensor | DepthImageSensor
_KINDS: Mapping[str, type[PointCloudSensor] | type[DepthImageSensor]] = {
    CLOUDS: PointCloudSensor, DEPTH_IMAGES: DepthImageSensor}


class OctomapSettings(Settings):
    """
    What builds the octomap.

    :param sensors: name -> sensor; without any no map is built.
    """

    octomap_resolution: float = parameter(USUAL_RESOLUTION, 'edge of a cell [m]', ge=1e-3, le=10.0)
    sensors: dict[str, Sensor] = parameter({}, 'name -> sensor')


def sensors_file(folder: Path) -> Path | None:
    """Return the file of the sensors of a robot's folder or package."""
    return next((file for file in (folder / 'config' / FILE, folder / FILE)
                 if file.is_file()), None)


def read_sensors_file(file: Path | None, problems: list[Problem]) -> OctomapSettings:
    """Return what a file asks for; none asks for nothing, and so does a broken one."""
    if file is None:
        return OctomapSettings()
    try:
        root = read_yaml_file(file, problems)
    except ConfigError as error:
        problems.extend(error.problems)
        return OctomapSettings()
    if is_ros2_file(root):
        root = parameters_of_node(root, 'move_group', '/') or root.with_value({})
    return read_sensors(root, problems)


def read_sensors(root: YamlNode, problems: list[Problem]) -> OctomapSettings:
    """
    Return the sensors of a block of parameters.

    :param root: ``sensors`` with their names, a block for each, and the keys of the map.
    :param problems: remarks are added: a sensor that cannot be used is left out, as upstream.
    """
    listed = root.get('sensors')
    if listed is None or not listed.items or listed.items[0].value in ('', None):
        return OctomapSettings()
    sensors: dict[str, Sensor] = {}
    for item in listed.items:
        if not isinstance(item.value, str):
            problems.append(Problem(
                f"'sensors' has {item.kind}", item.place, 'names of sensors',
                'give each sensor a name, and a block of that name beside the list',
                severity=Severity.WARNING))
            continue
        sensor = _sensor(item.value, root.get(item.value), item, problems)
        if sensor is not None:
            sensors[item.value] = sensor
    problems.extend(Problem(
        f"the block '{name}' is not used", node.key_where or node.place, severity=Severity.INFO)
        for name, node in root.entries.items() if node.is_mapping and name not in sensors)
    values: dict[str, Any] = {'sensors': sensors}
    resolution, frame = root.get('octomap_resolution'), root.get('octomap_frame')
    if resolution is not None:
        values['octomap_resolution'] = resolution.value
    elif sensors:
        problems.append(Problem(
            f"the octomap has no 'octomap_resolution'; {USUAL_RESOLUTION} m is used",
            listed.place, severity=Severity.WARNING))
    if frame is not None:
        problems.append(Problem(
            "'octomap_frame' has no effect: the map is in the model frame",
            frame.key_where or frame.place, severity=Severity.INFO))
    try:
        return OctomapSettings(**values)
    except ValueError:
        block = root.with_value({key: node for key, node in root.entries.items()
                                 if key == 'octomap_resolution'})
        read_settings(OctomapSettings, block, problems, title='octomap')
        return OctomapSettings()


def _sensor(
    name: str, block: YamlNode | None, item: YamlNode, problems: list[Problem]
) -> Sensor | None:
    if block is None or not block.is_mapping:
        problems.append(Problem(
            f"sensor '{name}' has no block", item.place, remedy=f"add '{name}:' with its keys",
            severity=Severity.WARNING))
        return None
    plugin = block.get('sensor_plugin')
    kind = str(plugin.value) if plugin is not None and plugin.value is not None else ''
    if not kind or kind.startswith('~'):
        problems.append(Problem(f"sensor '{name}' has no plugin and is left out", block.place,
                                severity=Severity.INFO))
        return None
    if kind not in _KINDS:
        problems.append(Problem(
            f"sensor '{name}': plugin '{kind}' is not known; the sensor is left out",
            block.place, ', '.join(_KINDS), nearest(kind, tuple(_KINDS)),
            severity=Severity.WARNING))
        return None
    absent = [key for key in _KINDS[kind].model_fields
              if key not in ('ns', 'sensor_plugin') and block.get(key) is None]
    if kind == DEPTH_IMAGES and absent:
        block = _without_topic(name, block, absent, problems)
    found: list[Problem] = []
    sensor = read_settings(_KINDS[kind], block, found, title=f"sensor '{name}'")
    problems.extend(Problem(problem.what, problem.where, problem.allowed, problem.remedy,
                            severity=Severity.WARNING) if sensor is None else problem
                    for problem in found)
    if sensor is not None:
        if absent:
            problems.append(Problem(
                f"sensor '{name}' has its defaults for {', '.join(absent)}",
                Location(block.place.file), severity=Severity.INFO))
        unused = block.get('shadow_threshold')
        if unused is not None and isinstance(sensor, DepthImageSensor):
            problems.append(Problem(
                f"sensor '{name}': 'shadow_threshold' has no effect: the robot itself is left "
                'out exactly', unused.key_where or unused.place, severity=Severity.INFO))
    return sensor


def _without_topic(
    name: str, block: YamlNode, absent: list[str], problems: list[Problem]
) -> YamlNode:
    """Return the block of a depth sensor that lacks keys without those that do not count then."""
    for key in _AFTER_ALL_OTHERS:
        unread = block.get(key)
        if unread is not None:
            problems.append(Problem(
                f"sensor '{name}': '{key}' has no effect without {', '.join(absent)}, as in "
                'MoveIt: the image without the robot is not sent',
                unread.key_where or unread.place, severity=Severity.INFO))
    return block.without(*_AFTER_ALL_OTHERS)


def with_cameras(settings: OctomapSettings, cameras: Mapping[str, Any]) -> OctomapSettings:
    """
    Return the settings with a cloud updater for each simulated camera.

    :param cameras: by name.
    """
    if not cameras:
        return settings
    sensors = {**{name: PointCloudSensor(point_cloud_topic=f'/{name}/depth/points', max_range=5.0,
                                         padding_offset=0.02)
                  for name in cameras}, **settings.sensors}
    given = bool(settings.sensors)
    return OctomapSettings(
        sensors=sensors,
        octomap_resolution=settings.octomap_resolution if given else CAMERA_RESOLUTION)
