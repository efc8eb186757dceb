# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated world on the topic ``/planning_scene``, for the planner."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future as LoopFuture
import time
from uuid import uuid4

from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, ObjectColor, PlanningScene
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import ColorRGBA

from armsim_ros.arrays import Matrix
from armsim_ros.model.grippers import Gripper
from armsim_ros.model.world_objects import WORLD_TYPE, WorldObject
from armsim_ros.nodes.conversions.collision_object import world_object_to_message
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.world.world_mirror import (
    Holder,
    WorldMirror,
    WorldNews,
    WorldSnapshot,
    WorldWatch,
)

TOPIC = '/planning_scene'
DEPTH = 100
#: Wall time between two checks of the world [s].
PERIOD = 0.1
#: Simulated time between checks whether a message is due [ns], and how early it may be [s].
_TICK_NS, _EARLY = 20_000_000, 0.01


class SceneMirror:
    """
    Publishes objects that appear, move or vanish; late subscribers get all of them.

    At rest nothing is published, and without subscribers nothing is checked.

    :param frame: the model frame.
    :param root: (4, 4) pose of the world in it.
    :param fingers: returns what fingers hold, where there are some.
    """

    def __init__(
        self, node: Node, loop: ControlLoop, dispatcher: Dispatcher, frame: str, root: Matrix,
        fingers: Callable[[], Mapping[str, Gripper]] | None = None
    ) -> None:
        self._loop, self._dispatcher = loop, dispatcher
        self._frame, self._root = frame, root
        self._watch = WorldWatch(
            loop.simulation.world, loop.simulation.vacuum_grippers.values(), fingers)
        self._mirror = WorldMirror()
        self._session = uuid4().hex[:8]
        self._whole, self._looking, self._heard = True, False, False
        self._due = 0.0
        self._post = dispatcher.bounded()
        self._waiting: list[Callable[[], object]] = []
        self._publisher = node.create_publisher(
            PlanningScene, TOPIC, QoSProfile(depth=DEPTH),
            event_callbacks=PublisherEventCallbacks(matched=self._matched))
        dispatcher.every(PERIOD, self._listen)
        loop.every(_TICK_NS, self._look_in_tick)

    def tell_now(self, then: Callable[[], object]) -> None:
        """Publish the present world, then call back; in the dispatcher's thread."""
        self._waiting.append(then)
        self._look()

    def begin_anew(self) -> None:
        """Let what users took over be the world's again; in the loop's thread."""
        self._watch.epoch += 1

    def _matched(self, event: object) -> None:
        if getattr(event, 'current_count_change', 1) > 0:
            self._whole = True

    def _listen(self) -> None:
        """Record whether there are subscribers; check here where no tick does, as in a pause."""
        self._heard = bool(self._publisher.get_subscription_count())
        if self._heard and time.monotonic() > self._due + 0.5 * PERIOD:
            self._look()

    def _look_in_tick(self, _: int) -> None:
        """Check what has moved; in the loop's thread, which need not be woken for that."""
        now = time.monotonic()
        if self._heard and not self._looking and now >= self._due:
            self._looking, self._due = True, now + PERIOD - _EARLY
            snapshot = self._watch.look()
            self._post(lambda: self._sent(snapshot, ()))

    def _look(self) -> None:
        """Have the loop look soon, also while it is paused."""
        if self._looking:
            return
        waiting, self._waiting = self._waiting, []
        if not self._publisher.get_subscription_count():
            for then in waiting:
                then()
            return
        self._looking, self._due = True, time.monotonic() + PERIOD - _EARLY
        self._loop.call(self._watch.look).add_done_callback(
            lambda future: self._dispatcher.post(lambda: self._looked(future, waiting)))

    def _looked(
        self, future: LoopFuture[WorldSnapshot], waiting: Iterable[Callable[[], object]]
    ) -> None:
        self._sent(None if future.cancelled() else future.result(), waiting)

    def _sent(self, now: WorldSnapshot | None, waiting: Iterable[Callable[[], object]]) -> None:
        self._looking = False
        if now is not None:
            self._tell(now)
        for then in waiting:
            then()
        if self._waiting:
            self._look()

    def _tell(self, now: WorldSnapshot) -> None:
        whole, self._whole = self._whole, False
        news = self._mirror.news(now, whole=whole)
        if not news.empty:
            for message in self._messages(news, f'{self._session}:{now.epoch}'):
                self._publisher.publish(message)

    def _messages(self, news: WorldNews, epoch: str) -> Iterator[PlanningScene]:
        """Yield the messages that have to be applied in sequence."""
        if news.released:
            yield self._grasps(news.released, CollisionObject.REMOVE, epoch)
        if news.added or news.moved or news.removed:
            yield self._objects(news, epoch)
        if news.grasped:
            yield self._grasps(news.grasped, CollisionObject.ADD, epoch)

    def _grasps(
        self, pairs: Iterable[tuple[str, Holder]], operation: bytes, epoch: str
    ) -> PlanningScene:
        message = PlanningScene(is_diff=True)
        message.robot_state.is_diff = True
        for name, (link, touch_links) in pairs:
            attached = AttachedCollisionObject(link_name=link, touch_links=list(touch_links))
            attached.object = self._short(name, operation)
            attached.object.type.key, attached.object.type.db = WORLD_TYPE, epoch
            message.robot_state.attached_collision_objects.append(attached)
        return message

    def _objects(self, news: WorldNews, epoch: str) -> PlanningScene:
        message = PlanningScene(is_diff=True)
        message.robot_state.is_diff = True
        objects = message.world.collision_objects
        objects += [self._short(name, CollisionObject.REMOVE) for name in news.removed]
        for item, pose in news.added:
            objects.append(world_object_to_message(item, self._root @ pose, self._frame))
            message.object_colors.append(_color(item))
        for name, pose in news.moved:
            moved = self._short(name, CollisionObject.MOVE)
            moved.pose = pose_to_message(self._root @ pose)
            objects.append(moved)
        for message_object in objects:
            message_object.type.key, message_object.type.db = WORLD_TYPE, epoch
        return message

    def _short(self, name: str, operation: bytes) -> CollisionObject:
        message = CollisionObject(id=name, operation=operation)
        message.header.frame_id = self._frame
        return message


def _color(item: WorldObject) -> ObjectColor:
    given = next((part.rgba for part in item.parts if part.rgba), (0.6, 0.6, 0.6, 1.0))
    red, green, blue, alpha = (float(value) for value in given)
    return ObjectColor(id=item.name, color=ColorRGBA(r=red, g=green, b=blue, a=alpha))
