# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From a file's keys to the neutral form: ROS 1 layout and ROS 2 layout.

ROS 1 puts a file on the parameter server as it is, under the namespaces that its own keys make.
ROS 2 has ``<node>: ros__parameters:`` (also ``/ns/node``, ``/**/node`` and ``/**``), dots in
names mean depth. The content of a block determines its kind; the file's name only helps where that
is open.
"""

from __future__ import annotations

from collections.abc import Iterator

from armsim_ros.config.base import known_keys
from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.draft import BLOCKS, ConfigDraft, empty_node, KEEP_KEYS, UNUSED_BLOCKS
from armsim_ros.config.ompl_planning import OmplGroup
from armsim_ros.config.pipeline_defaults import DEFAULT_PIPELINES, OMPL
from armsim_ros.config.servo import ServoNodeSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.config.yaml_node import is_ros2_file, merge_nodes, ROS2_KEY, split_keys, YamlNode
from armsim_ros.errors import ignored, nearest, Problem, Severity

_CONTROLLER_KEYS = frozenset(
    {'type', 'joints', 'joint', 'gains', 'constraints', 'publish_rate', 'state_publish_rate',
     'action_monitor_rate', 'stop_trajectory_duration', 'goal_time',
     'stopped_velocity_tolerance', 'command_interfaces', 'state_interfaces'})
#: Any of them makes a block a planning pipeline.
PIPELINE_KEYS = frozenset({'planner_configs', 'planning_plugins', 'planning_plugin'})
#: Pipelines whose files, such as chomp_planning.yaml, need none of these keys.
_TAKEN_BY_NAME = frozenset(DEFAULT_PIPELINES) - {OMPL}
_ANY_NODE = '**'
_ANY = ('**', '*')
_SERVO_NODES = ('servo_node', 'servo_server', 'moveit_servo')
_SERVO_KEYS = frozenset(known_keys(ServoNodeSettings))
_MANAGER_KEYS = frozenset(known_keys(ControllerManagerParameters))
_WORLD_KEYS = frozenset(known_keys(WorldSettings))
#: Blocks that may be written ``block.key``, as in the parameters that MoveIt gets.
_DOTTED = (*KEEP_KEYS, 'trajectory_execution', 'planning_scene_monitor', 'plan_execution',
           'robot_description_kinematics', 'robot_description_planning')
_NODES_OF_MOVEIT = frozenset({
    'move_group', 'moveit_simple_controller_manager', 'planning_scene_monitor', 'rviz', 'rviz2',
    _ANY_NODE,
})


class LayoutReader:
    """
    Sorts the keys of files into a draft.

    :param draft: takes what is found.
    """

    def __init__(self, draft: ConfigDraft) -> None:
        self._draft = draft

    def read(self, root: YamlNode, stem: str) -> None:
        """
        Sort a file.

        :param stem: the file's name without its ending.
        """
        name, ending, rest = stem.rpartition('_planning')
        if is_ros2_file(root):
            self._read_nodes(root)
        elif stem == 'simulation':
            self._take_simulation(root)
        elif stem == 'servo' or 'moveit_servo' in root.entries:
            self._take_servo(root)
        elif 'objects' in root.entries and set(root.entries) <= _WORLD_KEYS:
            return  # a world; simulation.yaml chooses the world
        elif PIPELINE_KEYS & set(root.entries):
            self.take_pipeline(root, name if ending and not rest else OMPL)
        elif not rest and name in _TAKEN_BY_NAME and name not in root.entries:
            self.take_pipeline(root, name)
        else:
            self._read_block(root, '')

    def _take_simulation(self, root: YamlNode) -> None:
        spawn = root.get('spawn')
        if spawn is not None:
            self._draft.add_entry('spawn', 'names', spawn)
        self._draft.add('simulation', root.without('spawn'))

    def _take_servo(self, root: YamlNode) -> None:
        """Take servo's parameters: nested in its own block, as upstream's flat files, or both."""
        root = split_keys(root, '.')
        own = {key: inner for key, inner in root.entries.items() if key in _SERVO_KEYS}
        loose = root.without(*own)
        self._draft.add('servo', root.with_value(own))
        if loose.entries:
            self._draft.add_entry('servo', 'moveit_servo', loose)

    # ROS 2 ------------------------------------------------------------------------------------

    def _read_nodes(self, root: YamlNode) -> None:
        """Read the nodes of a file: wildcards first, so that what names a node wins over them."""
        found = list(self._nodes(root, ()))
        blocks: dict[tuple[str, str], YamlNode] = {}
        for _, name, namespace, parameters in sorted(found, key=lambda each: each[0]):
            if not parameters.is_mapping:
                self._read_node(name, namespace, parameters)
                continue
            parameters = split_keys(parameters, '.', keep=KEEP_KEYS)
            known = blocks.get((name, namespace), blocks.get((name, '')))
            if known is not None:
                parameters = merge_nodes(known, parameters)[0]
                blocks.pop((name, ''), None)
            blocks[name, namespace] = parameters
        for (name, namespace), parameters in blocks.items():
            self._read_node(name, namespace, parameters)

    def _nodes(self, node: YamlNode, path: tuple[str, ...]
               ) -> Iterator[tuple[int, str, str, YamlNode]]:
        """Yield rank, name, namespace and parameters of each node that a file has a block for."""
        for key, inner in node.entries.items():
            if key == ROS2_KEY:
                parts = [part for part in '/'.join(path).split('/') if part]
                name = parts[-1] if parts else _ANY_NODE
                fixed = [part for part in parts[:-1] if part not in _ANY]
                rank = -sum(part in _ANY for part in parts)
                yield rank, _ANY_NODE if name in _ANY else name, '/'.join(fixed), inner
            elif inner.is_mapping:
                yield from self._nodes(inner, (*path, key))
            else:
                self._draft.problems.append(ignored(Problem(
                    f"key '{key}' is outside of '{ROS2_KEY}'", inner.place,
                    remedy=f"indent it below '{ROS2_KEY}:'")))

    def _read_node(self, name: str, namespace: str, parameters: YamlNode) -> None:
        if not parameters.is_mapping:
            self._draft.problems.append(Problem(
                f"'{ROS2_KEY}' of '{name}' is {parameters.kind}", parameters.place,
                'a block of keys', f"the keys below '{ROS2_KEY}:' need a deeper indentation"))
            return
        if name == 'controller_manager':
            self._draft.see_namespace(namespace, parameters.place)
            self._read_manager(parameters)
        elif name in ('simulation', 'armsim'):
            self._take_simulation(parameters)
        elif name in _SERVO_NODES:
            self._take_servo(parameters)
        elif name in _NODES_OF_MOVEIT:
            if name == _ANY_NODE:
                parameters = self._take_of_manager(parameters)
            self._read_block(parameters, '')
        else:
            self._draft.see_namespace(namespace, parameters.place)
            self._draft.add_entry('controllers', name, parameters)

    def _take_of_manager(self, parameters: YamlNode) -> YamlNode:
        """Take what of all nodes' parameters the controller manager has; return the others."""
        own = {key: inner for key, inner in parameters.entries.items() if key in _MANAGER_KEYS}
        if own:
            self._draft.add('controller_manager', parameters.with_value(own))
        return parameters.without(*own)

    def _read_manager(self, parameters: YamlNode) -> None:
        own: dict[str, YamlNode] = {}
        for key, inner in parameters.entries.items():
            kind = inner.get('type')
            if kind is None:
                own[key] = inner
                continue
            self._draft.add_entry(
                'controllers', key, empty_node(inner.place).with_value({'type': kind}))
            if inner.without('type').entries:
                own[key] = inner
        if own:
            self._draft.add('controller_manager', parameters.with_value(own))

    # ROS 1, and ROS 2 files without nodes --------------------------------------------------------

    def _read_block(self, block: YamlNode, namespace: str) -> None:
        block = _split_known_heads(block)
        if PIPELINE_KEYS & set(block.entries):
            self.take_pipeline(block, OMPL)
            return
        for key, inner in self._without_strays(block).entries.items():
            take = BLOCKS.get(key)
            if take is not None:
                take(self._draft, key, inner)
            elif key == 'simulation' and inner.is_mapping:
                self._take_simulation(inner)
            elif key in UNUSED_BLOCKS:
                self._remark_unused(key, inner)
            elif not self._take_by_content(key, inner, namespace):
                self._refuse_key(key, inner)

    def _take_by_content(self, key: str, node: YamlNode, namespace: str) -> bool:
        if not node.is_mapping:
            return False
        entries = node.entries
        if any(name.startswith('kinematics_solver') for name in entries):
            self._draft.add_entry('kinematics', key, node)
        elif _is_controller(node):
            self._draft.see_namespace(namespace, node.place)
            self._draft.add_entry('controllers', key, node)
        elif PIPELINE_KEYS & set(entries) or key in DEFAULT_PIPELINES:
            # MoveIt up to Humble has the only pipeline in the namespace of its node.
            self.take_pipeline(node, OMPL if key == 'move_group' else key)
        elif any(inner.is_mapping or name in BLOCKS for name, inner in entries.items()):
            deeper = '/'.join(part for part in (namespace, key.strip('/')) if part)
            self._read_block(node, '' if key == 'move_group' else deeper)
        else:
            return False
        return True

    def take_pipeline(self, block: YamlNode, name: str) -> None:
        """
        Take a pipeline: settings, planner_configs, and a block for each group.

        :param name: of the pipeline.
        """
        own: dict[str, YamlNode] = {}
        groups: dict[str, YamlNode] = {}
        for key, inner in block.entries.items():
            if key == 'planner_configs':
                own[key] = inner
            elif key == 'totg' and inner.is_mapping:
                own.update(inner.entries)
            elif inner.is_mapping and (set(inner.entries) & set(known_keys(OmplGroup))
                                       or not inner.entries):
                groups[key] = inner
            else:
                own[key] = inner
        if groups:
            own['groups'] = empty_node(block.where).with_value(groups)
        self._draft.add_entry('pipelines', name, block.with_value(own))

    def _remark_unused(self, key: str, node: YamlNode) -> None:
        reason = UNUSED_BLOCKS[key]
        self._draft.problems.append(Problem(
            f"'{key}' is not used here" + (f': {reason}' if reason else ''), node.place,
            severity=Severity.INFO))

    def _without_strays(self, block: YamlNode) -> YamlNode:
        """Return a block without the keys of a controller that are beside its name."""
        strays = [key for key in block.entries if key in _CONTROLLER_KEYS and key not in BLOCKS]
        if not strays:
            return block
        empty = [key for key, inner in block.entries.items()
                 if inner.value is None and key not in strays and key not in BLOCKS]
        keys = ', '.join(f"'{key}'" for key in strays)
        beside = f"beside '{empty[-1]}', which is empty" if empty else 'outside of any controller'
        self._draft.problems.append(Problem(
            f'{keys} are {beside}', block.entries[strays[0]].place,
            remedy='indent them below their controller; the indentation was probably lost in '
                   'copying'))
        return block.without(*strays, *empty)

    def _refuse_key(self, key: str, node: YamlNode) -> None:
        known = sorted({*BLOCKS, *UNUSED_BLOCKS, 'simulation', 'planner_configs'})
        remedy = nearest(key, known)
        if not remedy and node.is_mapping:
            remedy = f"if '{key}' is a controller, it needs a 'type'"
        self._draft.problems.append(ignored(Problem(
            f"key '{key}' is not known in this file", node.place,
            '' if remedy else ', '.join(known), remedy)))


def _is_controller(node: YamlNode) -> bool:
    kind = node.get('type')
    if kind is not None and not kind.is_mapping:
        return True
    plain = [key for key, inner in node.entries.items() if key in _CONTROLLER_KEYS
             and 'type' not in inner.entries]
    return len(plain) > 0


def _split_known_heads(block: YamlNode) -> YamlNode:
    """Return the block with names such as ``trajectory_execution/x`` or ``.x`` taken apart."""
    for head in _DOTTED:
        dotted = {key: node for key, node in block.entries.items() if key.startswith(f'{head}.')}
        if dotted:
            inner = block.with_value({key[len(head) + 1:]: node for key, node in dotted.items()})
            inner = inner if head in KEEP_KEYS else split_keys(inner, '.', keep=KEEP_KEYS)
            block = merge_nodes(block.without(*dotted), block.with_value({head: inner}))[0]
    heads = ('trajectory_execution/', 'move_group/', 'planning_scene_monitor/',
             'robot_description_')
    entries = block.entries
    split = {key for key in entries if '/' in key.strip('/') and key.lstrip('/').startswith(heads)}
    if not split:
        return block
    apart = split_keys(block.with_value({key: entries[key] for key in split}), '/',
                       keep=KEEP_KEYS)
    rest = {key: node for key, node in entries.items() if key not in split}
    return block.with_value({**rest, **apart.entries})
