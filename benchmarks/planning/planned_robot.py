# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot as move_group plans for it, and its planner, in the process of a benchmark."""

from __future__ import annotations

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.log import Log
from armsim_ros.model.loading import load_robot_model
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.scene.planning_scene import PlanningScene


def kinematics_of(robot: str) -> KinematicModel:
    """Return the kinematic model of a robot by its name or folder, with the limits of plans."""
    settings = load_robot_settings(robot)
    return KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))


def planner_of(robot: str, log: Log | None = None) -> tuple[MotionPlanner, PlanningScene]:
    """Return a planner that is ready, with the settings of a robot's files, and its scene."""
    settings, scene = load_robot_settings(robot), PlanningScene(kinematics_of(robot))
    planner = MotionPlanner(scene, settings=settings_from_config(
        settings.planning_parameters, settings.pipelines, settings.kinematics), log=log)
    planner.prepare()
    return planner, scene


def states_of(model: KinematicModel) -> tuple[str, dict[str, dict[str, float]]]:
    """Return the first planning group with several named states, and these by name."""
    return next((name, states) for name, states in model.robot.semantic.named_states.items()
                if len(states) > 1)
