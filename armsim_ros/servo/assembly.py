# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A stream of a robot's own settings, and all that is wrong with them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.servo import BUTTERWORTH, RUCKIG, ServoNodeSettings, ServoParameters
from armsim_ros.errors import ArmsimError, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.servo.smoothing import (
    AccelerationFilter,
    ButterworthFilter,
    JerkFilter,
    NoFilter,
    SmoothingFilter,
)
from armsim_ros.servo.speed_limits import JointBounds, Proximity
from armsim_ros.servo.stream import ServoStream
from armsim_ros.servo.target_velocity import TargetVelocity

DEFAULT_ACCELERATION, DEFAULT_JERK = 5.0, 100.0
"""Limits of joints that have none [rad/s^2, rad/s^3; or m]."""


class ServoSettingsError(ArmsimError):
    """Servo cannot work with its parameters; the text names all errors."""


def commanded_robot(robot: RobotModel) -> RobotModel:
    """Return a robot whose groups leave out passive joints, which no controller moves."""
    groups = {name: replace(group, active_joints=robot.controlled_joints(name))
              for name, group in robot.semantic.groups.items()}
    return replace(robot, semantic=replace(robot.semantic, groups=groups))


def arm_group(kinematics: KinematicModel, controllers: Iterable[Sequence[str]]) -> str:
    """
    Return the planning group that a robot's arm controller moves, '' where there is none.

    :param controllers: the joints of each trajectory controller.
    """
    moved = [set(joints) for joints in controllers]
    groups = {
        name: group.active_joints
        for name, group in kinematics.robot.semantic.groups.items()
        if group.active_joints and (group.chain is not None or len(group.tips) == 1)}
    fitting = {name: joints for name, joints in groups.items()
               if any(set(joints) <= joints_of for joints_of in moved)}
    return max(fitting or groups, key=lambda name: len(groups[name]), default='')


def check_parameters(
    kinematics: KinematicModel, group: str, parameters: ServoParameters
) -> list[str]:
    """Return what of the parameters does not fit the robot, a sentence for each."""
    groups = tuple(kinematics.robot.semantic.groups)
    wrong = []
    for name, value in (
        ('move_group_name', group), ('active_subgroup', parameters.active_subgroup)
    ):
        if (value or name == 'move_group_name') and value not in groups:
            wrong.append(
                f"{name}: '{value}' is not a planning group "
                f"({', '.join(groups) or 'there is none'}) "
                f'{nearest(value, groups)}'.rstrip())
    if wrong:
        return wrong
    try:
        TargetVelocity(kinematics, PlanningScene(kinematics), group, parameters.active_subgroup)
    except PlanningError as error:
        wrong.append(f'active_subgroup: {error}')
    joints = len(kinematics.group_indices(group))
    if len(parameters.joint_limit_margins) not in (1, joints):
        wrong.append(
            f'joint_limit_margins has {len(parameters.joint_limit_margins)} values; allowed: 1, '
            f'or {joints}, one for each joint')
    return wrong


def build_stream(
    kinematics: KinematicModel, scene: PlanningScene, checker: CollisionChecker,
    settings: ServoNodeSettings, group: str
) -> tuple[ServoStream, list[str]]:
    """
    Return a stream of a planning group, and warnings about it.

    :param scene: is followed.
    :param group: whose joints are commanded.
    :raises ServoSettingsError: the parameters do not fit the robot.
    """
    parameters = settings.moveit_servo
    wrong = check_parameters(kinematics, group, parameters)
    if wrong:
        raise ServoSettingsError('; '.join(wrong))
    target = TargetVelocity(kinematics, scene, group, parameters.active_subgroup)
    bounds = _bounds(kinematics, target, parameters)
    smoothing, warnings = _smoothing(kinematics, target, settings, bounds)
    proximity = Proximity(
        checker, group, parameters.self_collision_proximity_threshold,
        parameters.scene_collision_proximity_threshold)
    return ServoStream(target, bounds, smoothing, proximity), warnings


def _bounds(
    kinematics: KinematicModel, target: TargetVelocity, parameters: ServoParameters
) -> JointBounds:
    indices = target.indices
    margins = np.broadcast_to(np.array(parameters.joint_limit_margins), len(indices))
    return JointBounds(
        target.names, kinematics.lower[indices] + margins, kinematics.upper[indices] - margins,
        _usable(kinematics.velocity_limits[indices], np.inf),
        _usable(kinematics.acceleration_limits[indices], DEFAULT_ACCELERATION))


def _smoothing(
    kinematics: KinematicModel, target: TargetVelocity, settings: ServoNodeSettings,
    bounds: JointBounds
) -> tuple[SmoothingFilter, list[str]]:
    parameters = settings.moveit_servo
    if not parameters.use_smoothing:
        return NoFilter(), []
    plugin = parameters.smoothing_filter_plugin_name
    if plugin == BUTTERWORTH:
        return ButterworthFilter(settings.butterworth_filter_coeff), []
    joints = [kinematics.robot.joints[name].limits for name in target.names]
    jerk = np.array([limits.jerk for limits in joints])
    lacking = [
        name for name, limits in zip(target.names, joints, strict=True)
        if not np.isfinite(limits.acceleration)
        or (plugin == RUCKIG and not np.isfinite(limits.jerk))]
    warnings = []
    if lacking:
        kinds = 'acceleration and jerk limits' if plugin == RUCKIG else 'acceleration limits'
        warnings.append(
            f'{plugin}: joint_limits.yaml has no {kinds} of {", ".join(lacking)}; '
            f'{DEFAULT_ACCELERATION:g} rad/s^2'
            + (f' and {DEFAULT_JERK:g} rad/s^3 are taken' if plugin == RUCKIG else ' is taken'))
    period = parameters.publish_period
    if settings.update_period not in (None, period):
        warnings.append(
            f'{plugin}: update_period is {settings.update_period:g} s and is not used; the filter '
            f'works every publish_period, {period:g} s')
    if plugin == RUCKIG:
        jerk = _usable(jerk, DEFAULT_JERK)
        return JerkFilter(bounds.velocity, bounds.acceleration, jerk, period), warnings
    return AccelerationFilter(bounds.velocity, bounds.acceleration, period), warnings


def _usable(limits: Vector, default: float) -> Vector:
    """Return limits with a default where there is none."""
    return np.where(np.isfinite(limits) & (limits > 0.0), limits, default)
