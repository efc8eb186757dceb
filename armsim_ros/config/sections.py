# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the neutral form to checked blocks of settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armsim_ros.config.controller_manager import ControllerManagerParameters
from armsim_ros.config.controllers import (
    BROADCASTER,
    ControllerSettings,
    read_controller,
)
from armsim_ros.config.draft import ConfigDraft, empty_node
from armsim_ros.config.joint_limits import JointLimitsSettings, UNUSED_LIMIT_KEYS
from armsim_ros.config.kinematics import KinematicsSettings, UNUSED_KINEMATICS_KEYS
from armsim_ros.config.moveit_controllers import (
    MoveItControllerSettings,
    UNUSED_MOVEIT_CONTROLLER_KEYS,
)
from armsim_ros.config.ompl_planning import (
    OmplSettings,
    RENAMED_PIPELINE_KEYS,
    UNUSED_PIPELINE_KEYS,
)
from armsim_ros.config.planning_parameters import PlanningParameters
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.trajectory_execution import TrajectoryExecutionSettings
from armsim_ros.config.validation import AnySettings, drop_unused, read_settings
from armsim_ros.config.yaml_node import node_of, YamlNode
from armsim_ros.errors import nearest, Problem, Severity


def read_sections(draft: ConfigDraft) -> dict[str, Any]:
    """
    Check every block of a draft.

    :returns: field of RobotSettings -> value; a block with mistakes has its defaults, and the
        mistakes are among the draft's problems.
    """
    simulation = _whole(draft, 'simulation', SimulationSettings)
    controllers = _controllers(draft)
    return {
        'simulation': simulation,
        'controllers': controllers,
        'spawn': _spawn(draft, controllers),
        'controller_manager': _controller_manager(draft, simulation, controllers),
        'joint_limits': _joint_limits(draft),
        'kinematics': _kinematics(draft),
        'ompl': _ompl(draft),
        'moveit_controllers': _moveit_controllers(draft),
        'trajectory_execution': _whole(
            draft, 'trajectory_execution', TrajectoryExecutionSettings),
        'planning_parameters': _whole(draft, 'planning_parameters', PlanningParameters),
    }


def _whole(draft: ConfigDraft, section: str, kind: type[AnySettings]) -> AnySettings:
    return _checked(draft, draft.section(section), kind, section)


def _checked(draft: ConfigDraft, node: YamlNode, kind: type[AnySettings], title: str,
             unused: Mapping[str, str] | None = None) -> AnySettings:
    checked = read_settings(kind, node, draft.problems, title=title, unused=unused)
    return checked if checked is not None else kind()


def _controller_manager(draft: ConfigDraft, simulation: SimulationSettings,
                        controllers: tuple[ControllerSettings, ...]
                        ) -> ControllerManagerParameters:
    """Return the manager's settings; without an update_rate it is the rate of the physics."""
    unused = {
        'robot_description': 'the URDF file is read',
        'use_sim_time': 'the programs are told once for all nodes',
        'hardware_components_not_used': '',
        'overruns': 'late ticks are counted and reported',
        'cpu_affinity': '',
        'thread_priority': "simulation.yaml's pace has the priority",
        'lock_memory': '',
        'diagnostics': '',
        'shutdown_on_initial_state_failure': '',
        'allow_controller_activation_with_inactive_hardware': '',
        'handle_exceptions': '',
        'qos_overrides': '',
    }
    node = draft.section('controller_manager')
    if node.get('update_rate') is None:
        rate = node_of(round(1.0 / simulation.timestep), node.where)
        node = node.with_value({**node.entries, 'update_rate': rate})
    for controller in controllers:
        entry = node.get(controller.name) or empty_node(node.where)
        kind = node_of(controller.type, node.where)
        entry = entry.with_value({**entry.entries, 'type': kind})
        node = node.with_value({**node.entries, controller.name: entry})
    node = _with_fitting_rate(draft, node, simulation.timestep)
    return _checked(draft, node, ControllerManagerParameters, 'controller_manager', unused)


def _with_fitting_rate(draft: ConfigDraft, node: YamlNode, timestep: float) -> YamlNode:
    """
    Return the manager's block with a rate whose period is a whole number of physics steps.

    A rate that does not fit becomes the next higher one that does, with a warning.
    """
    rate = node.entries['update_rate']
    if isinstance(rate.value, bool) or not isinstance(rate.value, int) or rate.value < 1:
        return node
    fitting = [round(1.0 / (steps * timestep)) for steps in range(1, round(1.0 / timestep) + 1)
               if abs(round(1.0 / (steps * timestep)) * steps * timestep - 1.0) < 1e-6]
    if rate.value in fitting or not fitting:
        return node
    taken = min((one for one in fitting if one > rate.value), default=fitting[0])
    draft.problems.append(Problem(
        f'controllers cannot run at {rate.value} Hz with physics steps of {timestep:g} s; '
        f'they run at {taken} Hz', rate.place, '', 'to change it, give a rate that fits: '
        + ', '.join(str(one) for one in fitting[:8]), Severity.WARNING))
    return node.with_value({**node.entries, 'update_rate': node_of(taken, rate.place)})


