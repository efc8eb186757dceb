# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random motions among random obstacles, judged by a referee that shares no code with the planner.

``--clutter N`` plans N problems for each robot and prints success and times (with ``-s``).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.geometry import Box, Cylinder
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_from_parts, quat_xyzw_from_rpy
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, message_pose, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from benchmarks.planning.problems import Problem
from benchmarks.planning.referee import Referee

DEFAULT = 6
OBSTACLES = 7
SEVEN_LENGTHS = (0.16, 0.17, 0.2, 0.2, 0.2, 0.2, 0.1)
SEVEN_AXES = ('0 0 1', '0 1 0', '0 0 1', '0 1 0', '0 0 1', '0 1 0', '0 0 1')
LIMITS = """joint_limits:
{rows}
"""
LIMIT_ROW = """  axis_{k}:
    has_velocity_limits: true
    max_velocity: 2.0
    has_acceleration_limits: true
    max_acceleration: 4.0"""


def seven_joints(folder: Path) -> Path:
    """Write an arm of seven joints and return its folder."""
    links, joints, pairs = [], [], []
    for k in range(8):
        length = SEVEN_LENGTHS[k - 1] if k else 0.1
        links.append(
            f'<link name="link_{k}"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" '
            f'izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial><collision>'
            f'<origin xyz="0 0 {0.5 * length}"/>'
            f'<geometry><cylinder radius="0.05" length="{length}"/></geometry></collision></link>'
        )
        if k:
            before = SEVEN_LENGTHS[k - 2] if k > 1 else 0.1
            joints.append(
                f'<joint name="axis_{k}" type="revolute"><parent link="link_{k - 1}"/>'
                f'<child link="link_{k}"/><origin xyz="0 0 {before}"/>'
                f'<axis xyz="{SEVEN_AXES[k - 1]}"/>'
                '<limit lower="-2.6" upper="2.6" velocity="2" effort="80"/></joint>'
            )
            pairs += [(k - 1, k), *([(k - 2, k)] if k > 1 else [])]
    rules = ''.join(
        f'<disable_collisions link1="link_{a}" link2="link_{b}" reason="Adjacent"/>'
        for a, b in pairs
    )
    folder.mkdir()
    (folder / 'seven.urdf').write_text(
        f'<robot name="seven">{"".join([*links, *joints])}</robot>', encoding='utf-8'
    )
    (folder / 'seven.srdf').write_text(
        '<robot name="seven"><group name="manipulator"><chain base_link="link_0" '
        f'tip_link="link_7"/></group>{rules}</robot>', encoding='utf-8'
    )
    rows = '\n'.join(LIMIT_ROW.format(k=k) for k in range(1, 8))
    (folder / 'joint_limits.yaml').write_text(LIMITS.format(rows=rows), encoding='utf-8')
    return folder


