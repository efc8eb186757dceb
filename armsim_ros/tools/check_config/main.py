# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program check_config: what it reports of a robot's files, and its exit status."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import json
import os
from pathlib import Path
import sys
from typing import Any

from pydantic import TypeAdapter

from armsim_ros.cli.arguments import (
    argparse_words,
    argument_table,
    parse_arguments,
    split_ros_args,
)
from armsim_ros.config.cell import CellSettings
from armsim_ros.config.controllers.controller_settings import PARAMETERS, ROS1_TYPES
from armsim_ros.config.kinematics import JointLimitsSettings, KinematicsSettings
from armsim_ros.config.ompl_planning import PipelineSettings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.config.world import WorldSettings
from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Location, PlanningError, Problem, Severity
from armsim_ros.execution.controller_selection import select_controllers
from armsim_ros.tools.check_config.robot_check import RobotCheck

#: Arguments of this program alone; all others are those of bringup.
_OWN = ('strict', 'keys', 'schema')


def main(argv: Sequence[str] | None = None) -> int:
    """
    Check a robot's folder, or single files.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 where all is well, 1 for warnings, 2 for errors.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    launch_words = [word for word in words
                    if ':=' in word and word.partition(':=')[0].strip('-') not in _OWN]
    options = _parser().parse_args(argparse_words(
        word for word in words if word not in launch_words))
    if options.schema is not None:
        for path in write_schemas(options.schema):
            print(path)
        return 0
    # Slow to import, and not needed for --help and --schema.
    from armsim_ros.cli.settings import survey_options
    from armsim_ros.tools.check_config.robot_check import check_file, check_robot

    given = [f'{entry.name}:={getattr(options, entry.name)}' for entry in argument_table()
             if getattr(options, entry.name) is not None]
    arguments = parse_arguments([*launch_words, *given], xacro=True)
    sources = survey_options(arguments)
    is_named = any(word.startswith('robot:=') for word in (*launch_words, *given))
    targets = [*options.targets, *([arguments.robot] if is_named else [])] or [arguments.robot]
    status = 0
    for target in targets:
        path = Path(target).expanduser()
        check = check_file(path) if path.is_file() else check_robot(
            target, strict=options.strict, **sources)
        try:
            for line in report_lines(check, list_keys=options.keys):
                print(line)
            sys.stdout.flush()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = max(status, exit_status(check))
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim check_config',
        description="Read a robot's files, start nothing, and report every error with file and "
                    'line, how each key is used, and the controllers of each planning group.',
        epilog='exit status: 0 no findings, 1 warnings, 2 errors')
    parser.add_argument('targets', nargs='*', metavar='DIR|NAME|FILE',
                        help="a robot's folder or name, or single YAML, launch and URDF files")
    for entry in argument_table():
        option = parser.add_argument(
            f"--{entry.name.replace('_', '-')}", help=entry.metadata['description'],
            metavar=entry.metadata['placeholder'])
        if isinstance(entry.default, bool):
            option.nargs, option.const = '?', 'true'
    parser.add_argument('--strict', action='store_true',
                        help='report what upstream silently ignores as errors')
    parser.add_argument('--keys', action='store_true',
                        help='list every key and how it is used')
    parser.add_argument('--schema', type=Path, metavar='DIR',
                        help='only write JSON Schemas of all files, for editors')
    return parser


USED, CHANGED, UNUSED, WRONG = 'used', 'changed meaning', 'not used here', 'wrong'
STATES = (USED, CHANGED, UNUSED, WRONG)

_STATE_OF = {Severity.ERROR: WRONG, Severity.CHANGED: CHANGED, Severity.INFO: UNUSED}


@dataclass(frozen=True)
class KeyState:
    """
    A key with a value.

    :param path: the keys that lead to it, joined by dots.
    :param state: one of ``STATES``.
    """

    path: str
    value: str
    where: Location
    state: str


def key_table(files: Iterable[Path], problems: Iterable[Problem]) -> list[KeyState]:
    """
    Return every key of the files that can be read.

    :param problems: all that was found; their places determine the keys' states.
    """
    states = {problem.where: _STATE_OF[problem.severity] for problem in problems
              if problem.where is not None and problem.severity in _STATE_OF}
    table: list[KeyState] = []
    for file in files:
        try:
            root = read_yaml_file(file)
        except ConfigError:
            continue
        table += _leaves(root, (), USED, states)
    return table


def _leaves(node: YamlNode, path: tuple[str, ...], state: str,
            states: dict[Location, str]) -> Iterator[KeyState]:
    if node.key_where is not None:
        state = states.get(node.key_where, state)
    if node.entries:
        for key, inner in node.entries.items():
            yield from _leaves(inner, (*path, key), state, states)
        return
    if any(item.is_mapping for item in node.items):
        for number, item in enumerate(node.items):
            yield from _leaves(item, (*path[:-1], f'{path[-1]}[{number}]'), state, states)
        return
    inside = [states[item.where] for item in (node, *node.items) if item.where in states]
    text = f"[{', '.join(item.text for item in node.items)}]" if node.items else node.text
    yield KeyState('.'.join(path), text, node.place, inside[0] if inside else state)


_TITLES = {
    Severity.ERROR: 'errors',
    Severity.WARNING: 'warnings',
    Severity.CHANGED: 'interpreted differently here',
    Severity.INFO: 'not used here',
}


def report_lines(check: RobotCheck, *, list_keys: bool = False) -> Iterator[str]:
    """
    Yield the lines of the report.

    :param list_keys: whether to list every key of the YAML files with what it does here.
    """
    settings = check.settings
    if settings is not None:
        yield from _file_lines(settings, check.robots)
    for severity, title in _TITLES.items():
        found = check.of(severity)
        if found:
            yield f'{title} ({len(found)})'
            yield from (f'  {problem}' for problem in found)
    if settings is not None:
        files = [*settings.files, *(file for robot in check.robots for file in robot.files)]
        table = key_table(dict.fromkeys(files), check.problems)
        counts = Counter(row.state for row in table)
        yield 'keys: ' + ', '.join(f'{counts[state]} {state}' for state in STATES)
        if list_keys:
            yield from _key_lines(table)
    yield from _coverage(check)
    errors, warnings = len(check.of(Severity.ERROR)), len(check.of(Severity.WARNING))
    yield (f'result: {_count(errors, "error")}, {_count(warnings, "warning")}'
           if errors or warnings else 'result: all is well')


def exit_status(check: RobotCheck) -> int:
    """Return 0 where all is well, 1 for warnings, 2 for errors."""
    if check.of(Severity.ERROR):
        return 2
    return 1 if check.of(Severity.WARNING) else 0


def _file_lines(settings: RobotSettings, robots: Sequence[RobotSettings]) -> Iterator[str]:
    """Yield the files of a robot; of a cell, first its own and then those of each robot."""
    if robots:
        yield f"cell '{settings.name}'"
        yield f'  robots  {settings.urdf_file}'
        of_robots = {file for robot in robots for file in robot.files}
        if settings.srdf_file is not None:
            yield f'  SRDF  {settings.srdf_file}'
        yield from (f'  YAML  {file}' for file in settings.files if file not in of_robots)
    for shown in robots or (settings,):
        yield f"robot '{shown.name}'"
        yield f'  URDF  {shown.urdf_file}'
        yield f"  SRDF  {shown.srdf_file or 'none: no planning groups'}"
        yield from (f'  YAML  {file}' for file in shown.files)


def _key_lines(table: list[KeyState]) -> Iterator[str]:
    width = max((len(row.state) for row in table), default=0)
    for row in table:
        value = row.value if len(row.value) <= 40 else row.value[:37] + '...'
        yield f'  {row.state:<{width}}  {row.where}: {row.path}: {value}'


def _coverage(check: RobotCheck) -> Iterator[str]:
    settings, model = check.settings, check.model
    if settings is None or model is None or not model.semantic.groups:
        return
    yield 'planning groups and the controllers that move them'
    for name, group in model.semantic.groups.items():
        try:
            chosen = select_controllers(
                model.controlled_joints(name), settings.moveit_controllers)
            movers = ', '.join(controller.name for controller in chosen)
        except PlanningError:
            movers = 'no set of controllers: it can be planned for, not executed'
        yield f"  {name} ({', '.join(group.active_joints)}): {movers}"


def _count(number: int, what: str) -> str:
    return f'{number} {what}' + ('' if number == 1 else 's')


_DRAFT = 'https://json-schema.org/draft/2020-12/schema'


def schemas() -> dict[str, dict[str, Any]]:
    """Return file name -> JSON Schema of the files in the layout of ROS 1."""
    execution = _of(TrajectoryExecutionSettings)
    listed = _of(MoveItControllerSettings)
    simulation = _of(SimulationSettings)
    simulation['properties']['spawn'] = {
        'type': 'array', 'items': {'type': 'string'},
        'description': 'controllers to activate at the start; all that fit together if absent'}
    return {
        'joint_limits.schema.json': _of(JointLimitsSettings),
        'kinematics.schema.json': _of(dict[str, KinematicsSettings]),
        'ompl_planning.schema.json': _planners(),
        'robots.schema.json': _of(CellSettings),
        'simulation.schema.json': simulation,
        'world.schema.json': _of(WorldSettings),
        'trajectory_execution.schema.json': _object(
            {'trajectory_execution': execution}, execution.pop('$defs', {}), closed=False),
        'moveit_controllers.schema.json': _object(
            {'controller_manager_ns': {'type': 'string'},
             'controller_list': {'type': 'array', 'items': listed}},
            listed.pop('$defs', {}), closed=False),
        'controllers.schema.json': _controllers(),
    }


def write_schemas(folder: Path) -> list[Path]:
    """Write all schemas to a folder and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, schema in schemas().items():
        path = folder / name
        text = json.dumps({'$schema': _DRAFT, **schema}, indent=2, ensure_ascii=False)
        path.write_text(text + '\n', encoding='utf-8')
        written.append(path)
    return written


