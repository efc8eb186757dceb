# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot's settings under other names: a prefix and a namespace keep robots apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import re
from typing import Any

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.broadcasters import (
    BroadcasterParameters,
    SPEED_SCALING,
    SpeedScalingStateBroadcasterParameters,
    StateInterfacesBroadcasterParameters,
)
from armsim_ros.config.controllers.command_controllers import GpioCommandControllerParameters
from armsim_ros.config.controllers.controller_settings import ControllerSettings
from armsim_ros.config.kinematics import KinematicsSettings
from armsim_ros.config.ompl_planning import OmplGroup, PipelineSettings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.trajectory_execution import MoveItControllerSettings

#: Keys of controllers' parameters that hold a joint or a list of joints.
_JOINTS = ('joint', 'joints', 'command_joints', 'dof_names', 'reference_and_state_dof_names')
#: Keys that hold blocks by joint, beside other keys.
_JOINT_BLOCKS = ('constraints', 'gains', 'velocity_ff')
#: Dotted paths of what names a link, a sensor, or an interface of these.
_NAMES = (
    'sensor_name', 'pose_name', 'tf.child_frame_id', 'speed_scaling_interface_name',
    'speed_scaling.state_interface', 'speed_scaling.command_interface',
    *(f'interface_names.{kind}.{axis}' for kind in ('force', 'torque') for axis in 'xyz'),
    'ft_sensor.name', 'ft_sensor.frame.id', 'control.frame.id', 'fixed_world_frame.frame.id',
    'gravity_compensation.frame.id', 'kinematics.base', 'kinematics.tip',
    'end_effector_frame', 'base_frame', 'ft_sensor.frame', 'robot_base_link', 'end_effector_link',
    'ft_sensor_ref_link', 'compliance_ref_link')
#: Keys that hold ``joint/interface``.
_JOINT_INTERFACES = ('max_effort_interface', 'max_velocity_interface')

_EVALUATOR = re.compile(r'(joints|link)\(([^)]*)\)')

Rename = Callable[[str], str]


def prefixed_settings(settings: RobotSettings, prefix: str, namespace: str) -> RobotSettings:
    """
    Return a robot's settings with its links, joints and planning groups renamed.

    Controllers and suction cups keep their names and move to another namespace.

    :param prefix: precedes every name; may be ''.
    :param namespace: without slashes at its ends; '' is the root.
    """
    def name(text: str) -> str:
        return prefix + text if text else text

    def keys(block: Mapping[str, Any]) -> dict[str, Any]:
        return {name(key): value for key, value in block.items()}

    limits, execution = settings.joint_limits, settings.trajectory_execution
    return settings.model_copy(update={
        'namespace': f'/{namespace}' if namespace else '',
        'controllers': tuple(_controller(controller, name) for controller in settings.controllers),
        'joint_limits': limits.model_copy(update={'joint_limits': keys(limits.joint_limits)}),
        'kinematics': {name(group): _kinematics(solver, name)
                       for group, solver in settings.kinematics.items()},
        'pipelines': {pipeline: _pipeline(block, name)
                      for pipeline, block in settings.pipelines.items()},
        'moveit_controllers': tuple(
            _moveit_controller(controller, name, settings.namespace.strip('/'), namespace)
            for controller in settings.moveit_controllers),
        'trajectory_execution': execution.model_copy(update={
            'allowed_start_tolerance_joints': keys(execution.allowed_start_tolerance_joints)}),
        'simulation': _simulation(settings.simulation, name),
    })


