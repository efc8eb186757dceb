# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The content of all files in a neutral form, and the blocks that a file may have by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from armsim_ros.config.base import known_keys
from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.config.pipeline_defaults import OMPL
from armsim_ros.config.trajectory_execution import KEYS_BESIDE
from armsim_ros.config.yaml_node import merge_nodes, node_of, split_keys, YamlNode
from armsim_ros.errors import ignored, Location, Problem, Severity

#: The blocks of the neutral form; each is a field of RobotSettings.
SECTIONS = (
    'controller_manager', 'controllers', 'spawn', 'joint_limits', 'kinematics', 'pipelines',
    'moveit_controllers', 'trajectory_execution', 'planning_parameters', 'simulation', 'servo')


def empty_node(where: Location | None = None) -> YamlNode:
    """Return a mapping without entries."""
    return YamlNode({}, where or Location('the defaults'))


@dataclass
class ConfigDraft:
    """
    What was found so far.

    :param sections: block -> its entries, of all files together.
    :param namespaces: namespace -> where it was first seen.
    :param problems: errors and remarks found on the way.
    :param published: whether the files are those of a published package, which their reader
        will not change.
    """

    sections: dict[str, YamlNode] = field(default_factory=dict)
    namespaces: dict[str, Location] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    published: bool = False

    def section(self, name: str) -> YamlNode:
        """Return a block; empty where no file has it."""
        return self.sections.get(name, empty_node())

    def add(self, section: str, node: YamlNode) -> None:
        """Lay entries over a block; a key that has another value already takes the new value."""
        known = self.sections.get(section)
        if known is None:
            self.sections[section] = node
            return
        self.sections[section], conflicts = merge_nodes(known, node)
        for path, first, second in conflicts:
            self.problems.append(ignored(Problem(
                f"{section}: '{path}' has another value here than in {first.place}",
                second.place, remedy='remove one of the two')))

    def add_entry(self, section: str, key: str, node: YamlNode) -> None:
        """Lay an entry over a block."""
        self.add(section, empty_node(node.place).with_value({key: node}))

    def override(self, section: str, path: list[str], node: YamlNode) -> None:
        """Override a value of the files."""
        for key in reversed(path):
            node = YamlNode({}, node.where).with_value({key: node})
        known = self.sections.get(section, empty_node(node.where))
        self.sections[section] = merge_nodes(known, node)[0]

    def see_namespace(self, namespace: str, where: Location) -> None:
        """Record the namespace of a controller."""
        self.namespaces.setdefault(namespace, where)


Take = Callable[[ConfigDraft, str, YamlNode], None]

_MOVEIT_MANAGER = 'moveit_simple_controller_manager'
_PLACEHOLDERS = ('controllers_initial_group_', 'controllers_initial_pose_')

#: Blocks whose keys are names and may have dots or slashes of their own.
KEEP_KEYS = frozenset({_MOVEIT_MANAGER})

#: Keys of a file that other programs of the stack read -> why they have no effect here.
UNUSED_BLOCKS: Mapping[str, str] = {
    'controller_manager_ns': 'the namespace of the controllers is that of their block',
    'hardware_interface': 'every joint of the URDF has all interfaces',
    'moveit_ros_control_interface': '',
    'use_controller_manager': 'move_group asks its own simulation',
    'sensors': 'it belongs into sensors_3d.yaml',
    'octomap_frame': 'the octomap is in the model frame',
    'octomap_resolution': 'it belongs into sensors_3d.yaml',
    'max_range': 'it belongs into sensors_3d.yaml',
    'sensor_plugin': 'it belongs into sensors_3d.yaml',
    'moveit_sensor_manager': 'sensors are those of sensors_3d.yaml',
    'max_safe_path_cost': 'planning with sensing is not part of ROS 2',
    'source_list': 'joint states come from the simulation',
    'use_gui': 'joint states come from the simulation',
    'use_sim_time': 'it is set once for all nodes of a program',
    'qos_overrides': '',
    'initial': 'a setting of fake controllers',
    'rate': 'a setting of fake controllers',
    'planning_scene_monitor_options': '',
    'robot_description': 'the URDF file is read',
    'robot_description_semantic': 'the SRDF file is read',
    'publish_robot_description': 'bringup publishes the description always',
    'publish_robot_description_semantic': 'bringup publishes the description always',
}


def _whole(section: str) -> Take:
    def take(draft: ConfigDraft, key: str, node: YamlNode) -> None:
        if node.is_mapping:
            draft.add(section, node)
        else:
            draft.problems.append(Problem(
                f"'{key}' is {node.kind}", node.place, 'a block of keys',
                'indent its keys deeper than itself'))
    return take


def _entry(section: str) -> Take:
    def take(draft: ConfigDraft, key: str, node: YamlNode) -> None:
        draft.add_entry(section, key, node)
    return take


