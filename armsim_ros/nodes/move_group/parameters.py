# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the move_group node that can be changed at run time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pydantic import create_model, ValidationError
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.move_group.trajectory_execution import (
    KEYS_BESIDE,
    TrajectoryExecutionSettings,
)
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.parameters import reason, SettingsParameters

JOINT_TOLERANCES = 'allowed_start_tolerance_joints'

_PREFIX = f'trajectory_execution.{JOINT_TOLERANCES}.'

_FIELDS = TrajectoryExecutionSettings.model_fields
_BESIDE: Any = create_model(
    '_BESIDE',
    __base__=Settings,
    **{name: (_FIELDS[name].annotation, _FIELDS[name]) for name in sorted(KEYS_BESIDE)},
)
_INSIDE: Any = create_model(
    'TrajectoryExecutionParameters',
    __base__=Settings,
    **{
        name: (info.annotation, info)
        for name, info in _FIELDS.items()
        if name not in KEYS_BESIDE
    },
)


class PlanExecution(Settings):
    """Parameters of ``plan_execution``."""

    record_trajectory_state_frequency: float = parameter(
        0.0, 'states a second in executed_trajectory; 0 leaves it empty [Hz]', ge=0.0, le=1000.0
    )


class LiveParameters(_BESIDE):
    """Parameters that take effect with the next request."""

    trajectory_execution: _INSIDE
    plan_execution: PlanExecution
    planning_seed: int = parameter(
        -1, 'a number >= 0 makes every plan repeatable for the same scene, state and request'
    )
    monitor_dynamics: bool = parameter(False, 'take velocities from the joint states')

    def execution(self) -> TrajectoryExecutionSettings:
        """Return the settings of execution."""
        return TrajectoryExecutionSettings(
            **{name: getattr(self, name) for name in KEYS_BESIDE},
            **self.trajectory_execution.model_dump(),
        )


class MoveGroupParameters:
    """
    Declares the live parameters and takes over their changes.

    :param context: the parts of move_group.
    :raises ConfigError: a value from ``--ros-args`` is wrong.
    """

    def __init__(self, context: Context) -> None:
        """Declare; values from ``--ros-args`` win over the robot's files."""
        self._context = context
        planning = context.planning_parameters
        execution = context.settings.trajectory_execution
        inside = {
            name: getattr(execution, name) for name in _INSIDE.model_fields
        }
        live = LiveParameters(
            **{name: getattr(execution, name) for name in KEYS_BESIDE},
            trajectory_execution=_INSIDE(**inside),
            plan_execution=PlanExecution(
                record_trajectory_state_frequency=planning.record_trajectory_state_frequency
            ),
            planning_seed=context.planner.settings.seed,
            monitor_dynamics=planning.monitor_dynamics,
        )
        try:
            self._live = SettingsParameters(context.node, live, self._changed)
        except ValidationError as error:
            raise ConfigError(Problem(f'parameter of move_group: {reason(error)}')) from None
        except ParameterException as error:
            raise ConfigError(Problem(f'parameter of move_group: {error}')) from None
        context.node.add_on_set_parameters_callback(_check_tolerances)
        context.node.add_post_set_parameters_callback(self._note_tolerances)
        self._changed(self._live.settings)

    def _note_tolerances(self, parameters: Sequence[Parameter]) -> None:
        if any(one.name.startswith(_PREFIX) for one in parameters):
            self._changed(self._live.settings)

    def _changed(self, live: LiveParameters) -> None:
        context = self._context
        execution = live.execution()
        tolerances = {**execution.allowed_start_tolerance_joints, **_given(context.node)}
        context.execution_settings = execution.model_copy(update={JOINT_TOLERANCES: tolerances})
        context.record_frequency = live.plan_execution.record_trajectory_state_frequency
        context.states.monitor_dynamics = live.monitor_dynamics
        context.planner.settings = replace(context.planner.settings, seed=live.planning_seed)


def _given(node: Node) -> dict[str, float]:
    """Return the start tolerances of joints that are set as parameters."""
    found = node.get_parameters_by_prefix(_PREFIX.rstrip('.'))
    return {joint: float(one.value) for joint, one in found.items()}


def _check_tolerances(parameters: Sequence[Parameter]) -> SetParametersResult:
    """Refuse a joint's start tolerance that is not a number of at least 0."""
    for one in parameters:
        usable = type(one.value) in (int, float) and one.value >= 0.0
        if one.name.startswith(_PREFIX) and not usable:
            return SetParametersResult(
                successful=False, reason=f'{one.name} is {one.value}; allowed: a number from 0 up'
            )
    return SetParametersResult(successful=True)
