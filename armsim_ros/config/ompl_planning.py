# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Planning pipelines (ompl_planning.yaml ...) and move_group's own planning parameters."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, Literal

from pydantic import ConfigDict, field_validator, model_validator

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.pipeline_defaults import (
    OMPL,
    OMPL_PLUGIN,
    PILZ,
    PILZ_PLUGIN,
    PILZ_RESPONSE_ADAPTERS,
    REQUEST_ADAPTERS,
    RESPONSE_ADAPTERS,
)
from armsim_ros.log import Log

PlannerValue = bool | int | float | str


class PlannerConfig(Settings):
    """A named planner configuration; what is not ``type`` goes to the planner."""

    type: str = parameter(..., "planner, such as 'geometric::RRTConnect'", min_length=1)
    parameters: dict[str, PlannerValue] = parameter({}, "the planner's own settings, by name")

    @model_validator(mode='before')
    @classmethod
    def _collect(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        own = {key: value for key, value in data.items() if key not in ('type', 'parameters')}
        collected = {'parameters': {**data.get('parameters', {}), **own}}
        return {**collected, 'type': data['type']} if 'type' in data else collected


class OmplGroup(Settings):
    """Planning of a group: which planners, and settings that hold for all of them."""

    model_config = ConfigDict(extra='allow')
    __pydantic_extra__: dict[str, PlannerValue]

    default_planner_config: str = parameter('', 'planner of a request that names none')
    planner_configs: tuple[str, ...] = parameter((), 'planners that are offered')
    projection_evaluator: str = parameter('', "'joints(a,b)' or 'link(l)'")
    longest_valid_segment_fraction: float | None = parameter(
        None, "spacing of checked states, as a share of the space's extent", gt=0.0, le=1.0)
    maximum_waypoint_distance: float | None = parameter(
        None, 'spacing of checked states [rad]; the stricter of both counts', ge=0.0)
    enforce_joint_model_state_space: bool = parameter(
        False, 'plan in joint space even where a pose space would fit')
    enforce_constrained_state_space: bool = parameter(
        False, 'plan on the manifold of the path constraints')

    @property
    def shared_parameters(self) -> dict[str, PlannerValue]:
        """The settings given for every planner of the group."""
        return self.model_dump(exclude_unset=True, include={
            'projection_evaluator', 'longest_valid_segment_fraction',
            'enforce_joint_model_state_space', 'enforce_constrained_state_space'})


class Planner(Enum):
    """A planner that there is here; the value is how it describes itself."""

    OMPL = 'OMPL'
    PILZ = 'Pilz Industrial Motion Planner'


_PLANNERS = {OMPL_PLUGIN: Planner.OMPL, PILZ_PLUGIN: Planner.PILZ}


class PipelineSettings(Settings):
    """A planning pipeline: planner, adapters, planner configurations, groups."""

    planning_plugins: tuple[str, ...] = parameter(
        (OMPL_PLUGIN,), 'planner plugin; it decides the planner, not the name')
    request_adapters: tuple[str, ...] | None = parameter(
        None, 'what happens before planning; none given: the usual ones')
    response_adapters: tuple[str, ...] | None = parameter(
        None, 'what happens after planning; none given: the usual ones')
    progress_topic: str = parameter(
        'pipeline_state', "topic of the stages of a plan; '' is nowhere")
    display_path_topic: str = parameter(
        'display_planned_path', 'where DisplayMotionPath publishes plans', min_length=1)
    display_contacts_topic: str = parameter(
        'display_contacts', "topic with contacts of refused starts, goals and paths; '' is none")
    fix_start_state: bool = parameter(False, 'bring continuous joints of the start into range')
    default_workspace_bounds: float = parameter(
        1e12, 'edge of the workspace where a request gives none [m]', gt=0.0)
    start_state_max_bounds_error: float = parameter(
        0.05, 'a start outside its limits by up to this is moved to them [rad or m]', ge=0.0)
    start_state_max_dt: float = parameter(
        0.5, 'ROS 1: time to reach a start that was moved [s]', ge=0.0)
    jiggle_fraction: float = parameter(
        0.02, 'share of the range by which a colliding start is moved', ge=0.0, le=1.0)
    max_sampling_attempts: int = parameter(100, 'tries to find a free start', ge=0)
    path_tolerance: float = parameter(0.1, 'deviation of the timed path [rad]', ge=0.0)
    resample_dt: float = parameter(0.1, 'spacing of the timed path [s]', gt=0.0)
    min_angle_change: float = parameter(0.001, 'closer points are merged [rad]', ge=0.0)
    simplify_solutions: bool = parameter(True, 'shorten the path that was found')
    interpolate: bool = parameter(True, 'add states to the path that was found')
    planning_seed: int = parameter(-1, 'not negative: the same request gives the same path', ge=-1)
    planner_configs: dict[str, PlannerConfig] = parameter({}, 'name -> planner')
    groups: dict[str, OmplGroup] = parameter({}, 'planning group -> its planners')

    @property
    def planner(self) -> Planner | None:
        """The planner of the only plugin; None where it is not available here."""
        return _PLANNERS.get(self.planning_plugins[0]) if len(self.planning_plugins) == 1 else None

    @property
    def fault(self) -> str:
        """Why it cannot plan here; '' where it can."""
        if self.planner is not None:
            return ''
        plugins = ', '.join(self.planning_plugins) or 'empty'
        return f"planning_plugins is {plugins}; known: {', '.join(_PLANNERS)}"

    @property
    def used_request_adapters(self) -> tuple[str, ...]:
        """The adapters before planning."""
        return REQUEST_ADAPTERS if self.request_adapters is None else self.request_adapters

    @property
    def used_response_adapters(self) -> tuple[str, ...]:
        """The adapters after planning."""
        if self.response_adapters is not None:
            return self.response_adapters
        return PILZ_RESPONSE_ADAPTERS if self.planner is Planner.PILZ else RESPONSE_ADAPTERS

    @field_validator('planning_plugins', 'request_adapters', 'response_adapters', mode='before')
    @classmethod
    def _one_text_or_list(cls, value: Any) -> Any:
        return tuple(value.split()) if isinstance(value, str) else value


#: Keys of a pipeline's file under other names -> the key that they mean.
RENAMED_PIPELINE_KEYS = {'planning_plugin': 'planning_plugins'}

#: Keys of a pipeline that others read -> why they have no effect here.
UNUSED_PIPELINE_KEYS = {
    'capabilities': 'move_group has it from a launch file; elsewhere give it at the top level',
    'default_planner_config': 'a request of Pilz names its command',
    'plan_request_params': 'MoveItPy reads it',
    'max_goal_samples': '',
    'max_goal_sampling_attempts': '',
    'max_state_sampling_attempts': '',
    'max_solution_segment_length': '',
    'max_planning_threads': '',
    'minimum_waypoint_count': '',
    'display_random_valid_states': '',
    'link_for_exploration_tree': '',
    'constraint_approximations_path': '',
    'default_workspace_bounds_frame': '',
}


class CartesianLimits(Settings):
    """How fast the tool may move on lines and arcs; the defaults are the usual template's."""

    max_trans_vel: float = parameter(1.0, 'largest speed [m/s]', gt=0.0)
    max_trans_acc: float = parameter(2.25, 'largest acceleration [m/s^2]', gt=0.0)
    max_trans_dec: float = parameter(
        -5.0, 'has no effect: braking has the bound of acceleration [m/s^2]')
    max_rot_vel: float = parameter(1.57, 'largest turning speed [rad/s]', gt=0.0)


class PlanningParameters(Settings):
    """move_group's parameters about descriptions, pipelines and the planning scene."""

    default_robot_padding: float = parameter(
        0.0, 'the robot is this much thicker against the world [m]', ge=0.0)
    default_robot_scale: float = parameter(1.0, 'and so many times as large', gt=0.0)
    default_object_padding: float = parameter(0.0, 'padding of world objects [m]', ge=0.0)
    default_attached_padding: float = parameter(0.0, 'padding of attached objects [m]', ge=0.0)
    planning_pipelines: tuple[str, ...] = parameter(
        (OMPL, PILZ), 'names of the pipelines')
    default_planning_pipeline: str = parameter(
        '', 'pipeline of a request that names none; the first where this is not among them')
    capabilities: tuple[str, ...] = parameter((), 'capabilities to add')
    disable_capabilities: tuple[str, ...] = parameter((), 'capabilities to leave out')
    record_trajectory_state_frequency: float = parameter(
        0.0, 'states a second in executed_trajectory; 0 leaves it empty [Hz]', ge=0.0)
    monitor_dynamics: bool = parameter(False, 'take velocities from the joint states')
    publish_planning_scene: bool = parameter(True, 'publish the planning scene')
    publish_geometry_updates: bool = parameter(True, 'with changes of objects')
    publish_state_updates: bool = parameter(True, 'with changes of the robot state')
    publish_transforms_updates: bool = parameter(True, 'with changes of frames')
    publish_planning_scene_hz: float = parameter(
        4.0, 'scene messages a second at most [Hz]', gt=0.0)
    cartesian_limits: CartesianLimits = CartesianLimits()
    strict_start_state: bool = parameter(
        False, 'a start state that is not a difference drops the objects that the robot carries')
    scene_from_world: Literal['live', 'fixed', 'false'] = parameter(
        'live', 'what of the simulated world the planning scene has: live: all, where it is; '
        'fixed (or true): what never moves, from the files; false: nothing')
    octomap: bool = parameter(False, 'build an octomap from the cameras of simulation.yaml')
    geometry_folder: str = parameter(
        '', 'save_geometry_to_file writes below this folder only; none: scenes in $ROS_HOME')
    planning_scene_frame_publishing_rate: float = parameter(
        10.0, 'transforms of each object a second, with move_group/TfPublisher [Hz]', gt=0.0)
    planning_scene_tf_prefix: str | None = parameter(
        None, "first part of these frames' names, '' for none; by default the node's name")
    joint_state_topics: tuple[str, ...] = parameter(
        (), "topics with joint states; none: the namespace's and /joint_states")

    @field_validator('scene_from_world', mode='before')
    @classmethod
    def _true_is_fixed(cls, value: Any) -> Any:
        words = {True: 'fixed', False: 'false', 'true': 'fixed'}
        return words.get(value, value) if isinstance(value, (bool, str)) else value

    @field_validator('capabilities', 'disable_capabilities', 'joint_state_topics',
                     'planning_pipelines', mode='before')
    @classmethod
    def _one_text_or_list(cls, value: Any) -> Any:
        return tuple(value.split()) if isinstance(value, str) else value


def offered_pipelines(
    parameters: PlanningParameters, pipelines: Mapping[str, PipelineSettings], log: Log
) -> PlanningParameters:
    """
    Return parameters with the pipelines that can plan, and with a default that is among them.

    :param pipelines: name -> settings; those that ``planning_pipelines`` lists are meant.
    :param log: gets what is left out or replaced.
    """
    offered = []
    for name in dict.fromkeys(parameters.planning_pipelines):
        fault = pipelines.get(name, PipelineSettings(planning_plugins=())).fault
        if fault:
            log.warning(f"planning pipeline '{name}' is not offered: {fault}")
        else:
            offered.append(name)
    default = parameters.default_planning_pipeline
    if default not in offered:
        first = next(iter(offered), '')
        if default:
            log.warning(
                f"default_planning_pipeline '{default}' is not among the planning pipelines "
                f"({', '.join(offered) or 'none'}); using '{first}'")
        default = first
    return parameters.model_copy(update={
        'planning_pipelines': tuple(offered), 'default_planning_pipeline': default})
