# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of move_group and moveit_simple_controller_manager: of its files, or changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import create_model, ValidationError
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.ompl_planning import (
    offered_pipelines,
    PipelineSettings,
    Planner,
    PlanningParameters,
)
from armsim_ros.config.pipeline_defaults import default_pipeline, PILZ
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.trajectory_execution import (
    KEYS_BESIDE,
    TrajectoryExecutionSettings,
    UNUSED_EXECUTION_KEYS,
)
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.parameters import parameters_by_prefix, reason, SettingsParameters
from armsim_ros.nodes.polling_node import GuardedNode

_EXECUTION = 'trajectory_execution.'
#: Read at the start.
_AT_THE_START = tuple(sorted(KEYS_BESIDE - {'allow_trajectory_execution'}))


class PlanExecution(Settings):
    """Parameters of ``plan_execution``."""

    record_trajectory_state_frequency: float = parameter(
        0.0, 'states a second in executed_trajectory; 0 leaves it empty [Hz]', ge=0.0, le=1000.0)


class LiveParameters(Settings):
    """Parameters that take effect with the next request."""

    allow_trajectory_execution: bool = parameter(
        True, 'whether execute_trajectory and move_action move the robot')
    plan_execution: PlanExecution
    planning_seed: int = parameter(
        -1, 'a number >= 0 makes every plan repeatable for the same scene, state and request')
    monitor_dynamics: bool = parameter(False, 'take velocities from the joint states')


class MoveGroupParameters:
    """
    Declares the live parameters and takes over their changes.

    :raises ConfigError: a value from ``--ros-args`` is wrong.
    """

    def __init__(self, context: Context) -> None:
        """Declare; values from ``--ros-args`` win over the robot's files."""
        self._context = context
        planning = context.planning_parameters
        execution = _at_the_start(context)
        context.execution_settings = execution
        live = LiveParameters(
            allow_trajectory_execution=execution.allow_trajectory_execution,
            plan_execution=PlanExecution(
                record_trajectory_state_frequency=planning.record_trajectory_state_frequency),
            planning_seed=context.planner.settings.seed,
            monitor_dynamics=planning.monitor_dynamics)
        try:
            self._live = SettingsParameters(context.node, live, self._changed)
        except ValidationError as error:
            raise ConfigError(Problem(f'parameter of move_group: {reason(error)}')) from None
        except ParameterException as error:
            raise ConfigError(Problem(f'parameter of move_group: {error}')) from None
        self._changed(self._live.settings)

    def warn_from_now_on(self) -> None:
        """Warn of parameters of other nodes that are set here, but not of their declaration."""
        self._context.node.add_post_set_parameters_callback(self._warn)

    def _warn(self, parameters: Sequence[Parameter]) -> None:
        """Warn of parameters that take effect on another node."""
        for changed in parameters:
            if changed.name.startswith(_EXECUTION):
                self._context.logger.warning(
                    f"parameter '{changed.name}' has no effect on this node while it runs; set it "
                    'on moveit_simple_controller_manager')

    def _changed(self, live: LiveParameters) -> None:
        context = self._context
        context.execution_settings = context.execution_settings.model_copy(update={
            'allow_trajectory_execution': live.allow_trajectory_execution})
        context.record_frequency = live.plan_execution.record_trajectory_state_frequency
        context.states.monitor_dynamics = live.monitor_dynamics
        context.planner.settings = replace(context.planner.settings, seed=live.planning_seed)


def _at_the_start(context: Context) -> TrajectoryExecutionSettings:
    """Return the settings of execution: those of the files, and of ``--ros-args`` beside them."""
    settings, node = context.settings.trajectory_execution, context.node
    given = {name: node.get_parameter(name).value for name in _AT_THE_START
             if node.has_parameter(name)}
    try:
        return TrajectoryExecutionSettings.model_validate({**settings.model_dump(), **given})
    except ValidationError as error:
        raise ConfigError(Problem(f'parameter of move_group: {reason(error)}')) from None


