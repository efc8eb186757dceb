# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which topics of a ros_gz_bridge the simulation publishes, and which nothing publishes here."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
import re

import yaml

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.cli.node_arguments import read_node_arguments
from armsim_ros.errors import ArmsimError
from armsim_ros.launch.process_spec import ProcessSpec, ProgramRole, role_of, RosNode

#: How the names of the topics end that the simulation or its controllers publish.
_PUBLISHED = ('clock', 'joint_states', 'tf', 'tf_static')
#: How the types end of what cameras publish.
_OF_CAMERAS = ('Image', 'CompressedImage', 'CameraInfo', 'PointCloud2')
#: TOPIC@ROS_TYPE, then a sign of the direction and Gazebo's type.
_WORD = re.compile(r'([^@]+)@([^@\[\]]+)')


def unserved_topics(spec: ProcessSpec) -> str:
    """
    Return a warning of the topics and services of a bridge that are not simulated.

    :returns: '' where there are none, or the process is not a bridge; why its words
        or files cannot be read.
    """
    if role_of(spec) is not ProgramRole.BRIDGE:
        return ''
    try:
        words, ros_args = split_ros_args(spec.arguments)
        node = spec.node or RosNode('', spec.name)
        given = read_node_arguments(
            [*ros_args, *node.ros_arguments, *node.parameter_files], node.name or node.executable)
        rules = (*node.remappings, *(rule.split(':=', 1) for rule in given.remappings))
        named = {name.strip('/'): target for name, target in rules}
        file = node.merged().get('config_file') or given.values.get('config_file')
        found = {named.get(topic.strip('/'), topic): kind
                 for topic, kind in (*_of_words(words), *(_of_file(file) if file else ()))}
    except (ArmsimError, OSError, ValueError, yaml.YAMLError) as error:
        return f'the topics of the bridge cannot be read: {error}'
    missing = {topic: kind for topic, kind in found.items()
               if topic.rpartition('/')[2] not in _PUBLISHED}
    if not missing:
        return ''
    listed = ', '.join(f'{topic} ({kind})' for topic, kind in missing.items())
    hint = ''
    if any(kind.endswith(_OF_CAMERAS) for kind in missing.values()):
        hint = ("; cameras are those of simulation.yaml, with 'armsim bringup camera:=true' "
                '(docs/world.md)')
    return f'not simulated: {listed}{hint}'


def _of_words(words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield name and type of each topic and service of the arguments."""
    for word in words:
        match = _WORD.match(word)
        if match is not None:
            yield match[1], match[2]


def _of_file(file: object) -> Iterator[tuple[str, str]]:
    """Yield name and type of each topic and service of a configuration file."""
    content = yaml.safe_load(Path(str(file)).read_text(encoding='utf-8'))
    for entry in content if isinstance(content, list) else ():
        if isinstance(entry, dict) and entry.get('ros_type_name'):
            names = (entry.get(key) for key in ('topic_name', 'ros_topic_name', 'gz_topic_name'))
            yield str(next(filter(None, names), '')), str(entry['ros_type_name'])
