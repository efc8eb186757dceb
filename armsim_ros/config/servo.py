# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of servo_node, as moveit_servo declares them for Jazzy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import fixed, parameter, Settings

TRAJECTORY = 'trajectory_msgs/JointTrajectory'
ARRAY = 'std_msgs/Float64MultiArray'
BUTTERWORTH = 'online_signal_smoothing::ButterworthFilterPlugin'
RUCKIG = 'online_signal_smoothing::RuckigFilterPlugin'

#: Keys of servo's files for Humble and ROS 1 -> why they have no effect.
UNUSED_SERVO_KEYS: Mapping[str, str] = {
    'use_sim_time': 'it is set once for all nodes of a program',
    'robot_link_command_frame': 'a command names its own frame',
    'planning_frame': 'it is the base of the planning group',
    'ee_frame_name': 'it is the tip of the planning group',
    'ee_frame': 'it is the tip of the planning group',
    'use_gazebo': '',
    'low_latency_mode': 'a command is taken up in the next cycle anyhow',
    'num_outgoing_halt_msgs_to_publish': 'the arm is brought to rest before the output ends',
    'collision_check_type': 'distances to what is near slow the arm down',
    'enable_parameter_update': 'parameters can always be changed',
    'joint_limit_margin': 'it is called joint_limit_margins',
    'system_latency_compensation': '',
    'min_allowable_collision_distance': '',
    'collision_distance_safety_factor': '',
    'windup_limit': '',
}


class Scale(Settings):
    """How fast commands move the arm at most; below 0, unitless commands move it backwards."""

    linear: float = parameter(
        0.4, 'translation [m/s]; speed_units and poses have no bound at 0 and below')
    rotational: float = parameter(
        0.8, 'rotation [rad/s]; speed_units and poses have no bound at 0 and below')
    joint: float = parameter(0.5, 'a joint [rad/s or m/s]; it has no effect with speed_units')


class PoseTracking(Settings):
    """When a pose counts as reached."""

    linear_tolerance: float = parameter(0.001, 'distance from the pose [m]', gt=0.0)
    angular_tolerance: float = parameter(0.01, 'angle from the pose [rad]', gt=0.0)