def _controller(controller: ControllerSettings, name: Rename) -> ControllerSettings:
    parameters: Settings = controller.parameters
    content = parameters.model_dump(by_alias=True, exclude_unset=True)
    joints = set(controller.joints)

    def joint(text: str) -> str:
        owner, slash, own = text.rpartition('/')
        return f'{owner}{slash}{name(own)}'  # controllers keep their names, their joints do not

    for key, value in content.items():
        if key in _JOINTS:
            content[key] = joint(value) if isinstance(value, str) else list(map(joint, value))
        elif key in _JOINT_BLOCKS:
            content[key] = {joint(inner) if inner in joints else inner: block
                            for inner, block in value.items()}
        elif key == 'nullspace':
            content[key] = {**value, 'weights': {
                joint(inner): block for inner, block in value.get('weights', {}).items()}}
        elif key in _JOINT_INTERFACES:
            content[key] = name(value)
        elif key == 'extra_joints':
            content[key] = [{**entry, 'name': name(entry['name'])} for entry in value]
        elif isinstance(parameters, StateInterfacesBroadcasterParameters) and key == 'interfaces':
            parts = (text.rpartition('/') for text in value)
            content[key] = [f'{joint(owner)}{slash}{kind}' for owner, slash, kind in parts]
        elif key == 'gpios':
            content[key] = list(map(name, value))
        elif isinstance(parameters, GpioCommandControllerParameters) and key.endswith('faces'):
            content[key] = {name(gpio): block for gpio, block in value.items()}
    paths = (*_NAMES, 'frame_id') if isinstance(parameters, BroadcasterParameters) else _NAMES
    for path in paths:
        _rename(content, parameters, path.split('.'), name)
    if isinstance(parameters, SpeedScalingStateBroadcasterParameters):
        # It is empty for a single robot, and precedes the name of the only interface.
        content['tf_prefix'] = name(parameters.states[0]).removesuffix(SPEED_SCALING)
    return controller.model_copy(update={'parameters': type(parameters).model_validate(content)})


def _rename(content: dict[str, Any], parameters: Any, path: Sequence[str], name: Rename) -> None:
    """Rename a value of dumped parameters, also where it was not given and has a default."""
    value: Any = parameters
    for key in path:
        value = getattr(value, key, '')
    if not value or not isinstance(value, str):  # some have a frame, others a block of it
        return
    for key in path[:-1]:
        content = content.setdefault(key, {})
    content[path[-1]] = name(value)


def _kinematics(block: KinematicsSettings, name: Rename) -> KinematicsSettings:
    return block.model_copy(update={
        'joints': tuple(name(joint) for joint in block.joints),
        'weights': {name(joint): weight for joint, weight in block.weights.items()}})


def _pipeline(block: PipelineSettings, name: Rename) -> PipelineSettings:
    groups = {name(group): _ompl_group(group_block, name)
              for group, group_block in block.groups.items()}
    return block.model_copy(update={'groups': groups})


def _ompl_group(group: OmplGroup, name: Rename) -> OmplGroup:
    def renamed(match: re.Match[str]) -> str:
        inner = ','.join(name(part.strip()) for part in match[2].split(','))
        return f'{match[1]}({inner})'

    evaluator = _EVALUATOR.sub(renamed, group.projection_evaluator)
    return group.model_copy(update={'projection_evaluator': evaluator})


def _moveit_controller(controller: MoveItControllerSettings, name: Rename, before: str,
                       after: str) -> MoveItControllerSettings:
    own = controller.name.strip('/')
    if before and own.startswith(f'{before}/'):
        own = own[len(before) + 1:]
    return controller.model_copy(update={
        'name': f'{after}/{own}' if after else own,
        'joints': tuple(map(name, controller.joints)),
        'command_joint': name(controller.command_joint),
    })


def _simulation(block: SimulationSettings, name: Rename) -> SimulationSettings:
    gains = {name(joint): gain for joint, gain in block.servo.gains.items()}
    group, slash, state = block.initial_state.rpartition('/')
    return block.model_copy(update={
        'servo': block.servo.model_copy(update={'gains': gains}),
        'initial_positions': {name(joint): position
                              for joint, position in block.initial_positions.items()},
        'initial_state': f'{name(group)}{slash}{state}',
        'cameras': {name(camera): settings_of.model_copy(update={'link': name(settings_of.link)})
                    for camera, settings_of in block.cameras.items()},
        'vacuum_grippers': {cup: gripper.model_copy(update={'link': name(gripper.link)})
                            for cup, gripper in block.vacuum_grippers.items()},
        'sensors': {name(sensor): entry.model_copy(update={'link': name(entry.link)})
                    for sensor, entry in block.sensors.items()},
    })
