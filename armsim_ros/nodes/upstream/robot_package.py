# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A package folder made of parameters of a launch file, or of a published description."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
import math
from pathlib import Path
import re
import time
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
import yaml

from armsim_ros.cli.node_arguments import NodeArguments
from armsim_ros.config.draft import BLOCKS
from armsim_ros.config.layout import PIPELINE_KEYS
from armsim_ros.errors import ConfigError, Location, Problem
from armsim_ros.nodes import qos

URDF, SEMANTIC = 'robot_description', 'robot_description_semantic'
_DUMPER = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)
_KINEMATICS = 'robot_description_kinematics'
_PLANNING = 'robot_description_planning'
_CONTROLLERS = ('moveit_simple_controller_manager', 'moveit_controller_manager')
#: Parameters that have their own files, or that are the robot's text.
_ELSEWHERE = (URDF, SEMANTIC, _KINEMATICS, _PLANNING,
              *_CONTROLLERS, 'planning_pipelines', 'use_sim_time')
#: Name of the pipeline where none is listed.
_FALLBACK = 'move_group'
#: How the folder begins that a program makes for it, and takes away at its end.
PREFIX = 'armsim_robot_'
_ROBOT_NAME = re.compile(r'<robot[^>]*?\sname\s*=\s*["\']([^"\']+)["\']')


class RobotPackage:
    """
    A folder that looks like a MoveIt configuration package.

    :param top: where it is made, an empty folder.
    :param urdf: the robot description.
    :param srdf: the semantic description, '' if there is none.
    """

    def __init__(self, top: Path, urdf: str, srdf: str = '') -> None:
        match = _ROBOT_NAME.search(urdf)
        if match is None:
            raise ConfigError(Problem(
                "the parameter or topic 'robot_description' holds no URDF",
                Location('robot_description', 1), '<robot name="...">'))
        self.name = re.sub(r'\W', '_', match[1])
        self.folder = top / f'{self.name}_moveit_config'
        self._config = self.folder / 'config'
        self._config.mkdir(parents=True)
        self._write('../package.xml',
                    f'<package format="3"><name>{self.name}_moveit_config</name></package>\n')
        self._write(f'{self.name}.urdf', urdf)
        if srdf:
            self._write(f'{self.name}.srdf', srdf)

    @property
    def urdf(self) -> Path:
        """The file with the robot description."""
        return self._config / f'{self.name}.urdf'

    def add_simulation(self, *, spawn: Iterable[str] = (), placement: Mapping[str, Any],
                       hardware: Mapping[str, Any] | None = None) -> None:
        """
        Set which controllers are active from the start, and the pose of the robot.

        Description and transforms are left to the robot_state_publisher of the launch file.
        """
        self._dump('simulation.yaml', {
            'spawn': list(spawn), 'state_publisher': False,
            **({'placement': dict(placement)} if placement else {}),
            **({'hardware': dict(hardware)} if hardware else {})})

    def add_controllers(self, number: int, text: str) -> Path:
        """Add a file with ros2_control's controllers."""
        return self._write(f'parameters_{number}.yaml', text)

    def add_manager(self, values: Mapping[str, Any], number: int) -> Path:
        """Add the parameters of the controller manager."""
        name = f'parameters_{number}.yaml'
        return self._dump(name, {'controller_manager': {'ros__parameters': dict(values)}})

    def add_empty_world(self) -> Path:
        """Add a world without a floor: what a real robot or mock components know of none."""
        return self._write('../world.yaml', 'floor: false\n')

    def add_move_group(self, values: Mapping[str, Any]) -> None:
        """
        Add the parameters of move_group.

        :param values: by their names with dots.
        """
        nested = unflattened(values)
        self._dump('kinematics.yaml', nested.get(_KINEMATICS))
        limits = dict(nested.get(_PLANNING) or {})
        tool = limits.pop('cartesian_limits', None)
        self._dump('joint_limits.yaml', limits)
        if tool:
            self._dump('pilz_cartesian_limits.yaml', {'cartesian_limits': tool})
        self._dump('moveit_controllers.yaml',
                   {key: nested[key] for key in _CONTROLLERS if key in nested})
        pipelines = _pipelines(nested)
        for name in pipelines:
            if isinstance(nested.get(name), Mapping):
                self._dump(f'{name}_planning.yaml', nested[name])
        self._dump('trajectory_execution.yaml', {
            **{key: value for key, value in nested.items()
               if key in BLOCKS and key not in _ELSEWHERE and key not in pipelines},
            **({'planning_pipelines': pipelines} if pipelines else {})})

    def _dump(self, name: str, content: Any) -> Path:
        if not content:
            return self._config / name
        return self._write(name, yaml.dump(content, Dumper=_DUMPER, sort_keys=False))

    def _write(self, name: str, text: str) -> Path:
        path = self._config / name
        path.write_text(text, encoding='utf-8')
        return path