@dataclass
class Bench:
    """A robot, its planner and its referee."""

    model: KinematicModel
    planner: MotionPlanner
    referee: Referee
    names: tuple[str, ...]
    reach: float
    center: np.ndarray

    def problem(self, rng: np.random.Generator, index: int) -> Problem:
        """Return a motion between two free states among random obstacles."""
        while True:
            obstacles = tuple(self._obstacle(rng, k) for k in range(OBSTACLES))
            scene = self.scene(obstacles)
            ends = []
            for _ in range(60):
                values = rng.uniform(*self._range())
                q = self.model.insert(self.model.default(), 'manipulator', values)
                if self.planner.check_state(scene, q).valid:
                    ends.append(tuple(float(value) for value in values))
                    if len(ends) == 2:
                        return Problem('clutter', index, ends[0], ends[1], obstacles)

    def scene(self, obstacles: tuple[dict[str, Any], ...]) -> PlanningScene:
        """Return a world with obstacles."""
        scene = PlanningScene(self.model)
        for each in obstacles:
            shape = (
                Box(tuple(each['size'])) if each['type'] == 'box'
                else Cylinder(radius=each['radius'], length=each['length'])
            )
            scene.apply_object(CollisionObject(
                each['id'], frame_id=scene.model_frame,
                pose=message_pose(each['position'], each['quat_xyzw']),
                shapes=(ObjectShape(shape, pose_from_parts(np.zeros(3), np.eye(3))),)))
        return scene

    def plan(self, problem: Problem) -> tuple[Any, float]:
        """Return the planner's answer and the time it took [s]."""
        scene = self.scene(problem.obstacles)
        scene.set_state(
            self.model.insert(self.model.default(), 'manipulator', np.array(problem.start))
        )
        goal = Constraints(joint_constraints=tuple(
            JointConstraint(name, value, 1e-4, 1e-4)
            for name, value in zip(self.names, problem.goal, strict=True)
        ))
        began = time.monotonic()
        answer = self.planner.plan(
            MotionPlanRequest('manipulator', (goal,), allowed_planning_time=5.0), scene,
            clock=time.monotonic,
        )
        return answer, time.monotonic() - began

    def _range(self) -> tuple[np.ndarray, np.ndarray]:
        index = self.model.group_indices('manipulator')
        return self.model.lower[index], self.model.upper[index]

    def _obstacle(self, rng: np.random.Generator, k: int) -> dict[str, Any]:
        way = rng.normal(size=3)
        place = self.center + way / np.linalg.norm(way) * rng.uniform(0.35, 1.0) * self.reach
        shape = (
            {'type': 'box', 'size': rng.uniform(0.03, 0.3, 3).tolist()} if rng.random() < 0.6
            else {'type': 'cylinder', 'radius': float(rng.uniform(0.02, 0.12)),
                  'length': float(rng.uniform(0.05, 0.6))}
        )
        turn = quat_xyzw_from_rpy(rng.uniform(-3.0, 3.0, 3))
        return {'id': f'obstacle {k}', 'position': place.tolist(), 'quat_xyzw': list(turn),
                **shape}


@pytest.fixture(scope='module', params=['sunday', 'seven'])
def bench(request: pytest.FixtureRequest, tmp_path_factory: Any) -> Bench:
    """Give a robot with all that is needed."""
    folder = Path(tmp_path_factory.mktemp(request.param))
    name = request.param
    settings = load_robot_settings(
        name if name == 'sunday' else str(seven_joints(folder / name)))
    robot = planning_robot(load_robot_model(settings), settings.joint_limits)
    model = KinematicModel(robot)
    urdf, srdf = folder / 'robot.urdf', folder / 'robot.srdf'
    urdf.write_text(robot.urdf, encoding='utf-8')
    srdf.write_text(robot.srdf, encoding='utf-8')
    joints = robot.semantic.groups['manipulator'].active_joints
    limits = [robot.joints[joint].limits for joint in joints]
    acceleration = limits[0].acceleration if np.isfinite(limits[0].acceleration) else 1.0
    referee = Referee(
        urdf, srdf, joints, velocity=limits[0].velocity, acceleration=acceleration
    )
    first = model.link_pose(model.default(), robot.semantic.groups['manipulator'].links[1])
    return Bench(model, MotionPlanner(PlanningScene(model)), referee, joints, 0.75,
                 first[:3, 3])


def test_no_trajectory_breaks_a_rule(bench: Bench, pytestconfig: pytest.Config) -> None:
    """Every returned trajectory is free, within limits, and goes from start to goal."""
    count = int(pytestconfig.getoption('clutter', None) or DEFAULT)
    rng = np.random.default_rng(7)
    times, failures = [], []
    for index in range(count):
        problem = bench.problem(rng, index)
        answer, seconds = bench.plan(problem)
        if not answer.success:
            assert answer.message
            assert not len(answer.trajectory)
            failures.append(f'{index}: {answer.error_code.name}: {answer.message}')
            continue
        times.append(seconds)
        made = answer.trajectory
        verdict = bench.referee.trajectory(
            problem, made.times, made.positions, made.velocities, made.accelerations)
        assert verdict.clean, f'problem {index}: {verdict.fault}'
    print(f'\n{len(bench.names)} joints: {len(times)} of {count} solved, median '
          f'{np.median(times) * 1e3:.0f} ms, p95 {np.quantile(times, 0.95) * 1e3:.0f} ms')
    print('\n'.join(failures))
    assert len(times) >= 0.7 * count  # what is walled in has no solution