def _controllers(draft: ConfigDraft) -> tuple[ControllerSettings, ...]:
    found = [read_controller(name, node, draft.problems)
             for name, node in draft.section('controllers').entries.items()]
    return tuple(one for one in found if one is not None)


def _spawn(draft: ConfigDraft, controllers: tuple[ControllerSettings, ...]) -> tuple[str, ...]:
    """Return the controllers to activate: the listed ones, else all that fit together."""
    listed = draft.section('spawn').get('names')
    if listed is None:
        return _spawn_all(draft, controllers)
    if not isinstance(listed.value, tuple):
        draft.problems.append(Problem(f"'spawn' is {listed.kind}", listed.place,
                                      'a list of controllers'))
    known = tuple(draft.section('controllers').entries)
    names: list[str] = []
    for item in listed.items:
        if item.value in known:
            names.append(str(item.value))
        else:
            draft.problems.append(Problem(
                f"controller '{item.text}' is to be spawned, but no file describes it; the others "
                'start without it', item.where, ', '.join(known),
                nearest(item.text, known), Severity.WARNING))
    return tuple(dict.fromkeys(names))


def _spawn_all(draft: ConfigDraft, controllers: tuple[ControllerSettings, ...]
               ) -> tuple[str, ...]:
    """
    Return all controllers but those whose joints another one has.

    Broadcasters come first, then those that move_group knows.
    """
    planned = [name.rpartition('/')[2] for name in draft.section('moveit_controllers').entries]
    ordered = sorted(controllers, key=lambda one: (one.type != BROADCASTER,
                                                   one.name not in planned))
    names: list[str] = []
    owner: dict[str, str] = {}
    for one in ordered:
        shared = [joint for joint in one.joints if joint in owner]
        if shared:
            draft.problems.append(Problem(
                f"controller '{one.name}' starts inactive: joint '{shared[0]}' belongs to "
                f"'{owner[shared[0]]}'", draft.section('controllers').locate([one.name]), '',
                "name the ones to start in 'spawn' of simulation.yaml", Severity.WARNING))
            continue
        names.append(one.name)
        owner.update(dict.fromkeys(one.joints, one.name))
    return tuple(names)


def _joint_limits(draft: ConfigDraft) -> JointLimitsSettings:
    node = draft.section('joint_limits')
    joints = node.get('joint_limits')
    if joints is not None and joints.is_mapping:
        clean = {name: drop_unused(block, UNUSED_LIMIT_KEYS, draft.problems,
                                   title=f"limits of joint '{name}'")
                 for name, block in joints.entries.items()}
        node = node.with_value({**node.entries, 'joint_limits': joints.with_value(clean)})
    return _checked(draft, node, JointLimitsSettings, 'joint limits')


def _kinematics(draft: ConfigDraft) -> dict[str, KinematicsSettings]:
    return {name: _checked(draft, node, KinematicsSettings, f"kinematics of group '{name}'",
                           UNUSED_KINEMATICS_KEYS)
            for name, node in draft.section('kinematics').entries.items()}


def _ompl(draft: ConfigDraft) -> OmplSettings:
    node = draft.section('ompl')
    named = {RENAMED_PIPELINE_KEYS.get(key, key): inner for key, inner in node.entries.items()}
    return _checked(draft, node.with_value(named), OmplSettings, 'planning pipeline',
                    UNUSED_PIPELINE_KEYS)


def _moveit_controllers(draft: ConfigDraft) -> tuple[MoveItControllerSettings, ...]:
    found = []
    for name, node in draft.section('moveit_controllers').entries.items():
        title = f"MoveIt controller '{name}'"
        if node.is_mapping and node.get('action_ns') is None:
            draft.problems.append(Problem(
                f"{title} has no 'action_ns'; the usual name of its type is taken", node.place,
                severity=Severity.WARNING))
        found.append(read_settings(MoveItControllerSettings, node, draft.problems, title=title,
                                   unused=UNUSED_MOVEIT_CONTROLLER_KEYS))
    return tuple(one for one in found if one is not None)
