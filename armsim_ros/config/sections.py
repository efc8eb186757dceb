# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the neutral form to checked blocks of settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from armsim_ros.config.base import AnySettings, drop_unused, known_keys, read_settings
from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.controllers.controller_settings import (
    BROADCASTER,
    ControllerSettings,
    read_controller,
)
from armsim_ros.config.draft import ConfigDraft, empty_node
from armsim_ros.config.kinematics import (
    JointLimitsSettings,
    KinematicsSettings,
    UNUSED_KINEMATICS_KEYS,
    UNUSED_LIMIT_KEYS,
)
from armsim_ros.config.ompl_planning import (
    PipelineSettings,
    PlanningParameters,
    RENAMED_PIPELINE_KEYS,
    UNUSED_PIPELINE_KEYS,
)
from armsim_ros.config.pipeline_defaults import (
    default_pipeline,
    DEFAULT_PIPELINES,
    OMPL,
    OMPL_PLUGIN,
    PILZ,
)
from armsim_ros.config.servo import ServoNodeSettings, UNUSED_SERVO_KEYS
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.trajectory_execution import (
    MoveItControllerSettings,
    NEEDED_KEYS,
    TrajectoryExecutionSettings,
    UNUSED_EXECUTION_KEYS,
    UNUSED_MOVEIT_CONTROLLER_KEYS,
)
from armsim_ros.config.yaml_node import node_of, YamlNode
from armsim_ros.errors import ignored, nearest, Problem, Severity

#: Parameters of the manager that others read -> why they have no effect here.
UNUSED_MANAGER_KEYS = {
    'robot_description': 'the URDF file is read',
    'use_sim_time': 'it is set once for all nodes of a program',
    'hardware_components_not_used': '',
    'cpu_affinity': '',
    'thread_priority': "simulation.yaml's pace has the priority",
    'lock_memory': '',
    'hardware_synchronization': 'simulated hardware is always in step',
    'handle_exceptions': 'a controller that raises is always deactivated',
    'qos_overrides': '',
}
#: Thresholds of diagnostics that have no effect, as the loop alone is measured.
_UNUSED_THRESHOLDS = tuple(('diagnostics', 'threshold', *path) for path in (
    ('controllers',), ('hardware_components',),
    ('controller_manager', 'periodicity', 'standard_deviation')))
#: Upstream's defaults of parameters without effect; other values are reported at the start.
_DEFAULTS_WITHOUT_EFFECT: Mapping[str, Any] = {
    'handle_exceptions': True,
    'lock_memory': False,
    'thread_priority': 50,
    'cpu_affinity': None,
    'hardware_synchronization': {
        'expect_blocking_read_write': False, 'minimum_cycle_time': 0.0001},
}


def read_sections(draft: ConfigDraft) -> dict[str, Any]:
    """
    Check every block of a draft.

    Of a published package only the broadcaster and the controllers of move_group start, unless
    a list names others.

    :returns: field of RobotSettings -> value; a block with errors has its defaults, of a
        published file the values with errors; the errors are among the draft's problems.
    """
    simulation = _checked(draft, draft.section('simulation'), SimulationSettings, 'simulation',
                          tolerant=False)
    controllers = _controllers(draft)
    spawn = _spawn(draft, controllers)
    moveit = _moveit_controllers(draft)
    pipelines = _pipelines(draft)
    return {
        'simulation': simulation,
        'controllers': controllers,
        'spawn': spawn,
        'controller_manager': _controller_manager(draft, simulation, controllers),
        'joint_limits': _joint_limits(draft),
        'kinematics': _kinematics(draft),
        'pipelines': pipelines,
        'moveit_controllers': moveit if not draft.published else _with_default(moveit, spawn),
        'trajectory_execution': _checked(
            draft, draft.section('trajectory_execution'), TrajectoryExecutionSettings,
            'trajectory_execution', UNUSED_EXECUTION_KEYS),
        'planning_parameters': _planning_parameters(draft, pipelines),
        'servo': _servo(draft),
    }


def _checked(draft: ConfigDraft, node: YamlNode, kind: type[AnySettings], title: str,
             unused: Mapping[str, str] | None = None, *, tolerant: bool = True) -> AnySettings:
    checked = read_settings(kind, node, draft.problems, title=title, unused=unused,
                            tolerant=tolerant, published=draft.published)
    return checked if checked is not None else kind()


