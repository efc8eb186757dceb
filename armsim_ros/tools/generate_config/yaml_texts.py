# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The texts of generated files: YAML and SRDF."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import math

from armsim_ros.config.controllers.controller_settings import BROADCASTER, TRAJECTORY
from armsim_ros.model.description.xml_tree import quoted
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.planning.scene.allowed_collision_matrix import Pair
from armsim_ros.tools.generate_config.found_groups import FoundGroup


def srdf_text(robot: RobotModel, groups: Iterable[FoundGroup],
              states: Mapping[str, Mapping[str, float]], disabled: Mapping[Pair, str]) -> str:
    """
    Return the SRDF.

    :param states: state -> joint -> position [rad or m]; each group takes its own joints.
    :param disabled: pair of links -> why it is not checked.
    """
    found = list(groups)
    lines = ['<?xml version="1.0"?>', f'<robot name={quoted(robot.name)}>']
    for group in found:
        lines.append(f'  <group name={quoted(group.name)}>')
        if group.chain:
            base, tip = map(quoted, group.chain)
            lines.append(f'    <chain base_link={base} tip_link={tip}/>')
        else:
            lines += [f'    <joint name={quoted(name)}/>' for name in group.joints]
        lines.append('  </group>')
    for group in found:
        for state, positions in states.items():
            lines += _state(state, group, positions)
    for group in found:
        if group.parent:
            lines.append(
                f'  <end_effector name={quoted(group.name)} group={quoted(group.name)} '
                f'parent_link={quoted(group.parent_link)} '
                f'parent_group={quoted(group.parent)}/>')
    lines += [f'  <passive_joint name={quoted(name)}/>' for name in robot.movable_joints
              if robot.joints[name].mimic is not None]
    lines += [f'  <disable_collisions link1={quoted(first)} link2={quoted(second)} '
              f'reason="{reason}"/>' for (first, second), reason in disabled.items()]
    return '\n'.join([*lines, '</robot>']) + '\n'


def _state(state: str, group: FoundGroup, positions: Mapping[str, float]) -> list[str]:
    return [f'  <group_state name="{state}" group={quoted(group.name)}>',
            *(f'    <joint name={quoted(name)} value="{positions[name]:g}"/>'
              for name in group.active_joints),
            '  </group_state>']


GRIPPER = 'position_controllers/GripperActionController'
#: Where a URDF gives none [rad/s or m/s].
USUAL_VELOCITY = {JointType.PRISMATIC: 0.1}
USUAL_TURNING = 1.0
#: Time from rest to full velocity [s].
ACCELERATION_TIME = 0.5
#: An arm with fewer joints cannot reach every orientation.
FULL_POSE_JOINTS = 6


