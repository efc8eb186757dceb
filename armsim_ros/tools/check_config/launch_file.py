# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ROS 1 launch files: what replaces each of their lines."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
import re

from armsim_ros.cli.arguments import argument_table
from armsim_ros.cli.launch_answers import REPLACED_ARGUMENTS
from armsim_ros.config.yaml_source import LARGEST_FILE
from armsim_ros.errors import ModelError, nearest, Problem, Severity
from armsim_ros.model.description.xacro_text import read_text
from armsim_ros.model.description.xml_tree import parse_xml, XmlElement

#: Flag -> how many words follow it.
_FLAGS = {'-urdf': 0, '-sdf': 0, '-gazebo': 0, '-unpause': 0, '-wait': 1, '-model': 1,
          '-param': 1, '-file': 1, '-database': 1, '-namespace': 1,
          '-x': 1, '-y': 1, '-z': 1, '-R': 1, '-P': 1, '-Y': 1, '-J': 2, '-b': 0,
          '-robot_namespace': 1, '-gazebo_namespace': 1, '-reference_frame': 1,
          '-package_to_model': 0}
_RUN_TOGETHER = re.compile(r'([0-9.])(?=-[A-Za-z])')
_TURNED = {'-R': 0, '-P': 1, '-Y': 2}


def answer_spawn_model(element: XmlElement) -> Iterator[Problem]:
    """Yield what to give to bringup in place of a node that puts a model into Gazebo."""
    text = element.get('args')
    apart = _RUN_TOGETHER.sub(r'\1 ', text)
    if apart != text:
        culprit = next(word for word in text.split() if _RUN_TOGETHER.search(word))
        yield Problem(f"the words of <node args> run together at '{culprit}'; read with a space "
                      "before each '-'", element.where,
                      remedy='put the space there; line breaks were probably lost in copying',
                      severity=Severity.WARNING)
    words = apart.split()
    arguments: list[str] = []
    joints: list[str] = []
    turned = [0.0, 0.0, 0.0]
    position = 0
    while position < len(words):
        flag = words[position]
        count = _FLAGS.get(flag)
        if count is None:
            yield Problem(f"'{flag}' is not a flag of spawn_model", element.where,
                          ', '.join(_FLAGS), severity=Severity.WARNING)
            position += 1
            continue
        values = words[position + 1:position + 1 + count]
        position += 1 + count
        if len(values) < count:
            yield Problem(f"flag '{flag}' of spawn_model has too few values", element.where,
                          severity=Severity.WARNING)
        elif flag == '-model':
            arguments.append(f'robot:={values[0]}')
        elif flag in ('-x', '-y', '-z'):
            arguments.append(f'{flag[1]}:={values[0]}')
        elif flag in _TURNED:
            turned[_TURNED[flag]] = _number(values[0])
        elif flag == '-J':
            joints.append(f'{values[0]}={values[1]}')
        elif flag in ('-robot_namespace', '-namespace'):
            arguments.append(f'namespace:={values[0].strip("/")}')
        elif flag == '-file':
            arguments.append(f'urdf:={values[0]}')
    if joints:
        arguments.append(f"initial_positions:={','.join(joints)}")
    answer = f"bringup {' '.join(arguments)}".strip()
    if any(turned):
        answer += f', and placement: {{rpy: {turned}}} in simulation.yaml'
    yield Problem(f"node '{element.get('name')}' (gazebo_ros/spawn_model): {answer}",
                  element.where, severity=Severity.CHANGED)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0


_READ_HERE = 'its settings are read from the YAML files of the robot'
_MOVE_GROUP = 'bringup starts move_group'

#: Launch file that is included, by its name -> its replacement.
INCLUDED: dict[str, str] = {
    'empty_world.launch': 'bringup starts the simulation, with a floor or world:=NAME|FILE',
    'move_group.launch': _MOVE_GROUP,
    'moveit_rviz.launch': REPLACED_ARGUMENTS['rviz'],
    'planning_context.launch': _READ_HERE,
    'planning_pipeline.launch.xml': _READ_HERE,
    'trajectory_execution.launch.xml': _READ_HERE,
    'sensor_manager.launch.xml': 'sensors are those of sensors_3d.yaml',
}

