# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the joint trajectory controller, as ros2_controllers declares them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import (
    are_names,
    ControllerParameters,
    entry_per_name,
    fixed,
    KeyedSettings,
    parameter,
    Settings,
    unique_names,
)
from armsim_ros.config.controllers.broadcasters import SPEED_SCALING
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.errors import nearest

CommandInterface = Literal['position', 'velocity', 'acceleration', 'effort']
StateInterface = Literal['position', 'velocity', 'acceleration']
LEGAL_COMMAND_SETS = (
    ('position',),
    ('position', 'velocity'),
    ('position', 'velocity', 'acceleration'),
    ('position', 'acceleration'),
    ('velocity',),
    ('effort',),
    ('position', 'effort'))


class JointConstraints(Settings):
    """How far a joint may be from its reference; 0 or less is unchecked."""

    trajectory: float = parameter(0.0, 'position tolerance on the way [rad or m]')
    goal: float = parameter(0.0, 'position tolerance at the goal [rad or m]')
    max_deceleration_on_cancel: float = fixed(
        0.0, 'deceleration of a stop [rad/s^2 or m/s^2]', ge=0.0)


class TrajectoryConstraints(KeyedSettings):
    """What a trajectory has to keep; besides its own keys a block per joint."""

    is_no = "constraint, and no block of a joint's constraints"
    __pydantic_extra__: dict[str, JointConstraints] = Field(init=False)

    stopped_velocity_tolerance: float = parameter(
        0.01, 'velocity tolerance at the goal, 0 or less is unchecked [rad/s or m/s]')
    goal_time: float = parameter(
        0.0, 'time after the last waypoint to reach the goal, 0 is no bound [s]', ge=0.0)
    decelerate_on_cancel: bool = fixed(
        False, 'stop with max_deceleration_on_cancel instead of at once')

    @property
    def joints(self) -> dict[str, JointConstraints]:
        """Joint -> its own block."""
        return self.__pydantic_extra__


class SpeedScaling(Settings):
    """How the pace of a trajectory is changed from outside."""

    initial_scaling_factor: float = fixed(1.0, 'pace at the start, 1 is as planned', ge=0.0)
    state_interface: str = fixed('', 'interface to read the pace from')
    command_interface: str = fixed('', 'interface to pass the pace on to')


