# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A physically simulated robot arm behind the interfaces of ros2_control and MoveIt.

What a program needs that uses the arm as a library; ``docs/library.md`` shows how. A name is
imported when it is first asked for, so that a program pays only for what it uses.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsim_ros.errors import (
        ArmsimError,
        ConfigError,
        ControllerError,
        ModelError,
        MoveItErrorCode,
        PlanningError,
        SimulationError,
        TrajectoryError,
    )
    from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Mesh, Sphere
    from armsim_ros.model.transforms import pose_from_quat_xyzw, pose_matrix
    from armsim_ros.model.world_objects import WorldObject
    from armsim_ros.planning.planner import MotionPlanner
    from armsim_ros.planning.request import Constraints, MotionPlanRequest, MotionPlanResponse
    from armsim_ros.stack import ArmSim
    from armsim_ros.trajectory import JointTrajectory

_MODULES = {
    'errors': (
        'ArmsimError', 'ConfigError', 'ControllerError', 'ModelError', 'MoveItErrorCode',
        'PlanningError', 'SimulationError', 'TrajectoryError'),
    'model.geometry': ('Box', 'Capsule', 'Cone', 'Cylinder', 'Mesh', 'Sphere'),
    'model.transforms': ('pose_from_quat_xyzw', 'pose_matrix'),
    'model.world_objects': ('WorldObject',),
    'planning.planner': ('MotionPlanner',),
    'planning.request': ('Constraints', 'MotionPlanRequest', 'MotionPlanResponse'),
    'stack': ('ArmSim',),
    'trajectory': ('JointTrajectory',),
}
_HOMES = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    'ArmSim',
    'ArmsimError',
    'Box',
    'Capsule',
    'Cone',
    'ConfigError',
    'Constraints',
    'ControllerError',
    'Cylinder',
    'JointTrajectory',
    'Mesh',
    'ModelError',
    'MotionPlanRequest',
    'MotionPlanResponse',
    'MotionPlanner',
    'MoveItErrorCode',
    'PlanningError',
    'SimulationError',
    'Sphere',
    'TrajectoryError',
    'WorldObject',
    'pose_from_quat_xyzw',
    'pose_matrix',
]


def __getattr__(name: str) -> object:
    """Return a public name; it is imported now."""
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value: object = getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted({*globals(), *__all__})