#: Fields of PlanningParameters that are in their own group -> the parameter's name.
NAMES = {
    'default_robot_padding': 'robot_description_planning.default_robot_padding',
    'default_robot_scale': 'robot_description_planning.default_robot_scale',
    'default_object_padding': 'robot_description_planning.default_object_padding',
    'default_attached_padding': 'robot_description_planning.default_attached_padding',
    'record_trajectory_state_frequency': 'plan_execution.record_trajectory_state_frequency',
}
_CARTESIAN_LIMITS = 'robot_description_planning.cartesian_limits'
#: A launch argument of ROS 1 and the four parameters that it sets.
_MONITORED = 'publish_monitored_planning_scene'
_PUBLISHED = (
    'publish_planning_scene', 'publish_geometry_updates', 'publish_state_updates',
    'publish_transforms_updates')
_PIPELINE_NAMES = 'planning_pipelines.pipeline_names'
_DEFAULT_PIPELINE = 'default_planning_pipeline'
_DESCRIPTIONS = ('robot_description', 'robot_description_semantic')


def planning_parameters(node: Node, settings: RobotSettings) -> PlanningParameters:
    """
    Return the values of the robot's files, overridden by those of ``--ros-args``.

    A default pipeline that is not available is replaced, in the node's parameter too: clients
    read it.

    :raises ConfigError: a value from ``--ros-args`` is wrong.
    """
    files = settings.planning_parameters
    values = {name: getattr(files, name) for name in type(files).model_fields}
    for name in values:
        parameter = NAMES.get(name, name)
        if node.has_parameter(parameter):
            values[name] = node.get_parameter(parameter).value
    if node.has_parameter(_MONITORED):
        shown = bool(node.get_parameter(_MONITORED).value)
        values.update({name: shown for name in _PUBLISHED if not node.has_parameter(name)})
    tool = parameters_by_prefix(node, _CARTESIAN_LIMITS)
    values['cartesian_limits'] = {
        **files.cartesian_limits.model_dump(),
        **{name: parameter.value for name, parameter in tool.items()},
    }
    if node.has_parameter(_PIPELINE_NAMES):
        values['planning_pipelines'] = node.get_parameter(_PIPELINE_NAMES).value
    try:
        found = PlanningParameters(**values)
    except ValidationError as error:
        raise ConfigError(Problem(f'parameter of move_group: {reason(error)}')) from None
    found = offered_pipelines(found, settings.pipelines, node.get_logger())
    if node.has_parameter(_DEFAULT_PIPELINE):
        node.set_parameters([Parameter(
            _DEFAULT_PIPELINE, value=found.default_planning_pipeline)])
    return found


def declare_fixed(
    node: Node, settings: RobotSettings, planning: PlanningParameters, robot: RobotModel
) -> None:
    """Declare what clients and tools look up, unless it is declared already."""
    for name, value in _values(node, settings, planning, robot):
        if node.has_parameter(name):
            if name in _DESCRIPTIONS and node.get_parameter(name).value != value:
                node.get_logger().warning(
                    f"parameter '{name}' is not used: the robot comes from its files; name them "
                    'with robot:=, urdf:=, srdf:=')
            continue
        if isinstance(value, (tuple, list)):
            value = [str(item) for item in value]
        if isinstance(value, (bool, int, float, str)) or value:
            node.declare_parameter(
                name, value, ParameterDescriptor(read_only=True, dynamic_typing=True))
    # Those of trajectory execution can be set, as on upstream's node, and have no effect there.
    inside = settings.trajectory_execution.model_dump(exclude=set(KEYS_BESIDE))
    for name, value in _flat('trajectory_execution', inside):
        if not node.has_parameter(name):
            node.declare_parameter(name, value)


