# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What only a camera sees is avoided, by programs whose time a client moves."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
import itertools
import json
from pathlib import Path
from typing import Any

from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
import numpy as np
import pytest
from shape_msgs.msg import SolidPrimitive
from world_user import OK, pose, READY, WorldUser

from armsim_ros import ArmSim
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.move_group import MoveGroupClient
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.conversions.octomap import octomap_from_message
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.objects import CollisionObject as SceneObject
from armsim_ros.planning.scene.objects import ObjectShape
from armsim_ros.testing.program import private_domain, start_program

PATIENCE = 120.0
#: Steps of a millisecond between two pictures.
PERIOD = 200
OCTOMAP = 32
#: What the map leaves open about the border of what was seen [m].
HALF_CELL = 0.0125
UNKNOWN = ('camera:=true', 'octomap:=true', 'scene_from_world:=false', 'mode:=lockstep', 'seed:=0')
SMALL = {'width': 160, 'height': 120, 'rate': 5}


@dataclass(frozen=True)
class Task:
    """
    A motion with something in its way, and where the arm has to be for a camera to see it.

    :param size: of a box [m].
    :param place: of its middle.
    """

    robot: str
    group: str
    tool: str
    cameras: dict[str, Any]
    view: tuple[float, ...]
    start: tuple[float, ...]
    goal: tuple[float, ...]
    size: tuple[float, float, float]
    place: tuple[float, float, float]

    def joints(self, positions: tuple[float, ...]) -> dict[str, float]:
        """Return joint positions by name."""
        prefix = 'panda_joint' if self.robot == 'panda' else 'joint_'
        return {f'{prefix}{number}': value for number, value in enumerate(positions, 1)}


def _turned(first: float, others: tuple[float, ...]) -> tuple[float, ...]:
    return first, *others


_READY = (0.3, 1.6, 0.2708, 1.57, 0.0)
_BENT = (0.35, 0.0, -1.9, 0.0, 2.25, 0.785)
SUNDAY = Task(
    'sunday', 'manipulator', 'link_6', {'camera': {'focal_length': 0.966657, **SMALL}},
    (0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0), _turned(-0.8, _READY), _turned(0.8, _READY),
    (0.05, 0.05, 0.28), (0.166, 0.16, 1.155))
PANDA = Task(
    'panda', 'panda_arm', 'panda_hand',
    {'eye': {'link': 'panda_link0', 'xyz': [2.0, 0, 0.9], 'rpy': [0, 0.25, 3.1416], **SMALL},
     'back': {'link': 'panda_link0', 'xyz': [-1.0, 0, 1.4], 'rpy': [0, 0.55, 0], **SMALL}},
    _turned(-0.9, _BENT), _turned(-0.9, _BENT), _turned(0.9, _BENT),
    (0.12, 0.12, 0.3), (0.45, 0.0, 0.45))


