# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of the move_group node."""

from __future__ import annotations

from dataclasses import replace

from rclpy.parameter import Parameter

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.trajectory_execution import KEYS_BESIDE, TrajectoryExecutionSettings
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.parameters import SettingsParameters

DESCRIPTIONS = ('robot_description', 'robot_description_semantic')


class LiveParameters(Settings):
    """Parameters that may be changed while move_group runs, from the next request on."""

    trajectory_execution: TrajectoryExecutionSettings
    planning_seed: int = parameter(
        -1, 'a number >= 0 makes every plan repeatable for the same scene, state and request'
    )


class MoveGroupParameters:
    """
    Declares the parameters and takes over their changes.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        """Declare; values from ``--ros-args`` win over the robot's files."""
        self._context = context
        texts = dict(zip(DESCRIPTIONS, (context.robot.urdf, context.robot.srdf), strict=False))
        for name, text in texts.items():
            if not context.node.has_parameter(name):
                context.node.declare_parameter(name, text)
        live = LiveParameters(
            trajectory_execution=context.settings.trajectory_execution,
            planning_seed=context.planner.settings.seed,
        )
        self._live = SettingsParameters(context.node, live, self._changed)
        self._declare_fixed()

    def _changed(self, live: LiveParameters) -> None:
        context = self._context
        context.execution_settings = live.trajectory_execution
        context.planner.settings = replace(context.planner.settings, seed=live.planning_seed)

    def _declare_fixed(self) -> None:
        """Declare what is read once: clients and tools look these up."""
        node, settings = self._context.node, self._context.settings
        values = {
            key: getattr(settings.trajectory_execution, key) for key in sorted(KEYS_BESIDE)
        }
        for group, kinematics in settings.kinematics.items():
            for key, value in kinematics.model_dump().items():
                values[f'robot_description_kinematics.{group}.{key}'] = value
        for joint, limits in settings.joint_limits.joint_limits.items():
            for key, value in limits.model_dump().items():
                values[f'robot_description_planning.joint_limits.{joint}.{key}'] = value
        for name, value in values.items():
            if isinstance(value, (bool, int, float, str)) and not node.has_parameter(name):
                node.set_parameters([Parameter(name, value=value)])
