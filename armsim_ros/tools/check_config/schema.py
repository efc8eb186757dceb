# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""JSON Schemas of the YAML files, for editors that complete and check while typing."""

from __future__ import annotations

from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from armsim_ros.config.cell import CellSettings
from armsim_ros.config.controllers.controller_settings import PARAMETERS, ROS1_TYPES
from armsim_ros.config.joint_limits import JointLimitsSettings
from armsim_ros.config.move_group.kinematics import KinematicsSettings
from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.config.move_group.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.world import WorldSettings

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
    schema = _of(OmplSettings)
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