class JointTrajectoryControllerParameters(ControllerParameters):
    """
    Parameters of ``joint_trajectory_controller/JointTrajectoryController``.

    Names, defaults and ranges are those of ros2_controllers for Jazzy, but for these:
    ``interpolate_from_desired_state`` is true by default (a replaced trajectory goes on without
    a step back to the measured state), and ``state_publish_rate``, ``stop_trajectory_duration``,
    ``compat``, ``refused_goals`` and ``reject_beyond_limits`` are ours or ROS 1's.
    """

    joints: tuple[str, ...] = fixed(
        ..., 'controlled joints, in the order of all arrays', min_length=1)
    command_joints: tuple[str, ...] = fixed((), 'joints that are commanded; empty is all')
    command_interfaces: tuple[CommandInterface, ...] = fixed(
        ('position',), 'interfaces to claim of each joint', min_length=1)
    state_interfaces: tuple[StateInterface, ...] = fixed(
        ('position', 'velocity'), 'interfaces to read of each joint', min_length=1)
    allow_partial_joints_goal: bool = parameter(
        False, 'accept trajectories that name only some of the joints')
    allow_integration_in_goal_trajectories: bool = parameter(
        False, 'accept points that give only velocities or accelerations')
    allow_nonzero_velocity_at_trajectory_end: bool = parameter(
        False, 'accept a last point with a velocity')
    interpolate_from_desired_state: bool = fixed(
        True, 'start a new trajectory from the reference, not from the measured state')
    open_loop_control: bool = fixed(
        False, 'deprecated: like interpolate_from_desired_state, and without PID')
    set_last_command_interface_value_as_state_on_activation: bool = parameter(
        True, 'hold the last command at activation, if there is a command')
    action_monitor_rate: float = fixed(
        20.0, 'feedback messages a second [Hz]', ge=0.1, allow_inf_nan=False)
    state_publish_rate: float = fixed(
        100.0, 'controller_state messages a second, 0 is each update [Hz]', ge=0.0,
        allow_inf_nan=False)
    interpolation_method: Literal['splines', 'none'] = fixed(
        'splines', 'splines between waypoints, or their bare values')
    cmd_timeout: float = parameter(
        0.0, 'hold when the last waypoint is this old, 0 or less is never [s]')
    stop_trajectory_duration: float = fixed(
        0.0, 'duration of the ramp on cancel, 0 is none [s]', ge=0.0, allow_inf_nan=False)
    compat: Literal['jazzy', 'ros1'] = fixed(
        'jazzy',
        'ros1: a topic message cancels a running goal, a preempted goal is canceled, an empty '
        'message stops, goal_time 0 leaves no grace')
    refused_goals: Literal['reject', 'abort'] = parameter(
        'reject', 'abort: accept a bad goal and end it at once, so that its result has the reason')
    reject_beyond_limits: bool = parameter(
        False,
        "refuse trajectories beyond the URDF's position and velocity limits, or with a first "
        'point out of reach, instead of a warning')
    speed_scaling: SpeedScaling = parameter(SpeedScaling(), 'pace of trajectories')
    constraints: TrajectoryConstraints = parameter(TrajectoryConstraints(), 'tolerances')
    gains: dict[str, PidGains] = parameter({}, 'joint -> gains, for velocity or effort commands')
    velocity_ff: dict[str, float] = fixed({}, 'ROS 1: joint -> gains.<joint>.ff_velocity_scale')
    hold_trajectory_duration: float = fixed(
        0.5, 'ROS 1: has no effect, holding starts at once [s]', ge=0.0)
    verbose: bool = fixed(False, 'ROS 1: has no effect')

    @model_validator(mode='before')
    @classmethod
    def _one_block_each_joint(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        joints = data.get('joints')
        if not are_names(joints):
            return data
        filled: dict[str, Any] = dict(data)
        for key in ('gains', 'constraints'):
            block = filled.get(key, {})
            if isinstance(block, TrajectoryConstraints):
                block = block.model_dump()
            if isinstance(block, Mapping):
                filled[key] = entry_per_name(joints, block)
        scales, blocks = filled.get('velocity_ff'), filled['gains']
        if isinstance(scales, Mapping) and isinstance(blocks, dict):
            for joint, scale in scales.items():
                if isinstance(blocks.get(joint), Mapping):
                    blocks[joint] = {'ff_velocity_scale': scale, **blocks[joint]}
        return filled

    @field_validator('joints', 'command_joints', 'command_interfaces', 'state_interfaces')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return unique_names(value)

    @model_validator(mode='after')
    def _together(self) -> Self:
        if set(self.command_interfaces) not in [set(legal) for legal in LEGAL_COMMAND_SETS]:
            legal = '; '.join(', '.join(names) for names in LEGAL_COMMAND_SETS)
            raise ValueError(
                f'command_interfaces {", ".join(self.command_interfaces)} do not go together; '
                f'allowed: {legal}')
        states = self.state_interfaces
        for level, needed in (('velocity', 'position'), ('acceleration', 'velocity')):
            if level in states and needed not in states:
                raise ValueError(f'state_interfaces: {level} needs {needed} too')
        if 'position' not in states:
            raise ValueError('state_interfaces: position is needed')
        if len(self.command_joints) > len(self.joints):
            raise ValueError('command_joints is longer than joints')
        blocks = (('constraints', self.constraints.joints), ('gains', self.gains))
        for key, names in (*blocks, ('velocity_ff', self.velocity_ff)):
            for name in names:
                if name not in self.joints:
                    hint = nearest(name, self.joints)
                    raise ValueError(
                        f"{key}: '{name}' is not among the controller's joints "
                        f'({", ".join(self.joints)}){"; " if hint else ""}{hint}')
        return self

    @property
    def commanded(self) -> tuple[str, ...]:
        """Joints of the hardware, or ``controller/joint`` of following controllers."""
        return self.command_joints or self.joints

    @property
    def chained(self) -> bool:
        """Whether it writes to following controllers instead of joints."""
        return '/' in self.commanded[0]

    @property
    def commanding(self) -> tuple[str, ...]:
        """The joint whose trajectory each of them gets: its own, else that in its place."""
        if set(self.commanded) <= set(self.joints):
            return self.commanded
        return self.joints

    @property
    def uses_pid(self) -> bool:
        """Whether commands come from the PID: velocity alone or effort alone."""
        return self.command_interfaces in (('velocity',), ('effort',))

    @property
    def speed_source(self) -> str:
        """The state interface that the pace is read from, '' where it is not."""
        return self.speed_scaling.state_interface

    @property
    def initial_pace(self) -> float:
        """The pace at the start; only where positions alone are commanded it can be changed."""
        alone = self.command_interfaces == ('position',)
        return self.speed_scaling.initial_scaling_factor if alone else 1.0


class ScaledJointTrajectoryControllerParameters(JointTrajectoryControllerParameters):
    """Parameters of ``ur_controllers/ScaledJointTrajectoryController``."""

    speed_scaling_interface_name: str = fixed(
        SPEED_SCALING, "state interface to read the pace from; '' is none")

    @property
    def speed_source(self) -> str:
        """The state interface that the pace is read from, '' where it is not."""
        return self.speed_scaling_interface_name or super().speed_source


class PassthroughTrajectoryControllerParameters(ScaledJointTrajectoryControllerParameters):
    """Parameters of ``ur_controllers/PassthroughTrajectoryController``."""

    tf_prefix: str = fixed('', 'prefix that the other names have already')