class ServoParameters(Settings):
    """
    The block ``moveit_servo``.

    Other defaults than upstream's: topics, planning group and controller are this robot's own,
    where they are given as an empty text.
    """

    thread_priority: int = fixed(
        40, 'of the streaming thread, where the system permits it', ge=0, le=99)
    publish_period: float = fixed(0.01, 'between two cycles [s]', gt=0.0, le=1.0)
    max_expected_latency: float = fixed(
        0.1, 'so far ahead the points of a trajectory are stamped [s]', gt=0.0)
    move_group_name: str = fixed('', "planning group; empty is the arm's")
    active_subgroup: str = parameter('', 'part of the group that moves; empty is all of it')
    pose_command_in_topic: str = fixed('~/pose_target_cmds', 'poses')
    cartesian_command_in_topic: str = fixed('~/delta_twist_cmds', 'twists')
    joint_command_in_topic: str = fixed('~/delta_joint_cmds', 'joint jogs')
    status_topic: str = fixed('~/status', 'status')
    command_in_type: Literal['unitless', 'speed_units'] = parameter(
        'unitless', 'unitless: times the scale; speed_units: m/s and rad/s')
    scale: Scale = parameter(Scale(), 'how fast commands move the arm at most')
    incoming_command_timeout: float = parameter(
        0.1, 'a command this old moves nothing any more [s]', gt=0.0)
    apply_twist_commands_about_ee_frame: bool = parameter(
        True, 'a twist turns about the tip, not about the origin of its frame')
    pose_tracking: PoseTracking = parameter(PoseTracking(), 'when a pose counts as reached')
    command_out_topic: str = fixed(
        '', "where joint commands go; empty is the arm controller's topic")
    command_out_type: Literal['trajectory_msgs/JointTrajectory', 'std_msgs/Float64MultiArray'] = (
        fixed(TRAJECTORY, 'type of joint commands'))
    publish_joint_positions: bool = parameter(True, 'joint commands hold positions')
    publish_joint_velocities: bool = parameter(True, 'joint commands hold velocities')
    publish_joint_accelerations: bool = parameter(False, 'joint commands hold accelerations')
    joint_topic: str = fixed('', "joint states; empty is the robot's own topic")
    monitored_planning_scene_topic: str = fixed(
        '/monitored_planning_scene', 'changes of the planning scene')
    is_primary_planning_scene_monitor: bool = fixed(
        True, 'serve the planning scene where no other node does')
    check_octomap_collisions: bool = fixed(
        False, 'no effect: the octomap of the planning scene always counts')
    use_smoothing: bool = fixed(True, 'smooth joint commands')
    smoothing_filter_plugin_name: Literal[
        'online_signal_smoothing::ButterworthFilterPlugin',
        'online_signal_smoothing::AccelerationLimitedPlugin',
        'online_signal_smoothing::RuckigFilterPlugin',
    ] = fixed(BUTTERWORTH, 'how joint commands are smoothed')
    check_collisions: bool = parameter(True, 'slow down near collisions')
    collision_check_rate: float = parameter(
        10.0, 'collision checks per second; at least 50 are made [Hz]', gt=0.0)
    self_collision_proximity_threshold: float = parameter(
        0.01, 'the robot slows down this near to itself [m]', gt=0.0)
    scene_collision_proximity_threshold: float = parameter(
        0.02, 'the robot slows down this near to something else [m]', gt=0.0)
    lower_singularity_threshold: float = parameter(
        17.0, 'condition number from which on the arm slows down', gt=1.0)
    hard_stop_singularity_threshold: float = parameter(
        30.0, 'condition number at which it stops', gt=1.0)
    leaving_singularity_threshold_multiplier: float = parameter(
        2.0, 'so many times as wide is the range when it moves away', gt=0.0)
    singularity_step_scale: float = parameter(
        0.01, 'step to find out where the singularity lies', gt=0.0)
    halt_all_joints_in_joint_mode: bool = parameter(
        True, 'a joint at its bound stops all, in joint jogs')
    halt_all_joints_in_cartesian_mode: bool = parameter(
        True, 'a joint at its bound stops all, in twists and poses')
    joint_limit_margins: tuple[float, ...] = parameter(
        (0.1,), 'kept from the bounds, one for all joints or one for each [rad or m]',
        min_length=1)
    override_velocity_scaling_factor: float = parameter(
        0.0, 'factor of the joint velocities; below 0.01 it is off', ge=0.0, le=1.0)

    @field_validator('joint_limit_margins')
    @classmethod
    def _margins_are_none_negative(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if any(not margin >= 0.0 for margin in value):
            raise ValueError('margins are 0 or more')
        return value

    @model_validator(mode='after')
    def _together(self) -> Self:
        """Report all conflicts, not only the first."""
        wrong = []
        if self.hard_stop_singularity_threshold <= self.lower_singularity_threshold:
            wrong.append(
                'hard_stop_singularity_threshold has to be greater than '
                'lower_singularity_threshold')
        published = (
            self.publish_joint_positions, self.publish_joint_velocities,
            self.publish_joint_accelerations)
        if not any(published):
            wrong.append(
                'publish_joint_positions, publish_joint_velocities or '
                'publish_joint_accelerations has to be true')
        if self.command_out_type == ARRAY and published[0] == published[1]:
            wrong.append(
                f'with command_out_type {ARRAY} either publish_joint_positions or '
                'publish_joint_velocities is true, not both')
        if self.scene_collision_proximity_threshold < self.self_collision_proximity_threshold:
            wrong.append(
                'scene_collision_proximity_threshold must not be less than '
                'self_collision_proximity_threshold')
        if self.max_expected_latency < 3.0 * self.publish_period:
            wrong.append(
                f'max_expected_latency ({self.max_expected_latency:g} s) has to be at least three '
                f'times publish_period ({self.publish_period:g} s)')
        if wrong:
            raise ValueError('; '.join(wrong))
        return self


class ServoNodeSettings(Settings):
    """Parameters of the node; most are in the block ``moveit_servo``."""

    moveit_servo: ServoParameters = parameter(ServoParameters(), 'streaming')
    butterworth_filter_coeff: float = fixed(
        1.5, 'of the Butterworth filter; greater is smoother', gt=1.0)
    update_period: float | None = fixed(
        None, 'no effect: the period of the other filters is publish_period [s]', gt=0.0)
    planning_group_name: str = fixed(
        '', 'group whose limits the other filters keep; empty is the same')
