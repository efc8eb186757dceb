# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers that move_group sends trajectories to (``moveit_controllers.yaml``)."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator, model_validator

from armsim_ros.config.base import parameter, Settings

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
