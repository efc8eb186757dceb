# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Random edits of a simulated world and of the planning scene, and what the rules make of them."""

from __future__ import annotations

from collections.abc import Callable
import random
import time

from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import CollisionObject, PlanningScene, PlanningSceneComponents
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from shape_msgs.msg import SolidPrimitive
from simulation_interfaces.msg import EntityState
from simulation_interfaces.srv import DeleteEntity, ResetSimulation, SetEntityState, SpawnEntity

from armsim_ros.clients.client_node import ClientNode

Place = tuple[float, float, float]

#: Names that both sides use, and one that the world alone uses.
NAMES = tuple(f'edited_{letter}' for letter in 'abcdef')
SENTINEL = 'sentinel'
SHAPE = 'armsim://box?size=0.1,0.1,0.1'
#: The scene is waited for so long [s]; what differs by less is the same place [m].
PATIENCE, SAME = 60.0, 2e-3


class SceneEdits:
    """
    Edits both sides by turns and keeps account of what the scene has to be.

    After each edit of the world it waits for a sentinel that is moved after it, so that what was
    told has been heard.

    :param client: of a running stack.
    :param seed: of the random numbers.
    """

    def __init__(self, client: ClientNode, seed: int) -> None:
        self._client = client
        self._random = random.Random(seed)
        self._world: dict[str, Place] = {}
        self._start: dict[str, Place] = {}
        self._owner: dict[str, str] = {}
        self._user: dict[str, Place] = {}
        self.counts: dict[str, int] = {}
        """How often each kind of edit was made."""

    @property
    def expected(self) -> dict[str, Place]:
        """What the rules say: name -> where it is in the scene."""
        return {**{name: place for name, place in self._world.items()
                   if self._owner[name] == 'world'}, **self._user}

    def run(self, count: int) -> None:
        """
        Make so many edits.

        :raises AssertionError: the scene is not what the rules say.
        """
        self._spawn(SENTINEL)
        self._wait('a sentinel was spawned')
        for number in range(count):
            name = self._random.choice(NAMES)
            edit = self._random.choice(self._possible(name))
            kind = edit.__name__.strip('_')
            self.counts[kind] = self.counts.get(kind, 0) + 1
            edit(name)
            if edit in (self._spawn, self._delete, self._move, self._reset):
                self._move(SENTINEL)
            self._wait(f'edit {number + 1}: {kind} {name}')

    def clear(self) -> None:
        """Take away all that is left, on both sides."""
        for name in tuple(self._world):
            self._delete(name)
        for name in tuple(self._user):
            self._edit(name, CollisionObject.REMOVE)
        self._user.clear()
        self._wait('all was taken away')

    def _possible(self, name: str) -> list[Callable[[str], None]]:
        """Return what can be done to a name; a reset is rare."""
        edits: list[Callable[[str], None]] = [self._add] * 2
        edits += [self._delete, self._move, self._move] if name in self._world else [
            self._spawn, self._spawn]
        # Whether the world's object comes where the user removes his older one is not said.
        if name in self.expected and self._owner.get(name) != 'foreign':
            edits += [self._remove, self._remove]
        if name in self.expected:
            edits += [self._shift]
        return edits * 4 + [self._reset]

    def _spawn(self, name: str) -> None:
        place = self._place()
        request = SpawnEntity.Request(name=name, uri=SHAPE)
        request.initial_pose = PoseStamped(pose=_pose(place))
        result = self._client.call('/spawn_entity', SpawnEntity, request, timeout=PATIENCE).result
        assert result.result == result.RESULT_OK, result.error_message
        self._world[name] = self._start[name] = place
        self._owner[name] = 'foreign' if name in self._user else 'world'

    def _delete(self, name: str) -> None:
        result = self._client.call('/delete_entity', DeleteEntity, DeleteEntity.Request(
            entity=name), timeout=PATIENCE).result
        assert result.result == result.RESULT_OK, result.error_message
        del self._world[name], self._owner[name]

    def _move(self, name: str) -> None:
        self._world[name] = self._place()
        request = SetEntityState.Request(
            entity=name, state=EntityState(pose=_pose(self._world[name])))
        result = self._client.call(
            '/set_entity_state', SetEntityState, request, timeout=PATIENCE).result
        assert result.result == result.RESULT_OK, result.error_message

    def _reset(self, _: str) -> None:
        request = ResetSimulation.Request(scope=ResetSimulation.Request.SCOPE_STATE)
        result = self._client.call(
            '/reset_simulation', ResetSimulation, request, timeout=PATIENCE).result
        assert result.result == result.RESULT_OK, result.error_message
        self._world = {name: self._start[name] for name in self._world}
        for name, owner in self._owner.items():
            if owner == 'taken':
                self._user.pop(name, None)
                self._owner[name] = 'world'
            elif owner == 'removed':
                self._owner[name] = 'world'

    def _add(self, name: str) -> None:
        self._user[name] = self._place()
        self._edit(name, CollisionObject.ADD)
        if self._owner.get(name) in ('world', 'removed'):
            self._owner[name] = 'taken'

    def _shift(self, name: str) -> None:
        self._user[name] = self._place()
        self._edit(name, CollisionObject.MOVE)
        if self._owner.get(name) == 'world':
            self._owner[name] = 'taken'

    def _remove(self, name: str) -> None:
        self._edit(name, CollisionObject.REMOVE)
        self._user.pop(name, None)
        if self._owner.get(name) == 'world':
            self._owner[name] = 'removed'

    def _edit(self, name: str, operation: bytes) -> None:
        """Edit the scene as a user does."""
        item = CollisionObject(id=name, operation=operation)
        item.header.frame_id = 'world'
        if operation != CollisionObject.REMOVE:
            item.pose = _pose(self._user[name])
        if operation == CollisionObject.ADD:
            item.primitives.append(
                SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.2, 0.2, 0.2]))
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        scene.world.collision_objects.append(item)
        assert self._client.call(
            '/apply_planning_scene', ApplyPlanningScene,
            ApplyPlanningScene.Request(scene=scene), timeout=PATIENCE).success

    def _wait(self, what: str) -> None:
        end = time.monotonic() + PATIENCE
        while not _same(found := self._found(), self.expected):
            assert time.monotonic() < end, (
                f'{what}: the scene has {found}, and by the rules {self.expected}')

    def _found(self) -> dict[str, Place]:
        """Return where the edited objects are in the scene."""
        components = PlanningSceneComponents(
            components=PlanningSceneComponents.WORLD_OBJECT_GEOMETRY)
        scene = self._client.call(
            '/get_planning_scene', GetPlanningScene,
            GetPlanningScene.Request(components=components), timeout=PATIENCE).scene
        return {one.id: (one.pose.position.x, one.pose.position.y, one.pose.position.z)
                for one in scene.world.collision_objects if one.id in (*NAMES, SENTINEL)}

    def _place(self) -> Place:
        """Return a place away from the robot; no two are the same."""
        x, y, z = (self._random.uniform(2.0, 9.0) for _ in range(3))
        return x, y, z


def _pose(place: Place) -> Pose:
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = place
    return pose


def _same(first: dict[str, Place], second: dict[str, Place]) -> bool:
    return first.keys() == second.keys() and all(
        max(abs(a - b) for a, b in zip(first[name], second[name], strict=True)) < SAME
        for name in first)
