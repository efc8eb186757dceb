# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Service and topic of wrenches on bodies, as those of mujoco_ros2_control."""

from __future__ import annotations

from concurrent.futures import Future
from itertools import count
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point, Vector3, WrenchStamped
from mujoco_ros2_control_msgs.msg import ExternalWrench
from mujoco_ros2_control_msgs.srv import ApplyExternalWrench
import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.arrays import Vector
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.sim.external_loads import ExternalWrenches, Wrench
from armsim_ros.sim.world.entities import Entities

_PLACE = '/external_wrench'
#: How long a message of the topic acts [ns].
_HELD_NS = 200_000_000
#: Wall time between two messages of markers [s].
_MARKERS_PERIOD = 0.05
#: Length of an arrow per newton or newton metre [m].
_LENGTH = 0.01


class WrenchServer:
    """Applies wrenches."""

    def __init__(self, node: Node, work: Work, dispatcher: Dispatcher, entities: Entities) -> None:
        self._node, self._work = node, work
        self._wrenches = ExternalWrenches(work.loop, entities)
        node.create_service(
            ApplyExternalWrench, f'{_PLACE}/apply_wrench', self._apply,
            callback_group=ReentrantCallbackGroup())
        self._subscription = node.create_subscription(
            WrenchStamped, f'{_PLACE}/wrench', self._receive, 10)
        self._markers = node.create_publisher(MarkerArray, f'{_PLACE}/wrench_markers', 1)
        self._shown = False
        dispatcher.every(_MARKERS_PERIOD, self._show)

    def clear(self) -> None:
        """End all wrenches; in the loop's thread."""
        self._wrenches.clear()

    async def _apply(self, request: Any, response: Any) -> Any:
        """Answer when the last wrench has ended."""
        ended: Future[None] = Future()
        try:
            wrenches = [_wrench(each) for each in request.wrenches.external_wrenches]
            await self._work.in_loop(lambda: self._wrenches.apply(
                wrenches, ended=lambda: ended.set_result(None)))
            await self._work.finished(ended)
        except (SimulationError, ValueError) as error:
            response.message = f'nothing was applied: {error}'
            self._node.get_logger().warning(f"'{_PLACE}/apply_wrench': {response.message}")
            return response
        response.success, response.message = True, f'applied {len(wrenches)} wrenches'
        return response

    def _receive(self, message: WrenchStamped) -> None:
        """Hold the wrench of a message for a while; the next one replaces it."""
        try:
            wrench = Wrench(message.header.frame_id, *_parts(message), np.zeros(3), _HELD_NS)
        except ValueError as error:
            self._warn(str(error))
            return
        done = self._work.loop.call(lambda: self._wrenches.apply([wrench], key=_PLACE))
        done.add_done_callback(self._tell)

    def _tell(self, done: Any) -> None:
        if not done.cancelled() and done.exception() is not None:
            self._warn(str(done.exception()))

    def _warn(self, reason: str) -> None:
        self._node.get_logger().warning(
            f"message on '{_PLACE}/wrench' dropped: {reason}", throttle_duration_sec=1.0)

    def _show(self) -> None:
        """Publish an arrow per force and torque, and none once they have ended."""
        acting = self._wrenches.acting
        if (not acting and not self._shown) or not self._markers.get_subscription_count():
            return
        self._shown = bool(acting)
        numbers = count()
        arrows = [_arrow(next(numbers), wrench, kind, share * way)
                  for wrench, share in acting
                  for kind, way in (('force', wrench.force), ('torque', wrench.torque))
                  if way.any()]
        self._markers.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL), *arrows]))


def _wrench(message: ExternalWrench) -> Wrench:
    """
    Return what a message requests.

    :raises ValueError: a number that is not finite, or a duration that is not possible.
    """
    duration, ramp = _ns(message.duration), _ns(message.ramp_down_duration)
    frame, point = message.wrench.header.frame_id, message.application_point
    if not 0 <= ramp <= duration:
        raise ValueError(f"frame '{frame}': ramp_down_duration {1e-9 * ramp:g} s, duration "
                         f'{1e-9 * duration:g} s; allowed: 0 to the duration')
    at = np.array((point.x, point.y, point.z))
    force, torque = _parts(message.wrench)
    if not np.isfinite(at).all():
        raise ValueError(f"frame '{frame}': application_point {at.tolist()}")
    return Wrench(frame, force, torque, at, duration, ramp)


def _parts(message: WrenchStamped) -> tuple[Vector, Vector]:
    force, torque = (np.array((part.x, part.y, part.z))
                     for part in (message.wrench.force, message.wrench.torque))
    if not (np.isfinite(force).all() and np.isfinite(torque).all()):
        raise ValueError(f"frame '{message.header.frame_id}': force {force.tolist()}, torque "
                         f'{torque.tolist()}; all numbers must be finite')
    return force, torque


def _ns(duration: Duration) -> int:
    return int(duration.sec) * 10**9 + int(duration.nanosec)


def _arrow(number: int, wrench: Wrench, kind: str, way: Vector) -> Marker:
    """Return the marker of a force (red) or a torque (blue)."""
    marker = Marker(ns=f'external_wrench/{kind}', id=number, type=Marker.ARROW)
    marker.header.frame_id = wrench.frame
    ends = wrench.point, wrench.point + _LENGTH * way
    marker.points = [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in ends]
    marker.scale = Vector3(x=0.02, y=0.04, z=0.0)
    marker.color.r, marker.color.b = (1.0, 0.0) if kind == 'force' else (0.0, 0.9)
    marker.color.a = 0.8
    return marker
