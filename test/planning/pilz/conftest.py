# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A UR5 that plans PTP, LIN and CIRC."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.geometry import Sphere
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_from_parts, quat_xyzw_from_matrix
from armsim_ros.planning.pilz.sequence import SequenceItem
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.quintic_motion import QuinticMotion

GROUP, TIP = 'manipulator', 'tool0'
START = (0.3, -0.9, 1.2, 0.2, 0.9, 0.1)


class Bench:
    """A UR5 at a start state and requests for it."""

    def __init__(self) -> None:
        settings = load_robot_settings('ur5')
        robot = planning_robot(load_robot_model(settings), settings.joint_limits)
        self.model = KinematicModel(robot)
        self.scene = PlanningScene(self.model)
        self.planner = MotionPlanner(self.scene)
        self.names = robot.semantic.groups[GROUP].active_joints
        self.q = self.model.insert(self.model.default(), GROUP, START)
        self.scene.set_state(self.q)
        self.pose = self.model.link_pose(self.q, TIP)

    def moved(self, *offset: float) -> Any:
        """Return the tip's pose, moved [m]."""
        return pose_from_parts(self.pose[:3, 3] + np.array(offset), self.pose[:3, :3])

    def request(self, command: str, goal: Constraints, **options: Any) -> MotionPlanRequest:
        """Return the request for a command, at a tenth of the limits."""
        usual = {
            'goal_constraints': (goal,), 'pipeline_id': 'pilz_industrial_motion_planner',
            'max_velocity_scaling_factor': 0.1, 'max_acceleration_scaling_factor': 0.1,
        }
        return MotionPlanRequest(GROUP, planner_id=command, **{**usual, **options})

    def run(self, command: str, goal: Constraints, **options: Any) -> Any:
        """Plan a command."""
        request = self.request(command, goal, **options)
        return self.planner.plan(request, self.scene.snapshot(), clock=time.monotonic)

    def sequence(self, *items: SequenceItem) -> Any:
        """Plan several motions."""
        return self.planner.plan_sequence(items, self.scene.snapshot(), clock=time.monotonic)

    def joints(self, values: Any) -> Constraints:
        """Return a goal of joint positions [rad]."""
        return Constraints(joint_constraints=tuple(
            JointConstraint(name, float(value), 1e-3, 1e-3)
            for name, value in zip(self.names, values, strict=False)
        ))

    def at(self, pose: Any, link: str = TIP, name: str = '') -> Constraints:
        """Return a goal pose (4, 4), or with a name the point of an arc."""
        region = Region(Sphere(1e-3), pose_from_parts(pose[:3, 3], np.eye(3)))
        return Constraints(
            position_constraints=(PositionConstraint(link, (region,), 'base_link'),),
            orientation_constraints=() if name else (OrientationConstraint(
                link, tuple(quat_xyzw_from_matrix(pose)), (1e-3,) * 3, 'base_link'
            ),),
            name=name,
        )

    def tips(self, trajectory: Any) -> Any:
        """Return where the tip is along a trajectory, between its points too (k, 3)."""
        motion = QuinticMotion.of(trajectory)
        return np.array([
            self.model.link_pose(self.model.insert(self.q, GROUP, values), TIP)[:3, 3]
            for values in motion.sample(np.linspace(0.0, motion.duration, 300))
        ])


@pytest.fixture(scope='module')
def built() -> Bench:
    """Build the robot once."""
    return Bench()


@pytest.fixture
def bench(built: Bench) -> Bench:
    """Give the robot at its start in an empty world."""
    built.scene.clear()
    built.scene.set_state(built.q)
    return built
