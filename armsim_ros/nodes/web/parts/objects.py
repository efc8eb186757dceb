# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene: its objects, shown and edited."""

from __future__ import annotations

import asyncio
import base64
import binascii
import json
from typing import Any
from weakref import WeakKeyDictionary

from geometry_msgs.msg import Point, Pose
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    AttachedCollisionObject,
    CollisionObject,
    PlanningScene,
    PlanningSceneComponents,
)
from moveit_msgs.srv import ApplyPlanningScene
import numpy as np
from rclpy.qos import QoSProfile
from shape_msgs.msg import Mesh, MeshTriangle, SolidPrimitive
from std_msgs.msg import String

from armsim_ros.clients.description import tip_of
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.objects_drawing import drawn_objects, ObjectsDrawing
from armsim_ros.nodes.web.page import Page, Part, Session
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.object_commands import (
    Add,
    AddMesh,
    Allow,
    Change,
    Load,
    Named,
    object_from_dict,
    object_to_dict,
    Save,
    Select,
)
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.shapes import parts_of_file

#: Sizes of new objects: the dimensions of a SolidPrimitive [m].
_SIZES = {'box': [0.1, 0.1, 0.1], 'sphere': [0.06], 'cylinder': [0.15, 0.05]}
_TYPES = {'box': SolidPrimitive.BOX, 'sphere': SolidPrimitive.SPHERE,
          'cylinder': SolidPrimitive.CYLINDER}
#: A mesh with a side longer than this was drawn in millimetres [m].
_LARGEST_MESH = 10.0
_MOST_TRIANGLES = 100_000
_NEWS = QoSProfile(depth=100)
_PAUSE = 0.05
#: How often the reason of a refused change is checked for, a pause between.
_REASON_LOOKS = 10


