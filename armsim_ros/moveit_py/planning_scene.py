# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.planning_scene``: robot state, world, what is attached, what may touch what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, overload

from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    ObjectColor,
    PlanningSceneWorld,
)
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from moveit_msgs.msg import RobotState as RobotStateMessage
from octomap_msgs.msg import Octomap, OctomapWithPose
from std_msgs.msg import ColorRGBA

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import PlanningError
from armsim_ros.moveit_py.robot_model import RobotModel
from armsim_ros.moveit_py.robot_state import RobotState, with_state
from armsim_ros.moveit_py.robot_trajectory import RobotTrajectory
from armsim_ros.moveit_py.scene_parts import (
    AllowedCollisionMatrix,
    CollisionRequest,
    CollisionResult,
    Transforms,
    World,
)
from armsim_ros.moveit_py.utils import logger, warn_once
from armsim_ros.nodes.conversions.collision_object import (
    attached_from_message,
    object_from_message,
    removal_message,
)
from armsim_ros.nodes.conversions.motion_plan_request import (
    constraints_from_message,
    start_state_from_message,
)
from armsim_ros.nodes.conversions.octomap import octomap_from_message
from armsim_ros.nodes.conversions.planning_scene import scene_to_message, world_from_message
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.scene.planning_scene import PlanningScene as Scene
from armsim_ros.planning.scene.update import SceneUpdate
from armsim_ros.scene_sources.scene_file import read_scene_file, write_scene_file


class _CurrentState(RobotState):
    """The robot state of a scene: what is changed in it is changed in the scene."""

    def __init__(self, robot_model: RobotModel, scene: Scene) -> None:
        super().__init__(robot_model)
        self._of, self._q, self._attached = scene, scene.q, scene.attached

    def _set_q(self, q: Vector) -> None:
        self._of.set_state(q)
        super()._set_q(self._of.q)

    def clear_attached_bodies(self) -> None:
        """Drop all that the robot carries."""
        super().clear_attached_bodies()
        self._of.set_attached(self._attached)

    def _follow(self) -> None:
        """Take what the scene has changed itself."""
        if self._q is not self._of.q:
            super()._set_q(self._of.q)
        self._attached = self._of.attached