def settings_texts(robot: RobotModel, groups: Sequence[FoundGroup],
                   states: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """Return file name -> text."""
    return {
        'ros2_controllers.yaml': _controllers(robot, groups),
        'moveit_controllers.yaml': _moveit_controllers(groups),
        'joint_limits.yaml': _joint_limits(robot),
        'kinematics.yaml': _kinematics(groups),
        'simulation.yaml': _simulation(groups, states),
    }


def controller_name(group: FoundGroup) -> str:
    """Return the name of the controller that moves a group."""
    return f'{group.name}_controller'


def _is_jaw(group: FoundGroup) -> bool:
    return group.chain is None and len(group.active_joints) == 1


def _controllers(robot: RobotModel, groups: Sequence[FoundGroup]) -> str:
    lines = ['controller_manager:', '  ros__parameters:', '    update_rate: 500',
             '    joint_state_broadcaster:', f'      type: {BROADCASTER}']
    for group in groups:
        kind = GRIPPER if _is_jaw(group) else TRAJECTORY
        lines += [f'    {controller_name(group)}:', f'      type: {kind}']
    for group in groups:
        lines += ['', f'{controller_name(group)}:', '  ros__parameters:']
        if _is_jaw(group):
            joint = group.active_joints[0]
            lines += [f'    joint: {joint}', '    allow_stalling: true',
                      f'    goal_tolerance: {_goal_tolerance(robot, joint)}']
        else:
            lines += _trajectory_controller(robot, group)
    return '\n'.join(lines) + '\n'


def _trajectory_controller(robot: RobotModel, group: FoundGroup) -> list[str]:
    return ['    joints:', *(f'      - {name}' for name in group.active_joints),
            '    command_interfaces: [position]', '    state_interfaces: [position, velocity]',
            '    constraints:', '      goal_time: 0.6',
            *(f'      {name}: {{trajectory: {0.1 if _turns(robot, name) else 0.02}, '
              f'goal: {_goal_tolerance(robot, name)}}}' for name in group.active_joints)]


def _moveit_controllers(groups: Sequence[FoundGroup]) -> str:
    plugin = 'moveit_simple_controller_manager'
    lines = [f'moveit_controller_manager: {plugin}/MoveItSimpleControllerManager',
             f'{plugin}:', '  controller_names:',
             *(f'    - {controller_name(group)}' for group in groups)]
    for group in groups:
        action, kind = (('gripper_cmd', 'GripperCommand') if _is_jaw(group)
                        else ('follow_joint_trajectory', 'FollowJointTrajectory'))
        lines += [f'  {controller_name(group)}:', f'    action_ns: {action}',
                  f'    type: {kind}', '    default: true', '    joints:',
                  *(f'      - {name}' for name in group.active_joints)]
    lines += ['trajectory_execution:', '  allowed_execution_duration_scaling: 1.2',
              '  allowed_goal_duration_margin: 0.5', '  allowed_start_tolerance: 0.01']
    return '\n'.join(lines) + '\n'


def _joint_limits(robot: RobotModel) -> str:
    lines = ["# Velocities are the URDF's. It has no accelerations: these reach full velocity in "
             f'{ACCELERATION_TIME:g} s;', '# put the real ones in their place.',
             'default_velocity_scaling_factor: 0.1', 'default_acceleration_scaling_factor: 0.1',
             'joint_limits:']
    for name in robot.active_joints:
        joint = robot.joints[name]
        known = math.isfinite(joint.limits.velocity) and joint.limits.velocity > 0.0
        velocity = joint.limits.velocity if known else USUAL_VELOCITY.get(
            joint.type, USUAL_TURNING)
        note = '' if known else '  # the URDF gives none'
        lines += [f'  {name}:', '    has_velocity_limits: true',
                  f'    max_velocity: {_real(velocity)}{note}',
                  '    has_acceleration_limits: true',
                  f'    max_acceleration: {_real(velocity / ACCELERATION_TIME)}']
    return '\n'.join(lines) + '\n'


def _kinematics(groups: Sequence[FoundGroup]) -> str:
    lines = []
    for group in groups:
        if group.chain is None:
            continue
        lines += [f'{group.name}:',
                  '  kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin',
                  '  kinematics_solver_search_resolution: 0.005',
                  '  kinematics_solver_timeout: 0.05']
        if len(group.active_joints) < FULL_POSE_JOINTS:
            lines.append(f'  position_only_ik: true  # {len(group.active_joints)} joints '
                         'cannot reach every orientation')
    return '\n'.join(lines) + '\n'


def _simulation(groups: Sequence[FoundGroup], states: Mapping[str, Mapping[str, float]]) -> str:
    lines = ['# The simulated plant; every key that is absent has its default.',
             'timestep: 0.001']
    if 'home' not in states and 'ready' in states:
        lines.append('# With all joints at their defaults it would touch itself or the floor.')
        lines.append('initial_positions:')
        for group in groups:
            lines += [f"  {name}: {states['ready'][name]:g}" for name in group.active_joints]
    return '\n'.join(lines) + '\n'


def _turns(robot: RobotModel, joint: str) -> bool:
    return robot.joints[joint].type is not JointType.PRISMATIC


def _goal_tolerance(robot: RobotModel, joint: str) -> float:
    return 0.01 if _turns(robot, joint) else 0.002


def _real(value: float) -> str:
    text = f'{value:.6g}'
    return text if any(sign in text for sign in '.en') else f'{text}.0'