def _values(
    node: Node, settings: RobotSettings, planning: PlanningParameters, robot: RobotModel
) -> Iterator[tuple[str, Any]]:
    yield 'robot_description', robot.urdf
    yield 'robot_description_semantic', robot.srdf
    # A name may not be that of a value and begin that of others: no YAML file can hold both.
    nested = node.has_parameter(_PIPELINE_NAMES)
    apart = {'cartesian_limits', *(['planning_pipelines'] if nested else [])}
    for name in set(type(planning).model_fields) - apart:
        value = getattr(planning, name)
        joined = name in ('capabilities', 'disable_capabilities')
        yield NAMES.get(name, name), ' '.join(value) if joined else value
    yield from _flat(_CARTESIAN_LIMITS, planning.cartesian_limits.model_dump())
    yield from _robot(settings)
    for pipeline in planning.planning_pipelines:
        yield from _flat(pipeline, _pipeline(settings.pipelines[pipeline]))
    execution = settings.trajectory_execution
    yield from ((name, getattr(execution, name)) for name in sorted(KEYS_BESIDE))
    yield from controller_parameters(settings)
    options = 'planning_scene_monitor_options'
    yield f'{options}.name', 'planning_scene_monitor'
    yield f'{options}.robot_description', 'robot_description'
    yield f'{options}.wait_for_initial_state_timeout', 0.0


def controller_parameters(settings: RobotSettings) -> Iterator[tuple[str, Any]]:
    """Yield name and value of the parameters of the controllers."""
    manager, controllers = 'moveit_simple_controller_manager', settings.moveit_controllers
    yield f'{manager}.controller_names', [each.name for each in controllers]
    for each in controllers:
        for name, value in _flat(f'{manager}.{each.name}', each.model_dump(exclude={'name'})):
            yield name, list(value) if isinstance(value, tuple) else value


def _robot(settings: RobotSettings) -> Iterator[tuple[str, Any]]:
    planning = 'robot_description_planning'
    yield f'{planning}.shape_transform_cache_lookup_wait_time', 0.05
    limits = settings.joint_limits
    for kind in ('velocity', 'acceleration'):
        name = f'default_{kind}_scaling_factor'
        yield f'{planning}.{name}', getattr(limits, name)
    for joint, each in limits.joint_limits.items():
        yield from _flat(f'{planning}.joint_limits.{joint}', each.model_dump())
    for group, kinematics in settings.kinematics.items():
        block = kinematics.model_dump()
        yield from _flat(f'robot_description_kinematics.{group}', block | block.pop('weights'))


def _pipeline(settings: PipelineSettings) -> dict[str, Any]:
    """Return the parameters in the namespace of a pipeline."""
    common = {
        'planning_plugins': settings.planning_plugins,
        'request_adapters': settings.used_request_adapters,
        'response_adapters': settings.used_response_adapters,
        'progress_topic': settings.progress_topic,
        'display_path_topic': settings.display_path_topic,
        'display_contacts_topic': settings.display_contacts_topic,
        'fix_start_state': settings.fix_start_state,
        'default_workspace_bounds': settings.default_workspace_bounds,
        'start_state_max_bounds_error': settings.start_state_max_bounds_error,
        'jiggle_fraction': settings.jiggle_fraction,
        'totg.path_tolerance': settings.path_tolerance,
        'totg.resample_dt': settings.resample_dt,
        'totg.min_angle_change': settings.min_angle_change,
    }
    if settings.planner is Planner.PILZ:
        defaults = default_pipeline(PILZ)
        return {**common, **{key: defaults[key] for key in (
            'default_planner_config', 'capabilities')}}
    planners = {name: {'type': config.type, **config.parameters}
                for name, config in settings.planner_configs.items()}
    groups = {group: each.model_dump() for group, each in settings.groups.items()}
    return {**common, 'planner_configs': planners, **groups}


