# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene: robot state, world, attached objects, and what may touch what."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, replace
import threading
from types import MappingProxyType

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.content import FixedFrame, SceneContent, SceneDraft
from armsim_ros.planning.scene.object_operations import apply_attached, apply_object, place_object
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject
from armsim_ros.planning.scene.octomap import Octomap
from armsim_ros.planning.scene.scene_view import SceneView
from armsim_ros.planning.scene.update import (
    apply_start_state,
    apply_update,
    joined,
    SceneUpdate,
    StartState,
)

Listener = Callable[[SceneContent, SceneContent], None]


class PlanningScene(SceneView):
    """
    A scene that can be edited.

    All that it holds is an immutable :class:`SceneContent`; an edit is done in a draft, whose
    content is then put in place, so that a reader in any thread sees the scene before or after
    an edit, never between. Edits of several threads are serialized; robot state, frames and
    octomap can be set while a long edit is being made. :meth:`snapshot` returns a scene that
    stays.

    :param kinematics: the robot.
    :param name: name of the scene.
    :param link_padding: [m] default padding of every link against the world.
    :param link_scale: default factor of every link's size against the world.
    :param auto_disable_adjacent: where the SRDF disables no pair, let neighbours touch.
    :param parent_frame: (4, 4) pose in the root link's frame of the frame that a fixed virtual
        joint ties the robot to, the identity by default; it counts until TF or a message has the
        pose of that frame.
    """

    def __init__(
        self, kinematics: KinematicModel, *, name: str = '', link_padding: float = 0.0,
        link_scale: float = 1.0, auto_disable_adjacent: bool = True,
        parent_frame: Matrix | None = None
    ) -> None:
        robot = kinematics.robot
        pose = np.eye(4) if parent_frame is None else parent_frame
        outside = {robot.parent_frame: pose} if robot.parent_frame else {}
        q = kinematics.default()
        q.setflags(write=False)
        solid = [link for link, item in robot.links.items() if item.collisions]
        self._initial = SceneContent(
            q,
            name,
            acm=AllowedCollisionMatrix.from_robot(
                robot, auto_disable_adjacent=auto_disable_adjacent),
            fixed_frames=MappingProxyType(outside),
            link_padding=MappingProxyType(dict.fromkeys(solid, link_padding)),
            link_scale=MappingProxyType(dict.fromkeys(solid, link_scale)))
        super().__init__(kinematics, self._initial)
        #: Held while an edit is made, and while its result is put in place.
        self._editing, self._lock = threading.RLock(), threading.RLock()
        self._listeners: list[Listener] = []
        #: Of a scene made for a request: what of its update and start state was refused.
        self.refusals: tuple[PlanningError, ...] = ()

    # ---------------------------------------------------------------- edits

    def set_state(self, q: Vector) -> None:
        """
        Set the robot state; attached objects move with their links.

        :param q: (n,) all finite.
        :raises PlanningError: INVALID_ROBOT_STATE.
        """
        state = self.kinematic_model.apply_mimic(np.asarray(q, dtype=np.float64))
        if state.shape != (self.kinematic_model.n,) or not np.isfinite(state).all():
            raise PlanningError(
                MoveItErrorCode.INVALID_ROBOT_STATE,
                f'a robot state needs {self.kinematic_model.n} finite numbers', 'planning scene')
        state.setflags(write=False)
        with self._lock:
            self._commit(replace(self._content, q=state))

    def set_positions(self, positions: Mapping[str, float]) -> None:
        """Set some joints' positions [rad or m]; PlanningError for an unknown joint."""
        with self._lock:
            self.set_state(self.kinematic_model.vector(positions, self._content.q))

    def set_frames(self, added: Mapping[str, FixedFrame]) -> None:
        """Add or renew frames of TF; those that lead to no link are ignored."""
        with self._lock:
            known = MappingProxyType({**self._content.frames, **added})
            self._commit(replace(self._content, frames=known))

    def set_acm(self, acm: AllowedCollisionMatrix) -> None:
        """Replace the allowed collision matrix."""
        def replace_acm(draft: SceneDraft) -> None:
            draft.acm = acm

        self._edit(replace_acm)

    def set_octomap(self, octomap: Octomap | None) -> None:
        """Replace the map of what cameras see; this waits for no edit of the scene."""
        with self._lock:
            self._commit(replace(self._content, octomap=octomap))

    def change_octomap(self, change: Callable[[], Octomap | None]) -> None:
        """Replace the map by what a function returns, which no other thread's edit interrupts."""
        with self._lock:
            self.set_octomap(change())

    def set_attached(self, attached: Mapping[str, AttachedObject]) -> None:
        """Replace all objects on the robot, by id; an object of the world keeps its place."""
        def replace_attached(draft: SceneDraft) -> None:
            draft.attached = dict(attached)

        self._edit(replace_attached)

    def apply_object(self, item: CollisionObject) -> None:
        """
        Add, remove, extend or move a world object.

        :raises PlanningError: with the reason; the scene is as it was then.
        """
        self._edit(lambda draft: apply_object(draft, item))

    def apply_attached(self, item: AttachedObject) -> None:
        """
        Attach, extend or detach an object.

        :raises PlanningError: with the reason; the scene is as it was then.
        """
        self._edit(lambda draft: apply_attached(draft, item))

    def apply(self, update: SceneUpdate) -> None:
        """
        Apply a scene message part by part; listeners see it as a single edit.

        :raises PlanningError: with a sentence for every part that was refused; such a part has
            changed nothing, and all others are applied.
        """
        refusals: list[PlanningError] = []
        self._edit(lambda draft: refusals.extend(apply_update(draft, update)))
        if refusals:
            raise joined(refusals)

    def load(self, update: SceneUpdate) -> None:
        """
        Add what a scene file holds, with the poses of the file.

        :raises PlanningError: with a sentence for every part that cannot be added; the scene is
            as it was then.
        """
        def load_all(draft: SceneDraft) -> None:
            refusals = apply_update(draft, update, place_object)
            if refusals:
                raise joined(refusals)

        self._edit(load_all)

    def restore(self, ids: Iterable[str], content: SceneContent) -> None:
        """Set objects, in the world or on the robot, to what they are in another content."""
        self._edit(lambda draft: draft.restore(ids, content))

    @contextmanager
    def edited(self) -> Iterator[PlanningScene]:
        """
        Give a copy to edit; what changed in it is put in place at the end, as a single edit.

        Edits of other threads wait meanwhile, but for the robot state and the frames.
        """
        with self._editing:
            copy = self.snapshot()
            base = copy.content
            try:
                yield copy
            finally:
                made = copy.content
                changed = {each.name: getattr(made, each.name) for each in fields(SceneContent)
                           if getattr(made, each.name) is not getattr(base, each.name)}
                if 'q' in changed and np.array_equal(made.q, base.q):
                    del changed['q']
                if changed:
                    with self._lock:
                        self._commit(replace(self._content, **changed))

    def clear(self) -> None:
        """Take away all objects, and set rules, padding and colours to their beginning."""
        with self._editing, self._lock:
            now = self._content
            self._commit(replace(
                self._initial, q=now.q, name=now.name, frames=now.frames,
                fixed_frames=now.fixed_frames, standing=now.standing,
                whole_version=now.whole_version + 1))

    def _edit(self, change: Callable[[SceneDraft], None]) -> None:
        """Put a changed draft in place, unless the change raises."""
        with self._editing:
            base = self._content
            draft = SceneDraft(self.kinematic_model, base)
            change(draft)
            made = draft.content()
            if made is base:
                return
            with self._lock:
                now = self._content
                if now is not base:  # the robot has moved meanwhile, or frames or the map were set
                    made = replace(
                        made, q=now.q if made.q is base.q else made.q,
                        frames=now.frames,
                        octomap=now.octomap if made.octomap is base.octomap else made.octomap)
                self._commit(made)

    def _commit(self, content: SceneContent) -> None:
        before, self._content = self._content, content
        for listener in tuple(self._listeners):
            listener(before, content)

    # ---------------------------------------------------------------- copies and listeners

    def snapshot(self) -> PlanningScene:
        """Return a scene of its own with the same content; this costs next to nothing."""
        copy = object.__new__(PlanningScene)
        with self._lock:
            SceneView.__init__(copy, self.kinematic_model, self._content)
            copy._initial = self._initial
        copy._editing, copy._lock = threading.RLock(), threading.RLock()
        copy._listeners = []
        copy.refusals = self.refusals
        return copy

    def with_update(self, update: SceneUpdate) -> PlanningScene:
        """
        Return a snapshot with a message applied to it; ``refusals`` has what was not.

        Frames of TF stay where they are, whatever robot state the message has.
        """
        overlay, refusals = self._with_standing_frames(), list(self.refusals)
        overlay._edit(lambda draft: refusals.extend(apply_update(draft, update)))
        overlay.refusals = tuple(refusals)
        return overlay

    def with_start_state(self, start: StartState, *, strict: bool = False) -> PlanningScene:
        """
        Return a snapshot whose robot state is a client's start state.

        Frames of TF stay where they are.

        :param start: joints that are not named keep the scene's state; its attached objects
            are applied, ``refusals`` has those that were refused.
        :param strict: a start state that is not a difference drops the scene's attached objects.
        :raises PlanningError: INVALID_ROBOT_STATE for an unknown joint or for names and
            positions that do not match.
        """
        overlay, refusals = self._with_standing_frames(), list(self.refusals)
        overlay._edit(
            lambda draft: refusals.extend(apply_start_state(draft, start, strict=strict)))
        overlay.refusals = tuple(refusals)
        return overlay

    def _with_standing_frames(self) -> PlanningScene:
        """Return a snapshot in which frames of TF have their present poses in any robot state."""
        copy = self.snapshot()
        now = copy._content
        if now.frames:
            copy._commit(replace(
                now, frames=MappingProxyType({}), fixed_frames=MappingProxyType({}),
                standing=now))
        return copy

    def with_robot(self, q: Vector, attached: Mapping[str, AttachedObject]) -> PlanningScene:
        """
        Return a snapshot in which the robot has another state and carries other objects.

        :param q: (n,) in which mimic joints follow.
        """
        overlay = self.snapshot()
        state = q.copy()
        state.setflags(write=False)
        overlay._commit(replace(overlay._content, q=state, attached=attached))
        return overlay

    @property
    def refused(self) -> str:
        """What of the request's update and start state was refused; '' where all was taken."""
        return str(joined(self.refusals)) if self.refusals else ''

    def without_world(self) -> PlanningScene:
        """Return a snapshot without objects and octomap in the world."""
        copy = self.snapshot()
        copy._commit(replace(copy._content, objects=MappingProxyType({}), octomap=None))
        return copy

    def unpadded(self) -> PlanningScene:
        """Return a snapshot in which every link has its own size against the world."""
        copy = self.snapshot()
        links = copy._content.link_padding
        copy._commit(replace(
            copy._content, link_padding=MappingProxyType(dict.fromkeys(links, 0.0)),
            link_scale=MappingProxyType(dict.fromkeys(links, 1.0))))
        return copy

    def add_listener(self, listener: Listener) -> Callable[[], None]:
        """
        Call a function with the contents before and after every edit, in the editing thread.

        :returns: a function that ends it.
        """
        with self._lock:
            self._listeners.append(listener)

        def remove() -> None:
            with self._lock:
                if listener in self._listeners:
                    self._listeners.remove(listener)

        return remove
