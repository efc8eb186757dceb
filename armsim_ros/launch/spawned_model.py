# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a model that a launch file spawns is a robot, by its text."""

import re

_COMMENT = re.compile(r'<!--.*?-->', re.DOTALL)
#: The plugin of Gazebo reads the rest from the robot_state_publisher.
_CONTROL = re.compile(r'<ros2_control\b|<plugin\b[^>]*ros2_control')
_MOVABLE_JOINT = re.compile(
    r'<joint\b[^>]*\btype\s*=\s*["\']\s*(?:revolute|continuous|prismatic)\b')


def is_urdf(text: str) -> bool:
    """Return whether a text is a URDF, or the xacro of one."""
    return '<robot' in text


def is_controlled(text: str) -> bool:
    """Return whether a model, URDF or SDF, has controllers, by an element or by a plugin."""
    return _CONTROL.search(_COMMENT.sub('', text)) is not None


def has_movable_joint(urdf: str) -> bool:
    """Return whether any joint of a URDF has one position variable."""
    return _MOVABLE_JOINT.search(_COMMENT.sub('', urdf)) is not None
