# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The limits of MoveIt's robot model: those that bound plans, and nothing else."""

from __future__ import annotations

from dataclasses import replace
import math

from armsim_ros.config.kinematics import JointLimitOverrides, JointLimitsSettings
from armsim_ros.model.robot_model import Joint, JointType, RobotModel


def planning_robot(robot: RobotModel, settings: JointLimitsSettings) -> RobotModel:
    """
    Return the robot with the limits that plans keep.

    These are the URDF's within the soft limits of ``<safety_controller>``, and over them those
    of joint_limits.yaml, upwards too. Drives, controllers and physics have the URDF's.
    """
    overrides = settings.joint_limits
    return replace(robot, joints={
        name: _limited(joint, overrides.get(name, JointLimitOverrides()))
        for name, joint in robot.joints.items()})


def _limited(joint: Joint, override: JointLimitOverrides) -> Joint:
    limits, soft = joint.limits, joint.soft_limits
    lower, upper = limits.lower, limits.upper
    if joint.type is not JointType.CONTINUOUS:
        if soft is not None:
            lower, upper = max(lower, soft.lower), min(upper, soft.upper)
        lower = lower if override.min_position is None else override.min_position
        upper = upper if override.max_position is None else override.max_position
    velocity = math.inf if override.has_velocity_limits is False else limits.velocity
    return replace(joint, limits=replace(
        limits, lower=lower, upper=upper,
        velocity=velocity if override.velocity is None else override.velocity,
        acceleration=math.inf if override.acceleration is None else override.acceleration,
        jerk=math.inf if override.jerk is None else override.jerk))