def _planners() -> dict[str, Any]:
    """Return the schema of planner_configs and, beside it, a block per planning group."""
    schema = _of(PipelineSettings)
    config = schema['$defs']['PlannerConfig']
    del config['properties']['parameters']  # each is a key of its own
    config['additionalProperties'] = {'type': ['boolean', 'number', 'string']}
    del schema['properties']['groups']
    schema['additionalProperties'] = {'$ref': '#/$defs/OmplGroup'}
    return schema


def _controllers() -> dict[str, Any]:
    """Return the schema of ``namespace: controller: {type, ...}`` and ``controller: {...}``."""
    definitions: dict[str, Any] = {}
    kinds = []
    names = {**{name: name for name in PARAMETERS},
             **{name: ros1.type for name, ros1 in ROS1_TYPES.items()}}
    for name, kind in names.items():
        block = _of(PARAMETERS[kind])
        definitions.update(block.pop('$defs', {}))
        block['properties']['type'] = {'const': name}
        block['required'] = ['type', *block.get('required', [])]
        kinds.append({'if': {'properties': {'type': {'const': name}}, 'required': ['type']},
                      'then': block})
    controller = {'type': 'object', 'required': ['type'], 'allOf': kinds,
                  'properties': {'type': {'enum': list(names)}}}
    definitions['controller'] = controller
    reference = {'$ref': '#/$defs/controller'}
    either = {'if': {'required': ['type']}, 'then': reference,
              'else': {'type': 'object', 'additionalProperties': reference}}
    return {'type': 'object', 'additionalProperties': either, '$defs': definitions}


def _object(properties: Mapping[str, Any], definitions: Mapping[str, Any], *,
            closed: bool) -> dict[str, Any]:
    return {'type': 'object', 'properties': dict(properties),
            'additionalProperties': not closed, '$defs': dict(definitions)}


def _of(kind: Any) -> dict[str, Any]:
    return TypeAdapter(kind).json_schema(mode='validation')
