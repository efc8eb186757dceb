# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How move_group runs a trajectory (``trajectory_execution``), and on which controllers."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator, model_validator

from armsim_ros.config.base import parameter, Settings


class TrajectoryExecutionSettings(Settings):
    """Parameters of ``trajectory_execution.*``, and those beside it about what may run."""

    allow_trajectory_execution: bool = parameter(
        True, 'whether execute_trajectory moves the robot')
    moveit_manage_controllers: bool = parameter(
        True, 'activate the controllers that a trajectory needs')
    moveit_controller_manager: str = parameter(
        'moveit_simple_controller_manager/MoveItSimpleControllerManager',
        'where the controllers are known from; moveit_ros_control_interface/Ros2ControlManager '
        'and .../Ros2ControlMultiManager ask the controller_managers')
    ros_control_namespace: str = parameter(
        '/', 'namespace of the controller_manager that Ros2ControlManager asks')
    controller_service_call_timeout: float = parameter(
        3.0, 'how long the answer of a controller_manager is waited for [s]', gt=0.0)
    execution_duration_monitoring: bool = parameter(
        True, 'cancel a trajectory that takes longer than expected')
    allowed_execution_duration_scaling: float = parameter(
        1.1, 'a trajectory may take so many times its duration', gt=0.0)
    allowed_goal_duration_margin: float = parameter(0.5, 'and so much longer [s]', ge=0.0)
    allowed_start_tolerance: float = parameter(
        0.01, 'largest distance of a joint from the first point, 0 is unchecked [rad or m]',
        ge=0.0)
    allowed_start_tolerance_joints: dict[str, float] = parameter(
        {}, 'joint -> its own start tolerance [rad or m]')
    wait_for_trajectory_completion: bool = parameter(True, 'wait until the robot has come to rest')
    execution_velocity_scaling: float = parameter(
        1.0, 'factor of the velocities that are sent', gt=0.0)
    control_multi_dof_joint_variables: bool = parameter(
        False, 'send the variables of planar and floating joints')


#: Keys of files that have an effect only at run time -> why.
UNUSED_EXECUTION_KEYS = dict.fromkeys(
    ('wait_for_trajectory_completion', 'execution_velocity_scaling'),
    'it takes effect only when it is set at run time on the node moveit_simple_controller_manager')

#: The keys that are beside ``trajectory_execution``, not in it.
KEYS_BESIDE = frozenset({
    'allow_trajectory_execution', 'moveit_manage_controllers', 'moveit_controller_manager',
    'ros_control_namespace', 'controller_service_call_timeout'})


#: Keys without which an entry of a file is left out.
NEEDED_KEYS = ('action_ns', 'type', 'joints')

#: Keys that MoveIt reads, or read once -> why they have no effect here.
UNUSED_MOVEIT_CONTROLLER_KEYS = {
    'path_tolerance': "tolerances are the controller's constraints",
    'goal_tolerance': "tolerances are the controller's constraints",
    'goal_time_tolerance': "tolerances are the controller's constraints",
}


ActionType = Literal['FollowJointTrajectory', 'GripperCommand', 'ParallelGripperCommand']


class MoveItControllerSettings(Settings):
    """A controller as move_group sees it: an action and the joints it moves."""

    name: str = parameter(..., "name with its namespace, such as 'sunday/arm_controller'",
                          min_length=1)
    type: ActionType = parameter('FollowJointTrajectory', 'kind of action')
    action_ns: str = parameter('follow_joint_trajectory', "last part of the action's name")
    joints: tuple[str, ...] = parameter(..., 'joints that it moves', min_length=1)
    default: bool = parameter(False, 'preferred where several controllers fit')
    command_joint: str = parameter('', 'joint whose position a gripper command takes')
    max_effort: float = parameter(0.0, 'effort of a gripper command [N*m or N]', ge=0.0)
    max_velocity: float = parameter(
        0.0, 'velocity of a parallel gripper command [rad/s or m/s]', ge=0.0)
    parallel: bool = parameter(False, 'two joints that close against each other')
    allow_failure: bool = parameter(False, 'a gripper command that is aborted has succeeded')
    allowed_execution_duration_scaling: float | None = parameter(
        None, "this controller's own scaling", gt=0.0)
    allowed_goal_duration_margin: float | None = parameter(
        None, "this controller's own margin [s]", ge=0.0)

    @field_validator('joints')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        twice = sorted({name for name in value if value.count(name) > 1})
        if twice:
            raise ValueError(f"'{twice[0]}' is named twice")
        return value

    @model_validator(mode='after')
    def _two_jaws(self) -> MoveItControllerSettings:
        if self.type == 'GripperCommand' and self.parallel and len(self.joints) != 2:
            raise ValueError(f"'parallel' needs two joints; there are {len(self.joints)}")
        return self

    @property
    def action_name(self) -> str:
        """Name of the action, relative to move_group's namespace."""
        return f'{self.name}/{self.action_ns}' if self.action_ns else self.name