def _flat(prefix: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(f'{prefix}.{key}', value)
        elif value is not None:
            yield f'{prefix}.{key}', value


NAME = 'moveit_simple_controller_manager'
GROUP = 'trajectory_execution'
_JOINTS = 'allowed_start_tolerance_joints'
_OF_JOINTS = f'{GROUP}.{_JOINTS}.'
#: Read at the start, never at run time.
_FIXED = ('control_multi_dof_joint_variables',)

_FIELDS = TrajectoryExecutionSettings.model_fields
_OWN_FIELDS: dict[str, Any] = {
    name: (info.annotation, info) for name, info in _FIELDS.items()
    if name not in KEYS_BESIDE and name not in _FIXED}
_INSIDE: Any = create_model('TrajectoryExecutionParameters', __base__=Settings, **_OWN_FIELDS)


class ExecutionParameters(Settings):
    """The parameters of ``trajectory_execution``."""

    trajectory_execution: _INSIDE


class ControllerManagerNode:
    """
    The node whose parameters trajectory execution follows at run time.

    :param context: the parts of move_group; its node's parameters of the same names are values
        for the start.
    :raises ConfigError: a parameter is wrong.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        settings, given = context.settings.trajectory_execution, _given(context.node)
        try:
            start = settings.model_validate({**settings.model_dump(), **given})
        except ValidationError as error:
            raise ConfigError(Problem(f'parameter {GROUP}: {reason(error)}')) from None
        self._start = start
        self.node = node = GuardedNode(
            NAME, context=context.node.context, namespace=context.node.get_namespace(),
            use_global_arguments=False, enable_rosout=False, allow_undeclared_parameters=True)
        inside = {name: getattr(start, name) for name in _INSIDE.model_fields}
        tolerances = inside.pop(_JOINTS)
        self._live = SettingsParameters(
            node, ExecutionParameters(trajectory_execution=_INSIDE(**inside)), self._changed)
        for joint, tolerance in tolerances.items():
            node.declare_parameter(f'{_OF_JOINTS}{joint}', float(tolerance))
        for name in _FIXED:
            node.declare_parameter(f'{GROUP}.{name}', getattr(start, name), _read_only())
        for name, value in controller_parameters(context.settings):
            if value != []:
                node.declare_parameter(name, value, _read_only())
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._note_tolerances)
        self._changed(self._live.settings)

    def _check(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Refuse unknown parameters, and tolerances of joints that are none."""
        known, problems = self._context.robot.joints, []
        for changed in parameters:
            if changed.name.startswith(_OF_JOINTS):
                joint = changed.name[len(_OF_JOINTS):]
                usable = type(changed.value) in (int, float)
                if joint not in known:
                    problems.append(f"{changed.name}: the robot has no joint '{joint}'")
                elif not usable or changed.value < 0.0:
                    problems.append(
                        f'{changed.name} is {changed.value}; allowed: a number from 0 up')
            elif not self.node.has_parameter(changed.name):
                problems.append(f"'{changed.name}' is not known; allowed: {GROUP}.*")
        return SetParametersResult(successful=not problems, reason='; '.join(problems))

    def _note_tolerances(self, parameters: Sequence[Parameter]) -> None:
        if any(parameter.name.startswith(_OF_JOINTS) for parameter in parameters):
            self._changed(self._live.settings)

    def _changed(self, live: ExecutionParameters) -> None:
        joints = parameters_by_prefix(self.node, _OF_JOINTS.rstrip('.'))
        self._context.execution_settings = self._context.execution_settings.model_copy(update={
            **live.trajectory_execution.model_dump(exclude={_JOINTS}),
            _JOINTS: {joint: float(parameter.value) for joint, parameter in joints.items()},
            **{name: getattr(self._start, name) for name in _FIXED},
        })


def _given(node: Node) -> dict[str, Any]:
    """Return what ``--ros-args`` gives move_group for the start."""
    values: dict[str, Any] = {}
    for name, given in parameters_by_prefix(node, GROUP).items():
        field, _, joint = name.partition('.')
        if field == _JOINTS and joint:
            values.setdefault(_JOINTS, {})[joint] = given.value
        elif field in _FIELDS and field not in UNUSED_EXECUTION_KEYS:
            values[field] = given.value
    return values


def _read_only() -> ParameterDescriptor:
    """Return a descriptor of its own; rclpy writes the parameter's name into it."""
    return ParameterDescriptor(read_only=True, dynamic_typing=True)
