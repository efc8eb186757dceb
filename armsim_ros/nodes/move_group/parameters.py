# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the move_group node that can be changed at run time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pydantic import ValidationError
from rclpy.exceptions import ParameterException
from rclpy.parameter import Parameter

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.move_group.trajectory_execution import (
    KEYS_BESIDE,
    TrajectoryExecutionSettings,
)
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.parameters import reason, SettingsParameters

_EXECUTION = 'trajectory_execution.'
#: Read at the start.
_AT_THE_START = tuple(sorted(KEYS_BESIDE - {'allow_trajectory_execution'}))


class PlanExecution(Settings):
    """Parameters of ``plan_execution``."""

    record_trajectory_state_frequency: float = parameter(
        0.0, 'states a second in executed_trajectory; 0 leaves it empty [Hz]', ge=0.0, le=1000.0
    )


class LiveParameters(Settings):
    """Parameters that take effect with the next request."""

    allow_trajectory_execution: bool = parameter(
        True, 'whether execute_trajectory and move_action move the robot')
    plan_execution: PlanExecution
    planning_seed: int = parameter(
        -1, 'a number >= 0 makes every plan repeatable for the same scene, state and request'
    )
    monitor_dynamics: bool = parameter(False, 'take velocities from the joint states')


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
        execution = _at_the_start(context)
        context.execution_settings = execution
        live = LiveParameters(
            allow_trajectory_execution=execution.allow_trajectory_execution,
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
