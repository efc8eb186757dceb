# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What it costs to check a state in a cluttered scene: by itself, as a service, and in IK."""

from __future__ import annotations

from collections.abc import Callable
import time

from geometry_msgs.msg import Pose
from moveit_msgs.msg import CollisionObject as ObjectMessage
from moveit_msgs.msg import PlanningScene as SceneMessage
from moveit_msgs.srv import ApplyPlanningScene, GetStateValidity
import numpy as np
from shape_msgs.msg import SolidPrimitive

from armsim_ros.arrays import Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.queries import IKRequest, LinkPose
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from benchmarks.options import Options
from benchmarks.planning.planned_robot import planner_of
from benchmarks.stack import processor_seconds, running_stack, Stack

STATES, OBJECTS, POSES = 1000, 12, 100
SIDES, DISTANCE, HEIGHT = (0.05, 0.25), (0.35, 0.8), (0.0, 0.8)

ScatteredBox = tuple[str, tuple[float, float, float], Vector]
"""Name, sides and position (3,) [m]."""


def main(options: Options) -> None:
    """Print the processor time per state and per request, the least of ``--runs``."""
    planner, scene = planner_of(options.robot)
    model = scene.kinematic_model
    group = next(iter(model.robot.semantic.groups))
    rng = np.random.default_rng(options.seed)
    boxes = _boxes(rng)
    for name, sides, position in boxes:
        scene.apply_object(CollisionObject(
            name, 0, scene.model_frame, pose=pose_matrix(position),
            shapes=(ObjectShape(Box(sides)),)))
    indices = model.group_indices(group)
    low = np.maximum(model.lower, -np.pi)[indices]
    high = np.minimum(model.upper, np.pi)[indices]
    states = [model.insert(scene.q, group, values)
              for values in rng.uniform(low, high, (STATES, len(indices)))]
    held = scene.snapshot()
    valid = [planner.check_state(held, q, group).valid for q in states]
    free = [q for q, each in zip(states, valid, strict=True) if each]
    colliding = [q for q, each in zip(states, valid, strict=True) if not each]
    print(f'{options.robot}, group {group}: {STATES} random states among {OBJECTS} boxes, '
          f'{len(free)} of them valid')
    for name, chosen in (('all', states), ('valid', free), ('colliding', colliding)):
        if chosen:
            _print(f'check of {name} states', options.runs, len(chosen),
                   lambda chosen=chosen: [  # type: ignore[misc]
                       planner.check_state(held, q, group) for q in chosen])
    _inverse(planner, held, group, free, options.runs)
    with running_stack(f'robot:={options.robot}') as stack:
        _service(stack, model, group, states, boxes, options.runs)


def _boxes(rng: np.random.Generator) -> list[ScatteredBox]:
    """Return boxes around the base."""
    boxes: list[ScatteredBox] = []
    for number in range(OBJECTS):
        angle, distance = rng.uniform(-np.pi, np.pi), rng.uniform(*DISTANCE)
        x, y, z = map(float, rng.uniform(*SIDES, 3))
        boxes.append((f'box_{number}', (x, y, z), np.array([
            distance * np.cos(angle), distance * np.sin(angle), rng.uniform(*HEIGHT)])))
    return boxes


def _print(
    name: str, runs: int, count: int, work: Callable[[], object],
    clock: Callable[[], float] = time.process_time, unit: str = 'CPU',
) -> None:
    spent = []
    for _ in range(max(runs, 1)):
        began = clock()
        work()
        spent.append(clock() - began)
    print(f'{name}: {1e6 * min(spent) / count:.1f} us {unit}')


def _inverse(
    planner: MotionPlanner, scene: PlanningScene, group: str, states: list[Vector], runs: int
) -> None:
    model = scene.kinematic_model
    tip = model.robot.semantic.groups[group].links[-1]
    seed = StartState.from_positions(model.positions(model.default()))
    requests = [
        IKRequest(group, (LinkPose('', model.link_pose(q, tip)),), seed, avoid_collisions=True,
                  timeout=1.0)
        for q in states[:POSES]]
    _print('compute_ik without collisions', runs, len(requests), lambda: [
        planner.compute_ik(request, scene, clock=time.monotonic) for request in requests])


def _service(
    stack: Stack, model: KinematicModel, group: str, states: list[Vector],
    boxes: list[ScatteredBox], runs: int,
) -> None:
    objects = []
    for name, sides, position in boxes:
        message = ObjectMessage(id=name, operation=ObjectMessage.ADD)
        message.header.frame_id = model.robot.model_frame
        message.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(sides))]
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z = map(float, position)
        message.primitive_poses = [pose]
        objects.append(message)
    scene = SceneMessage(is_diff=True)
    scene.world.collision_objects = objects
    stack.client.call(
        '/apply_planning_scene', ApplyPlanningScene, ApplyPlanningScene.Request(scene=scene))
    requests = []
    for q in states:
        request = GetStateValidity.Request(group_name=group)
        positions = model.positions(q)
        request.robot_state.joint_state.name = list(positions)
        request.robot_state.joint_state.position = list(positions.values())
        requests.append(request)
    process = stack.processes()['move_group']

    def call_all() -> None:
        for request in requests:
            stack.client.call('/check_state_validity', GetStateValidity, request)

    call_all()
    _print('check_state_validity, all of move_group', runs, len(requests), call_all,
           lambda: processor_seconds(process))
    _print('check_state_validity, from call to response', runs, len(requests), call_all,
           time.monotonic, 'real time')