class ObjectsPart(Part):
    """Shows world objects and attached ones, and changes them through apply_planning_scene."""

    def __init__(self, page: Page, robot_part: RobotPart, goals: GoalPart) -> None:
        super().__init__(page)
        self._goals, self._robot_part = goals, robot_part
        self._drawing = ObjectsDrawing(page.scene, robot_part.reader, robot_part.node_of,
                                       self._clicked)
        self._handles: WeakKeyDictionary[Session, Any] = WeakKeyDictionary()
        self._touched: WeakKeyDictionary[Session, set[str]] = WeakKeyDictionary()
        self._chosen: WeakKeyDictionary[Session, str] = WeakKeyDictionary()
        self._changed = asyncio.Event()
        goals.on_touching = self._paint
        self._reason = ''
        page.link.subscribe(String, '/rejected_scene_changes', qos.EVENTS, self._refused)
        page.link.subscribe(PlanningScene, '/monitored_planning_scene', _NEWS, self._notice)

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {
            'add': (Add, self._add), 'add_mesh': (AddMesh, self._add_mesh),
            'change': (Change, self._change), 'remove': (Named, self._remove),
            'attach': (Named, self._attach), 'detach': (Named, self._detach),
            'select': (Select, self._select), 'allow': (Allow, self._allow),
            'load_scene': (Load, self._load), 'save_scene': (Save, self._save),
        }

    def on_program(self, name: str, there: bool) -> None:
        """Read the scene of a new move_group."""
        if name == 'move_group' and there:
            self._changed.set()

    def on_robot(self, robot: RobotModel) -> None:
        """Move the objects into the frames of another robot."""
        self._drawing.forget()
        self._changed.set()

    async def run(self) -> None:
        """Read the scene after every change of it."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            try:
                await self._read()
            except ArmsimError:
                await asyncio.sleep(0.5)  # the watch reports that move_group is gone
            await asyncio.sleep(_PAUSE)

    def _notice(self, message: Any) -> None:
        """Note, in the link's thread, that objects have changed."""
        state = message.robot_state
        if (not message.is_diff or message.world.collision_objects or message.object_colors
                or state.attached_collision_objects):
            self.page.soon(self._changed.set)

    def _refused(self, message: Any) -> None:
        """Show all sessions, from the link's thread, why a change of the scene was refused."""
        def show() -> None:
            self._reason = message.data
            for session in self.page.sessions.values():
                session.note(message.data)

        self.page.soon(show)

    async def _read(self) -> None:
        parts = PlanningSceneComponents
        scene = await self.page.planning_scene(
            parts.WORLD_OBJECT_NAMES | parts.WORLD_OBJECT_GEOMETRY
            | parts.ROBOT_STATE_ATTACHED_OBJECTS | parts.OBJECT_COLORS)
        self._drawing.show(drawn_objects(scene))
        self._touched.clear()
        self._goals.look_again()
        self.page.publish('objects', [item.form() for item in self._drawing.objects.values()])
        for session, name in list(self._chosen.items()):
            if name and name not in self._drawing.objects:
                await self._select(session, Select())

    async def _apply(self, *objects: Any, attached: Any = None) -> None:
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        scene.world.collision_objects = list(objects)
        if attached is not None:
            scene.robot_state.attached_collision_objects = [attached]
        self._reason = ''
        answer = await self.page.call(ApplyPlanningScene, '/apply_planning_scene',
                                      ApplyPlanningScene.Request(scene=scene))
        if not answer.success:
            for _ in range(_REASON_LOOKS):
                if not self._reason:
                    await asyncio.sleep(_PAUSE)
            raise ArmsimError(
                self._reason or 'move_group refused the change of the scene; see its log')
        self._changed.set()

    def _new(self, kind: str) -> Any:
        """Return an object with a unique name in front of the robot."""
        robot = self.page.robot
        if robot is None:
            raise ArmsimError('waiting for /robot_description')
        number = 1
        while f'{kind}_{number}' in self._drawing.objects:
            number += 1
        message = CollisionObject(id=f'{kind}_{number}', operation=CollisionObject.ADD)
        message.header.frame_id = robot.model_frame
        place = self._robot_part.place_before()
        position = message.pose.position
        position.x, position.y, position.z = (round(float(part), 3) for part in place)
        message.pose.orientation.w = 1.0
        return message

    async def _add(self, session: Session, command: Add) -> None:
        message = self._new(command.shape)
        message.primitives = [SolidPrimitive(type=_TYPES[command.shape],
                                             dimensions=_SIZES[command.shape])]
        message.primitive_poses = [_unit()]
        await self._apply(message)
        await self._read()
        await self._select(session, Select(id=message.id))

    async def _add_mesh(self, session: Session, command: AddMesh) -> None:
        try:
            data = base64.b64decode(command.data, validate=True)
            kind = command.name.rpartition('.')[2].lower()
            parts = await asyncio.to_thread(parts_of_file, data, kind)
        except (ValueError, binascii.Error, KeyError) as error:
            raise ArmsimError(f"'{command.name}' cannot be read: {error}") from None
        except Exception as error:  # noqa: BLE001 - the readers raise what they like
            raise ArmsimError(f"'{command.name}' is not a mesh that is read: {error}") from None
        count = sum(len(part.faces) for part in parts)
        if count > _MOST_TRIANGLES:
            raise ArmsimError(f"'{command.name}' has {count} triangles; at most {_MOST_TRIANGLES}")
        vertices = np.concatenate([part.vertices for part in parts]).astype(float)
        if np.ptp(vertices, axis=0).max() > _LARGEST_MESH:
            vertices = 0.001 * vertices
            session.note(f"'{command.name}' was read as millimetres", 'info')
        message = self._new('mesh')
        mesh, base = Mesh(vertices=[Point(x=x, y=y, z=z) for x, y, z in vertices.tolist()]), 0
        for part in parts:
            mesh.triangles += [MeshTriangle(vertex_indices=row)
                               for row in (part.faces + base).astype(np.uint32)]
            base += len(part.vertices)
        message.meshes, message.mesh_poses = [mesh], [_unit()]
        await self._apply(message)
        await self._read()
        await self._select(session, Select(id=message.id))

    async def _change(self, _session: Session, command: Change) -> None:
        item = self._need(command.id)
        if item.link:
            raise ArmsimError(f"'{command.id}' is attached to {item.link}; detach it first")
        message = item.message
        message.operation = CollisionObject.MOVE
        if command.xyz is not None:
            position = message.pose.position
            position.x, position.y, position.z = command.xyz
        if command.turn is not None and any(command.turn):
            turn = message.pose.orientation
            turn.x, turn.y, turn.z, turn.w = (
                part / float(np.linalg.norm(command.turn)) for part in command.turn)
        if command.size is not None and len(message.primitives) == 1:
            if (len(command.size) != len(message.primitives[0].dimensions)
                    or min(command.size) <= 0.0):
                raise ArmsimError(f"the sizes of '{command.id}' must be above 0")
            message.primitives[0].dimensions = command.size
            message.operation = CollisionObject.ADD
        if message.operation == CollisionObject.MOVE:
            moved = CollisionObject(id=message.id, header=message.header, pose=message.pose,
                                    operation=CollisionObject.MOVE)
            await self._apply(moved)
        else:
            await self._apply(message)

    async def _remove(self, _session: Session, command: Named) -> None:
        item = self._need(command.id)
        if item.link:
            await self._loosen(item)
        await self._apply(CollisionObject(id=command.id, header=item.message.header,
                                          operation=CollisionObject.REMOVE))

    async def _attach(self, session: Session, command: Named) -> None:
        self._need(command.id)
        robot, group = self.page.robot, self._goals.goal(session).group
        tip = tip_of(robot.group(group)) if robot is not None and group else ''
        if robot is None or not tip:
            raise ArmsimError('this group has no tip to attach to')
        attached = AttachedCollisionObject(link_name=tip, touch_links=touch_links(robot, tip))
        attached.object.id = command.id
        attached.object.operation = CollisionObject.ADD
        await self._apply(attached=attached)

    async def _detach(self, _session: Session, command: Named) -> None:
        await self._loosen(self._need(command.id))

    async def _loosen(self, item: Any) -> None:
        attached = AttachedCollisionObject(link_name=item.link)
        attached.object.id = item.message.id
        attached.object.operation = CollisionObject.REMOVE
        await self._apply(attached=attached)

    async def _allow(self, _session: Session, command: Allow) -> None:
        scene = await self.page.planning_scene(PlanningSceneComponents.ALLOWED_COLLISION_MATRIX)
        matrix = scene.allowed_collision_matrix
        for pair in command.pairs:
            for name in pair:
                if name not in matrix.entry_names:
                    matrix.entry_names.append(name)
                    for entry in matrix.entry_values:
                        entry.enabled.append(False)
                    matrix.entry_values.append(AllowedCollisionEntry(
                        enabled=[False] * len(matrix.entry_names)))
            first, other = (matrix.entry_names.index(name) for name in pair)
            matrix.entry_values[first].enabled[other] = True
            matrix.entry_values[other].enabled[first] = True
        change = PlanningScene(is_diff=True, allowed_collision_matrix=matrix)
        change.robot_state.is_diff = True
        await self.page.call(ApplyPlanningScene, '/apply_planning_scene',
                             ApplyPlanningScene.Request(scene=change))
        self._goals.look_again()

    async def _save(self, session: Session, _command: Save) -> None:
        objects = [object_to_dict(item.message) for item in self._drawing.objects.values()
                   if not item.link]
        session.sections.pop('saved_scene', None)
        session.show('saved_scene', json.dumps({'objects': objects}, indent=1))
        session.sections.pop('saved_scene', None)

    async def _load(self, _session: Session, command: Load) -> None:
        try:
            objects = [object_from_dict(item) for item in json.loads(command.text)['objects']]
        except Exception as error:  # noqa: BLE001 - any text may have been chosen
            raise ArmsimError(f'this is not a scene that was saved here: {error!r:.200}') from None
        await self._apply(*objects)

    async def _select(self, session: Session, command: Select) -> None:
        """Give an object a handle in the session's scene."""
        handle = self._handles.pop(session, None)
        if handle is not None and session.scene is not None:
            handle.remove()
        self._chosen[session] = command.id
        session.show('chosen', command.id)
        item = self._drawing.objects.get(command.id)
        if item is None or item.link or session.scene is None:
            return
        place = self._robot_part.node_of(item.frame)
        handle = self._handles[session] = session.scene.scene.add_transform_controls(
            f'{place}/mover', scale=0.14, line_width=3.0, depth_test=False,
            disable_sliders=True, position=item.node.position, wxyz=item.node.wxyz)
        moving = asyncio.Lock()

        async def moved(_event: Any) -> None:
            if moving.locked():
                return
            async with moving:
                while True:
                    xyz, wxyz = tuple(handle.position), tuple(handle.wxyz)
                    item.node.position, item.node.wxyz = xyz, wxyz
                    change = Change(id=command.id, xyz=xyz, turn=(*wxyz[1:], wxyz[0]))
                    try:
                        await self._change(session, change)
                    except ArmsimError as error:
                        session.note(str(error))
                        return
                    self._goals.look_again()
                    if (tuple(handle.position), tuple(handle.wxyz)) == (xyz, wxyz):
                        return

        handle.on_update(moved)

    def _clicked(self, name: str, client: Any) -> None:
        """Choose an object that was clicked at; called in a thread of viser's."""
        def choose() -> None:
            for session in self.page.sessions.values():
                if session.scene is client:
                    self.page.start(self._select(session, Select(id=name)))

        self.page.soon(choose)

    def _paint(self, session: Session, names: set[str]) -> None:
        touched = names & set(self._drawing.objects)
        if session.scene is not None and touched != self._touched.get(session, set()):
            self._touched[session] = touched
            self._drawing.highlight(session.scene.scene, touched)

    def _need(self, name: str) -> Any:
        if name not in self._drawing.objects:
            raise ArmsimError(f"there is no object '{name}'")
        return self._drawing.objects[name]


def touch_links(robot: RobotModel, tip: str) -> list[str]:
    """Return the links that may touch what the tip carries: the tip and what hangs on it."""
    found = {tip}
    for name in robot.links:  # parents first
        joint = robot.joints.get(robot.parent_joint.get(name, ''))
        if joint is not None and joint.parent in found:
            found.add(name)
    return sorted(found)


def _unit() -> Pose:
    pose = Pose()
    pose.orientation.w = 1.0
    return pose