#: (package, type) of a node -> its replacement; '' is any type.
NODES: dict[tuple[str, str], str] = {
    ('robot_state_publisher', ''): 'the simulation publishes /tf and /robot_description',
    ('joint_state_publisher', ''):
        "the simulation publishes joint_states in the controllers' namespace, and move_group "
        'listens there',
    ('joint_state_publisher_gui', ''): 'the simulation publishes joint_states',
    ('rviz', ''): REPLACED_ARGUMENTS['rviz'],
    ('rviz2', ''): REPLACED_ARGUMENTS['rviz'],
    ('moveit_ros_move_group', ''): _MOVE_GROUP,
    ('gazebo_ros', 'gzserver'): 'bringup starts the simulation',
    ('gazebo_ros', 'gzclient'): REPLACED_ARGUMENTS['gui'],
    ('tf', 'static_transform_publisher'):
        'start it as before: ros2 run tf2_ros static_transform_publisher',
}

#: Start of a parameter's name -> its replacement.
PARAMETERS: dict[str, str] = {
    'robot_description_semantic': "the robot's SRDF file is read, or srdf:=FILE",
    'robot_description': "the robot's URDF or xacro file is read, or urdf:=FILE",
    'trajectory_execution/': 'the same key in trajectory_execution.yaml',
    'moveit_manage_controllers': 'the same key in trajectory_execution.yaml',
    'moveit_controller_manager': 'the built-in manager does the work of each',
    'planning_scene_monitor/': REPLACED_ARGUMENTS['publish_monitored_planning_scene'],
    'allow_trajectory_execution': 'the same key in trajectory_execution.yaml',
    'max_safe_path_cost': REPLACED_ARGUMENTS['max_safe_path_cost'],
    'jiggle_fraction': REPLACED_ARGUMENTS['jiggle_fraction'],
    'capabilities': REPLACED_ARGUMENTS['capabilities'],
    'disable_capabilities': REPLACED_ARGUMENTS['capabilities'],
    'use_gui': REPLACED_ARGUMENTS['use_gui'],
    'source_list': 'move_group listens to the joint states of the simulation',
    'publish_frequency': 'the rate is publish_rate of the joint state controller',
    'tf_prefix': REPLACED_ARGUMENTS['tf_prefix'],
    'use_sim_time': 'use_sim_time:=true|false',
}

#: Arguments of launch files whose names mean something else in bringup.
_OTHER_MEANING = {'config': REPLACED_ARGUMENTS['rviz_config']}

_GROUPING = ('launch', 'group')
_SILENT = ('remap', 'env', 'test', 'machine')
_LAUNCH_FILE_FLAGS = ('respawn', 'required', 'clear_params', 'pass_all_args')


def answer_launch_file(file: Path, controllers: Collection[str] | None = None,
                       yaml_files: Collection[str] | None = None) -> list[Problem]:
    """
    Return what to use in place of each line of a ROS 1 launch file.

    :param controllers: the names that a spawner may start; None where they are not known.
    :param yaml_files: names of the files that are read; None where they are not known.
    :raises ConfigError: the text is not a launch file.
    """
    if file.stat().st_size > LARGEST_FILE:
        raise ModelError(Problem(f'{file} is larger than {LARGEST_FILE >> 20} MiB'))
    root = parse_xml(read_text(file), str(file))
    if root.tag != 'launch':
        raise ModelError(Problem(f'the root element is <{root.tag}>', root.where, '<launch>'))
    return list(_LaunchFile(controllers, yaml_files).answers(root))


