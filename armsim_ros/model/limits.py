# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Limits of joint_limits.yaml laid over those of the URDF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
import math

from armsim_ros.config.joint_limits import JointLimitOverrides
from armsim_ros.model.robot_model import Joint, JointType


def apply_limits(joints: Mapping[str, Joint], overrides: Mapping[str, JointLimitOverrides]
                 ) -> dict[str, Joint]:
    """
    Return the joints with their limits replaced.

    The file wins over the URDF, upwards too; position limits of a continuous joint are left
    out, it has none.
    """
    return {name: _limited(joint, overrides[name]) if name in overrides else joint
            for name, joint in joints.items()}


def _limited(joint: Joint, override: JointLimitOverrides) -> Joint:
    limits = joint.limits
    lower, upper = override.position
    if joint.type is JointType.CONTINUOUS:
        lower, upper = None, None
    return replace(joint, limits=replace(
        limits,
        lower=limits.lower if lower is None else lower,
        upper=limits.upper if upper is None else upper,
        velocity=override.velocity or _kept(limits.velocity, override.has_velocity_limits),
        acceleration=override.acceleration or math.inf,
        jerk=override.jerk or math.inf,
    ))


def _kept(value: float, has_limits: bool | None) -> float:
    """Return the URDF's bound, infinite where the file says that there is none."""
    return math.inf if has_limits is False else value