class Watcher(WorldUser):
    """Moves time and the arm, and knows what the camera does not tell the planner."""

    def __init__(self, client: ClientNode, program: Any, task: Task) -> None:
        super().__init__(client, program, Path())
        self.task, self.move_group = task, MoveGroupClient(client)
        self._sim = ArmSim(task.robot, overrides={
            'planning_parameters.scene_from_world': 'false'})
        self._sim.scene.apply_object(SceneObject(
            'post', pose=pose_matrix(task.place), shapes=(ObjectShape(Box(task.size)),)))
        self._truth = CollisionChecker(self._sim.scene)
        self._pool = ThreadPoolExecutor(1)

    def step(self, pictures: int = 1) -> None:
        """Let pictures become due."""
        code, text = self.result('step_simulation', steps=pictures * PERIOD)
        assert code == OK, text

    def plan(self, positions: tuple[float, ...]) -> tuple[Any, bool]:
        """Return a motion, and whether it passes through the post, deeper than cells can tell."""
        answer = self.move_group.plan(
            self.task.group, self.task.joints(positions), allowed_planning_time=20.0)
        assert answer.error_code.val == SUCCESS, answer.error_code.message
        motion = answer.planned_trajectory.joint_trajectory
        model, here = self._sim.scene.kinematic_model, self._sim.scene.q
        points = [np.array(point.positions) for point in motion.points]
        return answer.planned_trajectory, any(
            contact.depth > HALF_CELL
            for before, after in itertools.pairwise(points) for share in (0.0, 0.25, 0.5, 0.75)
            for contact in self._truth.contacts(model.vector(dict(zip(
                motion.joint_names, before + share * (after - before), strict=True)), here)))

    def go(self, positions: tuple[float, ...], *, around: bool = True) -> None:
        """Move the arm, around the post if it is there; the arm does not block itself then."""
        trajectory, touched = self.plan(positions)
        assert not (around and touched)
        moving = self._pool.submit(self.move_group.execute, trajectory)
        while not moving.done():
            self.step()
        assert moving.result().error_code.val == SUCCESS
        assert self.move_group.valid(self.task.group, self.task.joints(positions))

    def put(self) -> None:
        """Put the post into the world."""
        uri = f"armsim://box?size={','.join(map(str, self.task.size))}"
        assert self.spawn('post', self.task.place, uri).result.result == OK

    def cells(self) -> int:
        """Return how many occupied cells are in the upper half of the post."""
        request = GetPlanningScene.Request()
        request.components.components = OCTOMAP
        scene = self.client.call('/get_planning_scene', GetPlanningScene, request).scene
        update = octomap_from_message(scene.world.octomap, is_diff=False)
        assert update is not None
        if update.octomap is None:
            return 0
        apart = update.octomap.boxes[0] - self.task.place
        half = 0.5 * np.array(self.task.size) + HALF_CELL
        return int(((np.abs(apart) <= half).all(axis=1) & (apart[:, 2] > 0.0)).sum())

    def hold(self, *, attach: bool) -> None:
        """Let the planning scene know that the tool holds the post, or nothing any more."""
        kind = CollisionObject.ADD if attach else CollisionObject.REMOVE
        held = AttachedCollisionObject(link_name=self.task.tool)
        held.object = CollisionObject(id='post', operation=kind, primitives=[SolidPrimitive(
            type=SolidPrimitive.BOX, dimensions=self.task.size)], primitive_poses=[
                pose((0, 0, 0))], pose=pose(self.task.place))
        held.object.header.frame_id = self._sim.scene.model_frame
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        scene.robot_state.attached_collision_objects = [held]
        answer = self.client.call(
            '/apply_planning_scene', ApplyPlanningScene, ApplyPlanningScene.Request(scene=scene))
        assert answer.success


@contextmanager
def watching(task: Task) -> Iterator[Watcher]:
    """Bring up a robot whose planner knows only what cameras see."""
    overrides = json.dumps({'simulation.cameras': task.cameras})
    with (
        private_domain() as domain,
        start_program('bringup', domain, f'robot:={task.robot}', f'overrides:={overrides}',
                      *UNKNOWN) as program,
    ):
        program.wait_for_line(READY, PATIENCE)
        program.wait_for_line('drawn by', PATIENCE)
        with ClientNode(domain, 'watcher') as client:
            yield Watcher(client, program, task)


@pytest.mark.parametrize('task', [SUNDAY, PANDA], ids=['shipped cell', 'panda'])
def test_what_only_the_camera_sees_is_avoided(drawing: None, task: Task) -> None:
    """Until it is away, or held; after each step the map has the pictures of the step."""
    with watching(task) as user:
        user.go(task.start, around=False)
        assert user.plan(task.goal)[1]
        user.go(task.view, around=False)
        user.put()
        for _ in range(50):  # until the camera's topic has found its subscription
            user.step()
            if user.cells():
                break
        assert user.cells() > 5
        assert user.result('delete_entity', entity='post')[0] == OK
        user.step(pictures=9)
        assert user.cells() == 0

        user.put()
        user.step(pictures=6)  # what was seen free is occupied when it was hit three times
        assert user.cells() > 5
        user.go(task.start)
        user.go(task.goal)

        user.go(task.view)
        user.hold(attach=True)
        assert user.cells() == 0
        user.step(pictures=2)
        assert user.cells() == 0
        assert user.move_group.valid(task.group, task.joints(task.view))