class PlanningScene:
    """
    Robot state, objects of the world, attached objects, and which pairs may touch.

    An operation on objects that is refused is logged, and changes nothing.

    :param robot_model: the robot.
    :param world: a new, empty world.
    """

    def __init__(self, robot_model: RobotModel, world: World = World()) -> None:  # noqa: B008
        self._set_up(robot_model, Scene(robot_model._kinematics))

    @classmethod
    def _of(cls, robot_model: RobotModel, scene: Scene) -> PlanningScene:
        """Return what shows and edits a scene."""
        made = object.__new__(cls)
        made._set_up(robot_model, scene)
        return made

    def _set_up(self, robot_model: RobotModel, scene: Scene) -> None:
        self._model, self._scene = robot_model, scene
        self._state = _CurrentState(robot_model, scene)

    def __copy__(self) -> PlanningScene:
        """Return a scene of its own with the same content."""
        return PlanningScene._of(self._model, self._scene.snapshot())

    def __deepcopy__(self, memo: dict[int, Any]) -> PlanningScene:
        """Return a scene of its own with the same content."""
        return self.__copy__()

    # ---------------------------------------------------------------- what it holds

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._scene.name

    @name.setter
    def name(self, name: str) -> None:
        self._scene.apply(SceneUpdate(name=name))

    @property
    def robot_model(self) -> RobotModel:
        """The robot."""
        return self._model

    @property
    def planning_frame(self) -> str:
        """The frame of all poses without a frame: the model frame."""
        return self._scene.model_frame

    @property
    def current_state(self) -> RobotState:
        """The robot state; what is changed in it is changed in the scene."""
        self._state._follow()
        return self._state

    @current_state.setter
    def current_state(self, state: RobotState) -> None:
        self.set_current_state(state)

    @property
    def planning_scene_message(self) -> PlanningSceneMessage:
        """The whole scene as a message."""
        return scene_to_message(self._scene)

    @property
    def transforms(self) -> Transforms:
        """The frames beside those of the robot."""
        return Transforms._of(self._scene)

    @property
    def allowed_collision_matrix(self) -> AllowedCollisionMatrix:
        """Which pairs may touch; what is changed in it is changed in the scene."""
        return AllowedCollisionMatrix._of(lambda: self._scene.acm, self._scene.set_acm)

    @allowed_collision_matrix.setter
    def allowed_collision_matrix(self, matrix: AllowedCollisionMatrix) -> None:
        self._scene.set_acm(matrix._read())

    def set_current_state(self, robot_state: RobotState | RobotStateMessage) -> None:
        """
        Set the robot state, and with a state of this library what the robot carries.

        :raises PlanningError: the robot has no joint of a name in it.
        """
        if isinstance(robot_state, RobotState):
            attached = robot_state._attached
            self._scene.set_state(robot_state._q)
            self._scene.set_attached(attached)
            self.current_state._take(robot_state)
        else:
            start = start_state_from_message(robot_state, attached_from_message)
            self._attempt('set_current_state', lambda: self._scene.apply(
                SceneUpdate(robot_state=start)))
        self.current_state  # noqa: B018 - it follows

    # ---------------------------------------------------------------- objects

    def apply_collision_object(
        self, collision_object_msg: CollisionObject, color_msg: ObjectColor | None = None
    ) -> None:
        """Add, remove, extend or move an object of the world, and set its colour."""
        self._apply_object(collision_object_msg, color_msg)

    def _apply_object(self, message: CollisionObject, color: ObjectColor | None) -> bool:
        done = self._attempt('collision object', lambda: self._scene.apply_object(
            object_from_message(message)))
        if done and color is not None:
            self.set_object_color(color.id, color.color)
        return done

    def process_attached_collision_object(self, object: AttachedCollisionObject) -> bool:  # noqa: A002
        """Attach, extend or detach an object; return whether that was done."""
        return self._attempt('attached object', lambda: self._scene.apply_attached(
            attached_from_message(object)))

    def process_planning_scene_world(self, msg: PlanningSceneWorld) -> bool:
        """Add, remove, extend or move several objects; return whether all was done."""
        return self._attempt('world', lambda: self._scene.apply(
            replace(world_from_message(msg), replaces_world=False)))

    def process_octomap(self, msg: Octomap) -> None:
        """Replace the octomap, whose origin is that of the planning frame; no data: none."""
        message = OctomapWithPose(header=msg.header, octomap=msg)
        self._attempt('octomap', lambda: self._scene.apply(
            SceneUpdate(octomap=octomap_from_message(message, is_diff=False))))

    def remove_all_collision_objects(self) -> None:
        """Remove all objects of the world; attached objects stay."""
        self._scene.apply_object(object_from_message(removal_message('', self.planning_frame)))

    def set_object_color(self, object_id: str, color_msg: ColorRGBA) -> None:
        """Set the colour of an object."""
        color = (float(color_msg.r), float(color_msg.g), float(color_msg.b), float(color_msg.a))
        self._attempt('color', lambda: self._scene.apply(
            SceneUpdate(object_colors={object_id: color})))

    def save_geometry_to_file(self, file_path_and_name: str) -> bool:
        """Write the objects of the world to a file; return whether that was done."""
        return self._attempt('save_geometry_to_file', lambda: write_scene_file(
            file_path_and_name, self._scene))

    def load_geometry_from_file(self, file_path_and_name: str) -> bool:
        """Add the objects of a file to the world; return whether that was done."""
        return self._attempt('load_geometry_from_file', lambda: self._scene.load(
            read_scene_file(file_path_and_name)))

    @staticmethod
    def _attempt(what: str, change: Callable[[], None]) -> bool:
        try:
            change()
        except (PlanningError, OSError, ValueError) as error:
            logger().error(f'{what}: {error}')
            return False
        return True

    # ---------------------------------------------------------------- frames

    @overload
    def knows_frame_transform(self, frame_id: str) -> bool: ...

    @overload
    def knows_frame_transform(self, robot_state: RobotState, frame_id: str) -> bool: ...

    def knows_frame_transform(self, robot_state: Any = None, frame_id: Any = None) -> bool:  # type: ignore[misc] # an argument has several names
        """Return whether a frame is known: of a link, an object, a subframe, or of transforms."""
        if isinstance(robot_state, str):
            robot_state, frame_id = None, robot_state
        return self._in(robot_state).has_frame(frame_id)

    def get_frame_transform(self, frame_id: str) -> Matrix:
        """
        Return the pose (4, 4) of a frame in the planning frame.

        :raises PlanningError: the frame is not known.
        """
        return self._scene.frame_pose(frame_id)

    # ---------------------------------------------------------------- checks

    def _in(self, state: RobotState | None) -> Scene:
        return self._scene if state is None else with_state(self._scene, state)

    def is_state_valid(
        self, robot_state: RobotState, joint_model_group_name: str, verbose: bool = False
    ) -> bool:
        """Return whether a state does not collide; joint limits are not checked."""
        return not self.is_state_colliding(robot_state, joint_model_group_name, verbose)

    @overload
    def is_state_colliding(self, joint_model_group_name: str, verbose: bool = False) -> bool: ...

    @overload
    def is_state_colliding(
        self, robot_state: RobotState, joint_model_group_name: str, verbose: bool = False
    ) -> bool: ...

    def is_state_colliding(  # type: ignore[misc] # an argument has several names
        self, robot_state: Any = None, joint_model_group_name: Any = None, verbose: bool = False
    ) -> bool:
        """
        Return whether a state, or the scene's, collides.

        :param joint_model_group_name: only links that this group moves; '' for all.
        :param verbose: log what touches.
        :raises PlanningError: there is no such group.
        """
        if isinstance(robot_state, str):
            verbose = bool(joint_model_group_name) or verbose
            robot_state, joint_model_group_name = None, robot_state
        group = joint_model_group_name or None
        scene = self._in(robot_state)
        with self._model._lock:
            checker = self._model._context.checker
            checker.use(scene)
            if not checker.in_collision(scene.q, group):
                return False
            if verbose:
                for contact in checker.contacts(scene.q, group):
                    logger().info(f'collision: {contact}')
        return True

    def is_state_constrained(
        self, state: RobotState, constraints: Constraints, verbose: bool = False
    ) -> bool:
        """Return whether a state satisfies constraints."""
        scene = self._in(state)
        results = ConstraintSet(
            constraints_from_message(constraints), scene, logger()).evaluate(scene.q)
        failed = [result.text for result in results if not result.satisfied]
        if verbose and failed:
            logger().info('; '.join(failed))
        return not failed

    def is_path_valid(
        self, trajectory: RobotTrajectory, joint_model_group_name: str, verbose: bool = False,
        invalid_index: list[int] | None = None
    ) -> bool:
        """
        Return whether no waypoint collides.

        :param invalid_index: gets the numbers of those that do.
        """
        found = [place for place, state in enumerate(trajectory)
                 if not self.is_state_valid(state, joint_model_group_name, verbose)]
        if invalid_index is not None:
            invalid_index[:] = found
        return not found

    def check_collision(
        self, collision_request: CollisionRequest, collision_result: CollisionResult,
        state: RobotState | None = None, acm: AllowedCollisionMatrix | None = None
    ) -> None:
        """
        Check a state against itself and the world, with padding.

        :param collision_result: is filled.
        :param state: None for the scene's.
        :param acm: None for the scene's.
        """
        self._check(self._in(state), acm, collision_request, collision_result)

    def check_self_collision(
        self, collision_request: CollisionRequest, collision_result: CollisionResult,
        state: RobotState | None = None, acm: AllowedCollisionMatrix | None = None
    ) -> None:
        """Check a state against itself alone; the parameters are those of ``check_collision``."""
        scene = self._in(state).without_world()
        self._check(scene, acm, collision_request, collision_result)

    @overload
    def check_collision_unpadded(
        self, req: CollisionRequest, result: CollisionResult) -> None: ...

    @overload
    def check_collision_unpadded(
        self, collision_request: CollisionRequest, collision_result: CollisionResult,
        state: RobotState | None = None, acm: AllowedCollisionMatrix | None = None
    ) -> None: ...

    def check_collision_unpadded(  # type: ignore[misc] # an argument has several names
        self, collision_request: Any = None, collision_result: Any = None,
        state: Any = None, acm: Any = None, *, req: Any = None, result: Any = None
    ) -> None:
        """Check a state without padding; the parameters are those of ``check_collision``."""
        if req is not None:
            collision_request, collision_result = req, result
        self._check(self._in(state).unpadded(), acm, collision_request, collision_result)

    def _check(
        self, scene: Scene, acm: AllowedCollisionMatrix | None, request: CollisionRequest,
        result: CollisionResult
    ) -> None:
        if request.cost:
            warn_once('collision request: cost is not used; costs are not computed')
        if request.contacts and request.max_contacts_per_pair > 1:
            warn_once('collision request: max_contacts_per_pair is not used; a pair has its '
                      'deepest contact')
        if acm is not None:
            scene = scene.snapshot()
            scene.set_acm(acm._read())
        group = request.joint_model_group_name or None
        with self._model._lock:
            checker = self._model._context.checker
            checker.use(scene)
            contacts = (checker.contacts(scene.q, group)
                        if request.contacts or request.verbose else [])
            result.collision = bool(contacts) or checker.in_collision(scene.q, group)
            if request.distance:
                result.distance = checker.distance(scene.q, group)
        if request.verbose:
            for contact in contacts:
                logger().info(f'collision: {contact}')
        if request.contacts:
            result.contacts = {
                (each.body1, each.body2): [each] for each in contacts[:request.max_contacts]}
            result.contact_count = len(result.contacts)