class _LaunchFile:
    """Walks over the elements of a file."""

    def __init__(self, controllers: Collection[str] | None,
                 yaml_files: Collection[str] | None) -> None:
        self._controllers, self._yaml_files = controllers, yaml_files

    def answers(self, element: XmlElement) -> Iterator[Problem]:
        for child in element.children:
            yield from self._flags(child)
            if child.tag in _GROUPING:
                yield from self.answers(child)
            elif child.tag == 'arg':
                yield from self._argument(child)
            elif child.tag == 'include':
                yield from self._include(child)
            elif child.tag == 'param':
                yield from self._parameter(child)
            elif child.tag == 'rosparam':
                yield from self._file_of_parameters(child)
            elif child.tag == 'node':
                yield from self._node(child)
            elif child.tag not in _SILENT:
                known = ('arg', 'include', 'param', 'rosparam', 'node', *_GROUPING, *_SILENT)
                yield Problem(f'<{child.tag}> is not an element of a launch file', child.where,
                              ', '.join(known), nearest(child.tag, known), Severity.WARNING)

    def _flags(self, element: XmlElement) -> Iterator[Problem]:
        for name in _LAUNCH_FILE_FLAGS:
            value = element.get(name)
            if value and value not in ('true', 'false') and not value.startswith('$('):
                yield Problem(f"<{element.tag} {name}> is '{value}'", element.where,
                              'true, false', severity=Severity.WARNING)

    def _argument(self, element: XmlElement) -> Iterator[Problem]:
        name = element.get('name')
        value = element.get('value') or element.get('default')
        if 'value' in element.attributes and value.startswith('$(arg'):
            return  # passed on; where it was declared it has had its answer
        yield _answer(element, f"argument '{name}'", _argument_answer(name, value))

    def _include(self, element: XmlElement) -> Iterator[Problem]:
        file = element.get('file').rsplit('/', 1)[-1]
        answer = INCLUDED.get(file, 'see the check of that file')
        yield _answer(element, f"include of '{file}'", answer)
        for child in element.all('arg'):
            yield from self._argument(child)

    def _parameter(self, element: XmlElement) -> Iterator[Problem]:
        name = element.get('name').strip('/')
        found = [text for start, text in PARAMETERS.items() if name.startswith(start)]
        answer = found[0] if found else 'parameters are in the YAML files of the robot'
        block, _, key = name.partition('/')
        value = element.get('value')
        if block == 'trajectory_execution' and key and value and not value.startswith('$('):
            answer = f'trajectory_execution: {{{key}: {value}}} in trajectory_execution.yaml'
        yield _answer(element, f"parameter '{name}'", answer)

    def _file_of_parameters(self, element: XmlElement) -> Iterator[Problem]:
        if 'file' not in element.attributes:
            yield from self._parameter(XmlElement(
                'rosparam', {'name': element.get('param')}, element.where))
            return
        file = element.get('file').rsplit('/', 1)[-1]
        if self._yaml_files is not None and file not in self._yaml_files:
            yield Problem(f"'{file}' is loaded here, and is not among the robot's files",
                          element.where, ', '.join(sorted(self._yaml_files)),
                          "put it into the robot's folder", Severity.WARNING)
        else:
            yield _answer(element, f"file '{file}'",
                          "every YAML file of the robot's folder is read")

    def _node(self, element: XmlElement) -> Iterator[Problem]:
        package, kind = element.get('pkg'), element.get('type')
        if package == 'controller_manager':
            yield from self._spawner(element)
        elif (package, kind) == ('gazebo_ros', 'spawn_model'):
            yield from answer_spawn_model(element)
        else:
            answer = NODES.get((package, kind)) or NODES.get((package, ''))
            if answer is not None:
                yield _answer(element, f"node '{element.get('name')}' ({package}/{kind})", answer)
            else:
                yield Problem(f"node '{element.get('name')}' ({package}/{kind}) is not started "
                              'here', element.where, severity=Severity.INFO)
        for child in element.children:
            if child.tag == 'param':
                yield from self._parameter(child)
            elif child.tag == 'rosparam':
                yield from self._file_of_parameters(child)

    def _spawner(self, element: XmlElement) -> Iterator[Problem]:
        words = re.findall(r'\S+', element.get('args'))
        names = [word for word in words if not word.startswith('-') and word != 'spawn']
        shown = ', '.join(names) or 'no controller'
        yield _answer(element, f'spawner of {shown}',
                      'every controller that fits is activated; spawn: [...] in simulation.yaml '
                      'names others')
        for name in names:
            if self._controllers is not None and name not in self._controllers:
                known = tuple(self._controllers)
                yield Problem(f"controller '{name}' is spawned here, but no file describes it",
                              element.where, ', '.join(known), nearest(name, known),
                              Severity.WARNING)


def _argument_answer(name: str, value: str) -> str:
    known = [entry.name for entry in argument_table()]
    if name in _OTHER_MEANING:
        return _OTHER_MEANING[name]
    if name in known:
        return f'{name}:={value}' if value and '$(' not in value else f'{name}:=VALUE'
    return REPLACED_ARGUMENTS.get(name, 'an argument of that launch file alone')


def _answer(element: XmlElement, what: str, answer: str) -> Problem:
    return Problem(f'{what}: {answer}', element.where, severity=Severity.CHANGED)
