# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""This package: from a request to a timed trajectory that was checked."""

from __future__ import annotations

import pathlib
import sys
import time
from typing import Any

sys.path.insert(1, str(pathlib.Path(__file__).resolve().parents[3]))

from worker import serve

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.geometry import Box, Cylinder
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.planning.context import settings_from_config
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState


class Planner:
    """One planner for all problems, as in a running move_group."""

    def __init__(self, robot: dict[str, Any]) -> None:
        settings = load_robot_settings(robot['folder'])
        self.robot = robot
        self.model = KinematicModel(
            planning_robot(load_robot_model(settings), settings.joint_limits))
        self.scene = PlanningScene(self.model)
        self.planner = MotionPlanner(self.scene, settings=settings_from_config(
            settings.planning_parameters, settings.pipelines, settings.kinematics))
        self.planner.prepare()

    def prepare(self, problem: dict[str, Any]) -> None:
        """Change the scene as a client does, and let the planner see it."""
        self.scene.clear()
        for each in problem['obstacles']:
            shape = (
                Box(tuple(each['size'])) if each['type'] == 'box'
                else Cylinder(each['radius'], each['length']))
            self.scene.apply_object(CollisionObject(
                each['id'], 0, self.scene.model_frame,
                pose=pose_from_quat_xyzw(each['position'], each['quat_xyzw']),
                shapes=(ObjectShape(shape),)))
        self.planner.check_state(self.scene.snapshot(), self.scene.q)

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Answer a request."""
        names = tuple(self.robot['joints'])
        goal = Constraints(tuple(
            JointConstraint(name, value, 1e-4, 1e-4)
            for name, value in zip(names, problem['goal'], strict=True)))
        response = self.planner.plan(
            MotionPlanRequest(
                self.robot['group'], (goal,), StartState(names, tuple(problem['start'])),
                allowed_planning_time=seconds, seed=seed),
            self.scene.snapshot(), clock=time.monotonic)
        if not response.success:
            return {'message': response.message}
        made = response.trajectory
        return {
            'length': response.path_length, 'times': made.times, 'positions': made.positions,
            'velocities': made.velocities, 'accelerations': made.accelerations,
        }


if __name__ == '__main__':
    serve(Planner)
