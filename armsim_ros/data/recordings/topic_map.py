# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which topics of a recording become which features: a YAML file.

::

    fps: 20
    task: Pick up the cube.
    episode: {topic: /recording}     # a Bool, or a String that names the task; or {gap: 1.0} [s]
    features:
      observation.state:
        - {topic: /sunday/joint_states, names: [joint_1, joint_2]}
      action: {topic: /sunday/position_controller/commands}
      observation.images.front: {topic: /camera/color/image_raw}
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import Field, field_validator, ValidationError
import yaml

from armsim_ros.config.base import parameter, Settings
from armsim_ros.errors import ConfigError, Problem

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