def _pipelines(nested: Mapping[str, Any]) -> list[str]:
    """
    Return the names of the pipelines, in their order.

    Without a list, parameters in the namespace ``move_group`` make the pipeline of that name.
    """
    listed = nested.get('planning_pipelines') or ()
    if isinstance(listed, Mapping):
        listed = listed.get('pipeline_names') or ()
    if isinstance(listed, str):
        listed = listed.split()
    names = [name for name in listed if name]
    block = nested.get(_FALLBACK)
    if not names and isinstance(block, Mapping) and not PIPELINE_KEYS.isdisjoint(block):
        return [_FALLBACK]
    return names


def described_package(arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Write the package of the robot that parameters or topics describe; return the words for it.

    :param folder: where it is made.
    :raises ConfigError: where a description is none.
    """
    values = arguments.values
    missing = [name for name in (URDF, SEMANTIC) if not values.get(name)]
    if missing:
        values.update(wait_for_descriptions(arguments, missing, missing))
    package = RobotPackage(folder, str(values[URDF]), str(values[SEMANTIC]))
    package.add_move_group(values)
    words = [f'robot:={package.folder}', f'urdf:={package.urdf}']
    if values.get('armsim.packages_path'):
        words.append(f"packages_path:={values['armsim.packages_path']}")
    return words


def unflattened(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters with dots in their names as blocks."""
    nested: dict[str, Any] = {}
    for name, value in values.items():
        place = nested
        *heads, last = name.split('.')
        for head in heads:
            inner = place.get(head)
            if not isinstance(inner, dict):
                inner = place[head] = {}
            place = inner
        place[last] = value
    return nested


#: Period of reporting what is waited for [s].
_REMINDER = 5.0


def wait_for_descriptions(
    arguments: NodeArguments, topics: Sequence[str], needed: Sequence[str] = (), *,
    timeout: float = math.inf,
) -> dict[str, str]:
    """
    Return topic -> text.

    :param topics: names relative to the node.
    :param needed: those to wait for; the first of all that comes, where empty.
    :param timeout: [s] after which that is returned which has come.
    """
    context = rclpy.Context()
    rclpy.init(args=arguments.ros_args(with_name=True), context=context)
    found: dict[str, str] = {}
    try:
        node = Node(f'{arguments.name}_waits', context=context, use_global_arguments=True,
                    enable_rosout=False, start_parameter_services=False)
        for topic in topics:
            node.create_subscription(String, topic, partial(_note, found, topic), qos.LATCHED)
        node.create_timer(_REMINDER, lambda: node.get_logger().info(
            f"waiting for the topic {' or '.join(topics)}"))
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        deadline = time.monotonic() + timeout
        while not found or any(topic not in found for topic in needed):
            rest = deadline - time.monotonic()
            if rest <= 0.0:
                break
            executor.spin_once(None if math.isinf(rest) else rest)
        node.destroy_node()
    finally:
        context.try_shutdown()
    return found


def _note(found: dict[str, str], topic: str, message: String) -> None:
    found.setdefault(topic, message.data)