def _controller_manager(draft: ConfigDraft, simulation: SimulationSettings,
                        controllers: tuple[ControllerSettings, ...]
                        ) -> ControllerManagerParameters:
    """Return the manager's settings; without an update_rate it is the rate of the physics."""
    node = _without_strays(draft, draft.section('controller_manager'))
    if node.get('update_rate') is None:
        rate = node_of(round(1.0 / simulation.timestep), node.where)
        node = node.with_value({**node.entries, 'update_rate': rate})
    for controller in controllers:
        entry = node.get(controller.name) or empty_node(node.where)
        kind = node_of(controller.type, node.where)
        entry = entry.with_value({**entry.entries, 'type': kind})
        node = node.with_value({**node.entries, controller.name: entry})
    node = _with_fitting_rate(draft, node, simulation.timestep)
    node = _without_effect(draft, node)
    return _checked(draft, node, ControllerManagerParameters, 'controller_manager',
                    UNUSED_MANAGER_KEYS)


def _without_effect(draft: ConfigDraft, node: YamlNode) -> YamlNode:
    """Return the manager's block without requests that have no effect; each is a warning."""
    found = {}
    for key, default in _DEFAULTS_WITHOUT_EFFECT.items():
        given = node.get(key)
        values = given.plain() if given is not None else default
        if isinstance(default, Mapping) and isinstance(values, Mapping):
            values = {**default, **values}
        if given is not None and values != default:
            found[key] = given, UNUSED_MANAGER_KEYS[key]
    for path in _UNUSED_THRESHOLDS:
        given, steps = node.find(path)
        if steps == len(path):
            found['.'.join(path)] = given, 'the rate of the whole loop is measured'
    for key, (given, reason) in found.items():
        draft.problems.append(Problem(
            f"controller_manager: '{key}' has no effect here{': ' if reason else ''}{reason}",
            given.place, severity=Severity.WARNING))
    return node.without(*(key for key in found if key in node.entries))


def _without_strays(draft: ConfigDraft, node: YamlNode) -> YamlNode:
    """Return the manager's block without what is neither a parameter nor a controller."""
    known = known_keys(ControllerManagerParameters)
    strays = [key for key, inner in node.entries.items() if key not in known
              and key not in UNUSED_MANAGER_KEYS
              and (not inner.is_mapping or (inner.get('type') is None
                   and draft.section('controllers').get(key) is None))]
    for key in strays:
        draft.problems.append(ignored(Problem(
            f"controller_manager: '{key}' is not a {ControllerManagerParameters.is_no}",
            node.entries[key].place, remedy=nearest(key, known))))
    return node.without(*strays) if strays else node


def _with_fitting_rate(draft: ConfigDraft, node: YamlNode, timestep: float) -> YamlNode:
    """
    Return the manager's block with a rate whose period is a whole number of physics steps.

    A rate that does not fit becomes the next higher rate that fits, with a warning.
    """
    rate = node.entries['update_rate']
    if isinstance(rate.value, bool) or not isinstance(rate.value, int) or rate.value < 1:
        return node
    fitting = [round(1.0 / (steps * timestep)) for steps in range(1, round(1.0 / timestep) + 1)
               if abs(round(1.0 / (steps * timestep)) * steps * timestep - 1.0) < 1e-6]
    if rate.value in fitting or not fitting:
        return node
    taken = min((candidate for candidate in fitting if candidate > rate.value), default=fitting[0])
    draft.problems.append(Problem(
        f'controllers cannot run at {rate.value} Hz with physics steps of {timestep:g} s; '
        f'they run at {taken} Hz', rate.place, '', 'to change it, give a rate that fits: '
        + ', '.join(str(rate_hz) for rate_hz in fitting[:8]), Severity.WARNING))
    return node.with_value({**node.entries, 'update_rate': node_of(taken, rate.place)})


#: Parameters that only controllers have.
_OF_CONTROLLERS = ('joint', 'joints', 'command_interfaces', 'state_interfaces')


def _controllers(draft: ConfigDraft) -> tuple[ControllerSettings, ...]:
    # In a published file a block without a type may be that of another node.
    found = [read_controller(name, node, draft.problems, published=draft.published)
             for name, node in draft.section('controllers').entries.items()
             if not draft.published or {'type', *_OF_CONTROLLERS} & set(node.entries)]
    return tuple(entry for entry in found if entry is not None)


