# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of move_group that are neither a planner's nor of execution."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import field_validator

from armsim_ros.config.base import parameter, Settings


class CartesianLimits(Settings):
    """How fast the tool may move on lines and arcs; the defaults are the usual template's."""

    max_trans_vel: float = parameter(1.0, 'largest speed [m/s]', gt=0.0)
    max_trans_acc: float = parameter(2.25, 'largest acceleration [m/s^2]', gt=0.0)
    max_trans_dec: float = parameter(-5.0, 'largest deceleration, below 0 [m/s^2]', lt=0.0)
    max_rot_vel: float = parameter(1.57, 'largest turning speed [rad/s]', gt=0.0)


class PlanningParameters(Settings):
    """move_group's parameters about descriptions, pipelines and the planning scene."""

    default_robot_padding: float = parameter(
        0.0, 'the robot is this much thicker against the world [m]', ge=0.0)
    default_robot_scale: float = parameter(1.0, 'and so many times as large', gt=0.0)
    default_object_padding: float = parameter(0.0, 'padding of world objects [m]', ge=0.0)
    default_attached_padding: float = parameter(0.0, 'padding of attached objects [m]', ge=0.0)
    planning_pipelines: tuple[str, ...] = parameter(
        ('ompl', 'pilz_industrial_motion_planner'), 'names of the pipelines')
    default_planning_pipeline: str = parameter('ompl', 'pipeline of a request that names none')
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
    geometry_folder: str = parameter(
        '', 'save_geometry_to_file writes below this folder only; none: scenes in $ROS_HOME')
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
