# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a recording that become features; numbers and pictures in their messages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, ValidationError
import yaml

from armsim_ros.arrays import Vector
from armsim_ros.config.base import parameter, Settings
from armsim_ros.data.video import decoded
from armsim_ros.errors import ArmsimError, ConfigError, Problem

#: An episode ends where nothing came for so long, where the file has no other value [s].
GAP = 1.0


class Source(Settings):
    """A topic, and what is taken of its messages."""

    topic: str = parameter(description='name of the topic')
    names: tuple[str, ...] = parameter((), 'joints of JointState and JointTrajectory, in the '
                                       'order of the feature; what the numbers are, of others')
    field: Literal['position', 'velocity', 'effort'] = parameter(
        'position', 'what is taken of a JointState')
    gaps: bool = parameter(False, 'whether the topic may be silent for more than three frames')


class EpisodeMarks(Settings):
    """How a recording is cut into episodes."""

    topic: str = parameter('', 'a Bool that is true in an episode, or a String: its task, empty '
                               'between episodes')
    gap: float = parameter(GAP, 'without a topic: silence that ends an episode [s]', gt=0.0)


class TopicMap(Settings):
    """A map file."""

    fps: int = parameter(description='frames per second', ge=1, le=1000)
    task: str = parameter('', 'what is done, a sentence; a String topic of episode overrides it')
    robot_type: str = parameter('', 'name of the robot')
    episode: EpisodeMarks = Field(default_factory=EpisodeMarks)
    features: dict[str, tuple[Source, ...]] = parameter(description='feature -> its topics')

    @field_validator('features', mode='before')
    @classmethod
    def _several(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {name: source if isinstance(source, (list, tuple)) else (source,)
                for name, source in value.items()}

    @property
    def topics(self) -> tuple[str, ...]:
        """All topics of the features."""
        return tuple(dict.fromkeys(
            source.topic for sources in self.features.values() for source in sources))


def topic_map(file: Path) -> TopicMap:
    """
    Return the content of a map file.

    :raises ConfigError: it cannot be read, or has errors; all are named.
    """
    try:
        content = yaml.safe_load(file.read_text(encoding='utf-8'))
        return TopicMap.model_validate(content)
    except (OSError, yaml.YAMLError) as error:
        raise ConfigError(Problem(f"'{file}' cannot be read: {error}")) from None
    except ValidationError as error:
        raise ConfigError([
            Problem(f'{file}: {".".join(map(str, detail["loc"]))}: {detail["msg"]}')
            for detail in error.errors(include_url=False)]) from None


IMAGES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')
_POSE = ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')
_TWIST = ('vx', 'vy', 'vz', 'wx', 'wy', 'wz')
_WRENCH = ('fx', 'fy', 'fz', 'tx', 'ty', 'tz')
#: Encoding of an Image -> bytes of a pixel, and which of them are red, green and blue.
_ENCODINGS = {'rgb8': (3, (0, 1, 2)), 'bgr8': (3, (2, 1, 0)), 'rgba8': (4, (0, 1, 2)),
              'bgra8': (4, (2, 1, 0)), 'mono8': (1, (0, 0, 0))}


def stamp_of(message: Any, arrival_ns: int) -> int:
    """Return the time of a message [ns]: its header's, else when it arrived."""
    header = getattr(message, 'header', None)
    if header is None:
        return arrival_ns
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def numbers_of(message: Any, kind: str, source: Source) -> Vector:
    """
    Return what a feature takes of a message.

    :param kind: its type, such as ``sensor_msgs/msg/JointState``.
    :raises ArmsimError: a joint that it does not have, or a type without numbers.
    """
    if kind == 'sensor_msgs/msg/JointState':
        return _joints(list(message.name), getattr(message, source.field), source)
    if kind == 'trajectory_msgs/msg/JointTrajectory':
        points = message.points
        return _joints(list(message.joint_names), points[-1].positions if points else (), source)
    if kind not in _NUMBERS:
        raise ArmsimError(f"'{source.topic}' is a {kind}, which has no numbers for a feature; "
                          f'allowed: {", ".join((*_JOINTS, *_NUMBERS, *IMAGES))}')
    return np.array(_NUMBERS[kind][1](message), dtype=np.float64)


def names_of(kind: str, source: Source, count: int) -> tuple[str, ...]:
    """Return what the numbers of a source are."""
    if source.names:
        return source.names
    usual = _NUMBERS.get(kind, ((), None))[0]
    base = source.topic.strip('/').replace('/', '.')
    return tuple(f'{base}.{name}' for name in (usual or map(str, range(count))))


def picture_of(message: Any, kind: str, topic: str) -> NDArray[np.uint8]:
    """
    Return the picture of a message (h, w, 3), red first.

    :raises ArmsimError: an encoding that is not known.
    """
    if kind == 'sensor_msgs/msg/CompressedImage':
        return decoded(bytes(message.data))[0]
    if message.encoding not in _ENCODINGS:
        raise ArmsimError(f"'{topic}' has pictures in '{message.encoding}'; allowed: "
                          f'{", ".join(_ENCODINGS)}')
    width, channels = _ENCODINGS[message.encoding]
    rows = np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, message.step)
    pixels = rows[:, : message.width * width].reshape(message.height, message.width, width)
    return np.ascontiguousarray(pixels[:, :, channels])


def _joints(names: list[str], values: Any, source: Source) -> Vector:
    missing = [name for name in source.names if name not in names]
    if missing or not source.names:
        raise ArmsimError(f"'{source.topic}' has no joint '{missing[0]}'; it has "
                          f'{", ".join(names)}' if missing else
                          f"'{source.topic}' needs names, of {', '.join(names)}")
    places = [names.index(name) for name in source.names]
    if max(places) >= len(values):
        raise ArmsimError(f"'{source.topic}' has no {source.field} of its joints")
    return np.array([values[place] for place in places], dtype=np.float64)


def _vector(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _pose(pose: Any) -> list[float]:
    turn = pose.orientation
    return [*_vector(pose.position), turn.x, turn.y, turn.z, turn.w]


def _twist(twist: Any) -> list[float]:
    return [*_vector(twist.linear), *_vector(twist.angular)]


def _wrench(wrench: Any) -> list[float]:
    return [*_vector(wrench.force), *_vector(wrench.torque)]


_JOINTS = ('sensor_msgs/msg/JointState', 'trajectory_msgs/msg/JointTrajectory')
_NUMBERS: dict[str, tuple[tuple[str, ...], Callable[[Any], list[float]]]] = {
    'std_msgs/msg/Float64MultiArray': ((), lambda message: list(message.data)),
    'std_msgs/msg/Float64': ((), lambda message: [message.data]),
    'geometry_msgs/msg/Pose': (_POSE, _pose),
    'geometry_msgs/msg/PoseStamped': (_POSE, lambda message: _pose(message.pose)),
    'geometry_msgs/msg/Twist': (_TWIST, _twist),
    'geometry_msgs/msg/TwistStamped': (_TWIST, lambda message: _twist(message.twist)),
    'geometry_msgs/msg/Wrench': (_WRENCH, _wrench),
    'geometry_msgs/msg/WrenchStamped': (_WRENCH, lambda message: _wrench(message.wrench)),
    'control_msgs/msg/GripperCommand': (('position',), lambda message: [message.position]),
}