def _take_controller_list(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    """Take ROS 1's list; its items name themselves."""
    if not isinstance(node.value, tuple):
        draft.problems.append(Problem(
            f"'{key}' is {node.kind}", node.place, 'a list of controllers',
            "begin each with '- name: ...', its keys in the column of 'name'"))
        return
    for item in node.items:
        name = item.get('name')
        if name is None or not isinstance(name.value, str):
            draft.problems.append(Problem(
                f"an item of '{key}' has no name", item.place,
                remedy="begin it with '- name: ...'"))
            continue
        if str(_plain(item, 'type')).startswith('fake'):
            draft.problems.append(Problem(
                f"fake controller '{name.value}' is not used here", item.place,
                severity=Severity.INFO))
            continue
        draft.add_entry('moveit_controllers', name.value, item)


def _take_moveit_manager(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    """Take ROS 2's form: a list of names, and a block for each."""
    names = node.get('controller_names')
    listed = [str(item.value) for item in names.items] if names else []
    node = _undotted(node, listed)
    if names is None and node.get('controller_list') is None:
        draft.problems.append(ignored(Problem(
            f"'{key}' has no 'controller_names': no controller is known", node.place,
            remedy="add 'controller_names', the list of the blocks that count")))
        return
    for name, block in node.entries.items():
        if name == 'controller_names':
            continue
        if name == 'controller_list':
            _take_controller_list(draft, name, block)
        elif name not in listed and block.is_mapping:
            draft.problems.append(Problem(
                f"controller '{name}' is not used here: 'controller_names' does not list it",
                block.place, severity=Severity.WARNING))
        elif block.is_mapping:
            named = {'name': node_of(name, block.place), **block.entries}
            draft.add_entry('moveit_controllers', name, block.with_value(named))
        else:
            draft.problems.append(ignored(Problem(
                f"'{name}' in '{key}' is {block.kind}", block.place, 'a block of keys')))
    for position, name in enumerate(listed):
        if node.get(name) is None and names is not None:
            draft.problems.append(ignored(Problem(
                f"'controller_names' lists '{name}', but '{key}' has no such block",
                names.items[position].where,
                remedy=f"add a block '{name}:' with type, action_ns and joints")))


def _undotted(node: YamlNode, names: list[str]) -> YamlNode:
    """
    Return a block in which ``name.key: value`` is ``name: {key: value}``.

    :param names: of blocks; they may have dots of their own.
    """
    found = node.without(*(key for key in node.entries if _head(key, names)))
    for key, inner in node.entries.items():
        head = _head(key, names)
        if head:
            rest = node.with_value({key[len(head) + 1:]: inner})
            found = merge_nodes(found, node.with_value({head: split_keys(rest, '.')}))[0]
    return found


def _head(key: str, names: list[str]) -> str:
    """Return the name that begins a dotted key, '' where none does."""
    fitting = [name for name in names if key.startswith(f'{name}.')]
    return max(fitting, key=len) if fitting and key not in names else ''


def _take_robot_description_planning(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    for inner_key, inner in node.entries.items():
        if inner_key in known_keys(PlanningParameters):
            draft.add_entry('planning_parameters', inner_key, inner)
        else:
            draft.add_entry('joint_limits', inner_key, inner)


def _take_planning_pipelines(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    names = node.get('pipeline_names')
    draft.add_entry('planning_parameters', key, names if names is not None else node)
    default = node.get('default_planning_pipeline')
    if default is not None:
        draft.add_entry('planning_parameters', 'default_planning_pipeline', default)


def _take_of_ompl(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    draft.add_entry('pipelines', OMPL, empty_node(node.place).with_value({key: node}))


def _take_gazebo_ros_control(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    """Take Gazebo's servo gains, the ones that its hardware really reads."""
    gains = node.get('pid_gains')
    if gains is not None and gains.is_mapping:
        servo = empty_node(node.place).with_value({'gains': gains})
        draft.add_entry('simulation', 'servo', servo)


def _take_control_loop(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    rate = node.get('loop_hz')
    if rate is not None:
        draft.add_entry('controller_manager', 'update_rate', rate)
    threshold = node.get('cycle_time_error_threshold')
    if threshold is not None:
        draft.problems.append(Problem(
            "'cycle_time_error_threshold' is not used here: late ticks are counted and reported",
            threshold.place, severity=Severity.INFO))


def _take_sim_hw_interface(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    group, pose = _plain(node, 'joint_model_group'), _plain(node, 'joint_model_group_pose')
    if not group or not pose or group in _PLACEHOLDERS or pose in _PLACEHOLDERS:
        draft.problems.append(Problem(
            f"'{key}' is not used here: it holds the placeholders of the setup assistant",
            node.place, severity=Severity.INFO))
        return
    state = node_of(f'{group}/{pose}', node.entries['joint_model_group_pose'].where)
    draft.add_entry('simulation', 'initial_state', state)


def _take_planning_parameters(draft: ConfigDraft, key: str, node: YamlNode) -> None:
    for inner_key, inner in node.entries.items():
        draft.add_entry('planning_parameters', inner_key, inner)


def _plain(node: YamlNode, key: str) -> object:
    inner = node.get(key)
    return inner.plain() if inner is not None else None


#: Key -> what takes its value; every key that means the same in any file.
BLOCKS: Mapping[str, Take] = {
    **{key: _entry('trajectory_execution') for key in KEYS_BESIDE},
    **{key: _entry('planning_parameters') for key in known_keys(PlanningParameters)},
    **dict.fromkeys(('jiggle_fraction', 'start_state_max_bounds_error', 'planning_seed'),
                    _take_of_ompl),
    'trajectory_execution': _whole('trajectory_execution'),
    'robot_description_kinematics': _whole('kinematics'),
    'robot_description_planning': _take_robot_description_planning,
    'joint_limits': _entry('joint_limits'),
    'default_velocity_scaling_factor': _entry('joint_limits'),
    'default_acceleration_scaling_factor': _entry('joint_limits'),
    'controller_list': _take_controller_list,
    _MOVEIT_MANAGER: _take_moveit_manager,
    'planning_pipelines': _take_planning_pipelines,
    'planning_scene_monitor': _take_planning_parameters,
    'plan_execution': _take_planning_parameters,
    'gazebo_ros_control': _take_gazebo_ros_control,
    'generic_hw_control_loop': _take_control_loop,
    'moveit_sim_hw_interface': _take_sim_hw_interface,
    'initial_positions': lambda draft, key, node: draft.add_entry('simulation', key, node),
}