def _spawn(draft: ConfigDraft, controllers: tuple[ControllerSettings, ...]
           ) -> tuple[str, ...]:
    """Return the controllers to activate: the listed ones, else all that fit together."""
    listed = draft.section('spawn').get('names')
    if listed is None:
        if draft.published:
            return _spawn_planned(draft, controllers)
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


def _spawn_planned(draft: ConfigDraft, controllers: tuple[ControllerSettings, ...]
                   ) -> tuple[str, ...]:
    """
    Return the broadcaster and move_group's controllers.

    Where it has none, all that can move a joint start that fit together.
    """
    entries = draft.section('moveit_controllers').entries
    planned = {name.rpartition('/')[2]: node.get('default') for name, node in entries.items()}
    names = [controller.name for controller in controllers if controller.type == BROADCASTER][:1]
    moving = [controller for controller in controllers if controller.joints]
    known = [controller.name for controller in moving if controller.name in planned]
    if known:
        # Of those that share joints the first to start wins: a controller that holds a joint by
        # itself, then move_group's default.
        return (*names, *sorted(known, key=lambda name: (
            name in _of_effort(controllers),
            (default := planned[name]) is None or default.value is not True)))
    owner: set[str] = set()
    for controller in moving:
        if not owner.intersection(controller.joints):
            names.append(controller.name)
            owner.update(controller.joints)
    return tuple(names)


def _of_effort(controllers: tuple[ControllerSettings, ...]) -> list[str]:
    """Return the controllers that command nothing but effort."""
    return [controller.name for controller in controllers
            if tuple(getattr(controller.parameters, 'command_interfaces', ())) == ('effort',)]


def _with_default(found: tuple[MoveItControllerSettings, ...], spawn: tuple[str, ...]
                  ) -> tuple[MoveItControllerSettings, ...]:
    """Return the controllers; of those that share joints the first to start is the default."""
    def start(candidate: MoveItControllerSettings) -> int:
        name = candidate.name.rpartition('/')[2]
        return spawn.index(name) if name in spawn else len(spawn)

    def preferred(candidate: MoveItControllerSettings) -> bool:
        rivals = [other for other in found
                  if start(other) != start(candidate)
                  and not set(other.joints).isdisjoint(candidate.joints)]
        first = all(start(candidate) < start(other) for other in rivals)
        return first and (candidate.default or any(other.default for other in rivals))

    return tuple(candidate.model_copy(update={'default': preferred(candidate)})
                 for candidate in found)


def _spawn_all(draft: ConfigDraft, controllers: tuple[ControllerSettings, ...]) -> tuple[str, ...]:
    """
    Return all controllers but those whose joints another controller has.

    Broadcasters come first, then those that move_group knows.
    """
    planned = [name.rpartition('/')[2] for name in draft.section('moveit_controllers').entries]
    ordered = sorted(controllers, key=lambda controller: (controller.type != BROADCASTER,
                                                   controller.name not in planned))
    names: list[str] = []
    owner: dict[str, str] = {}
    for controller in ordered:
        shared = [joint for joint in controller.joints if joint in owner]
        if shared:
            draft.problems.append(Problem(
                f"controller '{controller.name}' starts inactive: joint '{shared[0]}' belongs to "
                f"'{owner[shared[0]]}'",
                draft.section('controllers').locate([controller.name]), '',
                "name the ones to start in 'spawn' of simulation.yaml", Severity.WARNING))
            continue
        names.append(controller.name)
        owner.update(dict.fromkeys(controller.joints, controller.name))
    return tuple(names)


def _joint_limits(draft: ConfigDraft) -> JointLimitsSettings:
    node = draft.section('joint_limits')
    joints = node.get('joint_limits')
    if joints is not None and joints.is_mapping:
        used = {name: drop_unused(block, UNUSED_LIMIT_KEYS, draft.problems,
                                  title=f"limits of joint '{name}'")
                for name, block in joints.entries.items()}
        node = node.with_value({**node.entries, 'joint_limits': joints.with_value(used)})
    return _checked(draft, node, JointLimitsSettings, 'joint limits')


