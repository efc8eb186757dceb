# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node ``moveit_simple_controller_manager``: the parameters of trajectory execution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import create_model, ValidationError
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.config.base import Settings
from armsim_ros.config.move_group.trajectory_execution import (
    KEYS_BESIDE,
    TrajectoryExecutionSettings,
    UNUSED_EXECUTION_KEYS,
)
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.parameters import controller_parameters
from armsim_ros.nodes.parameters import parameters_by_prefix, reason, SettingsParameters
from armsim_ros.nodes.polling_node import GuardedNode

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
        for parameter in parameters:
            if parameter.name.startswith(_OF_JOINTS):
                joint = parameter.name[len(_OF_JOINTS):]
                usable = type(parameter.value) in (int, float)
                if joint not in known:
                    problems.append(f"{parameter.name}: the robot has no joint '{joint}'")
                elif not usable or parameter.value < 0.0:
                    problems.append(
                        f'{parameter.name} is {parameter.value}; allowed: a number from 0 up')
            elif not self.node.has_parameter(parameter.name):
                problems.append(f"'{parameter.name}' is not known; allowed: {GROUP}.*")
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
    for name, parameter in parameters_by_prefix(node, GROUP).items():
        field, _, joint = name.partition('.')
        if field == _JOINTS and joint:
            values.setdefault(_JOINTS, {})[joint] = parameter.value
        elif field in _FIELDS and field not in UNUSED_EXECUTION_KEYS:
            values[field] = parameter.value
    return values


def _read_only() -> ParameterDescriptor:
    """Return a descriptor of its own; rclpy writes the parameter's name into it."""
    return ParameterDescriptor(read_only=True, dynamic_typing=True)