def _kinematics(draft: ConfigDraft) -> dict[str, KinematicsSettings]:
    return {name: _checked(draft, _with_weights(node), KinematicsSettings,
                           f"kinematics of group '{name}'", UNUSED_KINEMATICS_KEYS)
            for name, node in draft.section('kinematics').entries.items()}


def _with_weights(node: YamlNode) -> YamlNode:
    """Return a solver's block joined with those of its joints."""
    listed = node.get('joints')
    names = () if listed is None else (item.value for item in listed.items)
    blocks = {name: node.entries[name] for name in names
              if isinstance(name, str) and name in node.entries}
    if not blocks:
        return node
    rest = node.without(*blocks)
    return rest.with_value({**rest.entries, 'weights': node.with_value(blocks)})


def _pipelines(draft: ConfigDraft) -> dict[str, PipelineSettings]:
    """Return the pipelines that files describe, and those that there are without a file."""
    given = draft.section('pipelines').entries
    return {name: _pipeline(draft, name, given.get(name) or empty_node())
            for name in dict.fromkeys((*given, *DEFAULT_PIPELINES))}


def _pipeline(draft: ConfigDraft, name: str, node: YamlNode) -> PipelineSettings:
    """Return a pipeline; of a planner that is not available here the plugin alone."""
    entries = {RENAMED_PIPELINE_KEYS.get(key, key): inner for key, inner in node.entries.items()}
    if 'planning_plugins' not in entries:
        ours = {'planning_plugins': [OMPL_PLUGIN]} if 'planner_configs' in entries else {}
        plugins = (default_pipeline(name) or ours).get('planning_plugins', [])
        entries['planning_plugins'] = node_of(plugins, node.where)
    plugin = node.with_value({'planning_plugins': entries['planning_plugins']})
    title = f"planning pipeline '{name}'"
    settings = read_settings(PipelineSettings, plugin, [], title=title)
    if settings is None or settings.planner is not None:
        return _checked(draft, node.with_value(entries), PipelineSettings, title,
                        UNUSED_PIPELINE_KEYS)
    if node.entries:
        draft.problems.append(Problem(
            f'{title} is not offered: {settings.fault}', node.place, severity=Severity.INFO))
    return settings


def _planning_parameters(
    draft: ConfigDraft, pipelines: Mapping[str, PipelineSettings]
) -> PlanningParameters:
    """Return move_group's parameters; without a list, all pipelines that can plan are offered."""
    node = draft.section('planning_parameters')
    names = [name for name, each in pipelines.items() if each.planner is not None]
    names.sort(key=lambda name: name != OMPL)  # the default, as MoveItConfigsBuilder has it
    listed = node.get('planning_pipelines')
    if (listed is None or not listed.plain()) and set(names) != {OMPL, PILZ}:
        node = node.with_value({**node.entries, 'planning_pipelines': node_of(names, node.where)})
    return _checked(draft, node, PlanningParameters, 'planning_parameters')


def _servo(draft: ConfigDraft) -> ServoNodeSettings:
    node = draft.section('servo')
    block = node.get('moveit_servo')
    if block is not None and block.is_mapping:
        used = drop_unused(block, UNUSED_SERVO_KEYS, draft.problems, title='servo')
        node = node.with_value({**node.entries, 'moveit_servo': used})
    return _checked(draft, node, ServoNodeSettings, 'servo')


def _moveit_controllers(draft: ConfigDraft) -> tuple[MoveItControllerSettings, ...]:
    """Return the controllers of move_group; an entry with an error is left out."""
    found = []
    for name, node in draft.section('moveit_controllers').entries.items():
        title, problems = f"MoveIt controller '{name}'", list[Problem]()
        settings = read_settings(MoveItControllerSettings, node, problems, title=title,
                            unused=UNUSED_MOVEIT_CONTROLLER_KEYS)
        lacking = [key for key in NEEDED_KEYS if node.is_mapping and node.get(key) is None]
        if lacking:
            settings, problems = None, [Problem(
                f"{title} has no {', '.join(map(repr, lacking))}", node.place)]
        if settings is None:
            problems = [replace(each, remedy=each.remedy or 'the controller is left out')
                        for each in problems]
        draft.problems += map(ignored, problems)
        found.append(settings)
    return tuple(entry for entry in found if entry is not None)
