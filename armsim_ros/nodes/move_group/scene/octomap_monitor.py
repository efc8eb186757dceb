# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Builds the octomap of the planning scene from what sensors measure."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rclpy.clock import Clock, ClockType
from std_srvs.srv import Trigger

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.sensors_3d import (
    DEPTH_NOISE,
    DepthImageSensor,
    OctomapSettings,
    read_sensors,
    Sensor,
    with_cameras,
)
from armsim_ros.config.yaml_node import node_of
from armsim_ros.errors import Location, PlanningError, Problem, Severity
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.scene.octomap_updaters import updaters_of
from armsim_ros.nodes.move_group.worker import Worker
from armsim_ros.nodes.parameters import parameters_by_prefix
from armsim_ros.planning.occupancy.scene_map import SceneMap, Sight
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.octomap import Octomap

#: States that are kept: several seconds of usual joint states.
_KEPT = 2000


class StateHistory:
    """The joint positions of the last seconds, interpolated."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque(maxlen=_KEPT)
        self._states: deque[dict[str, float]] = deque(maxlen=_KEPT)

    @property
    def newest_ns(self) -> int:
        """Time of the last state [ns]; 0 where there is none."""
        return self._stamps[-1] if self._stamps else 0

    def record(self, stamp_ns: int, positions: Mapping[str, float]) -> None:
        """Keep a state; where time has jumped back, what is later is forgotten."""
        while self._stamps and self._stamps[-1] > stamp_ns:
            self._stamps.pop()
            self._states.pop()
        if self._stamps and self._stamps[-1] == stamp_ns:
            self._states[-1] = dict(positions)
        else:
            self._stamps.append(stamp_ns)
            self._states.append(dict(positions))

    def at(self, stamp_ns: int) -> dict[str, float] | None:
        """
        Return the positions [rad or m] at a time, None where it is later than the last state.

        :param stamp_ns: [ns]; 0 is the time of the last state.
        :raises ValueError: it is before the first state that is kept.
        """
        if not self._stamps or stamp_ns > self._stamps[-1]:
            return None
        if stamp_ns == 0:
            return self._states[-1]
        if stamp_ns < self._stamps[0]:
            raise ValueError(
                f'it is {(self._stamps[0] - stamp_ns) / 1e9:.2f} s older than the oldest robot '
                'state that is kept')
        after = bisect_left(self._stamps, stamp_ns)
        late = self._states[after]
        if self._stamps[after] == stamp_ns:
            return late
        begin, end = self._stamps[after - 1], self._stamps[after]
        share = (stamp_ns - begin) / (end - begin)
        early = self._states[after - 1]
        return {name: value + share * (late[name] - value)
                for name, value in early.items() if name in late}


#: Messages of a sensor that wait for their transforms, and how long they do [s].
_WAITING, _PATIENCE = 5, 5.0
#: Between two attempts to transform what waits, and between two warnings of a sensor [s].
_RETRY, _WARNING_PERIOD = 0.05, 10.0


def octomap_settings(context: Context) -> OctomapSettings:
    """
    Return what builds the map: parameters of the node, else the robot's file; and cameras.

    What is wrong in the parameters is logged; the sensor is left out.
    """
    settings, problems = context.settings.octomap, list[Problem]()
    if context.node.has_parameter('sensors'):
        nested: dict[str, Any] = {}
        for name, parameter in parameters_by_prefix(context.node, '').items():
            *parents, last = name.split('.')
            block = nested
            for parent in parents:
                inner = block.setdefault(parent, {})
                block = inner if isinstance(inner, dict) else {}
            block[last] = parameter.value
        settings = read_sensors(node_of(nested, Location('parameter of move_group')), problems)
    for problem in problems:
        if problem.severity is not Severity.INFO:
            context.logger.warning(str(problem))
    if context.planning_parameters.octomap:
        cameras = context.settings.simulation.cameras
        if not cameras:
            context.logger.warning(
                'octomap:=true, but simulation.yaml has no camera; see docs/world.md')
        settings = with_cameras(settings, cameras)
    return settings


@dataclass(eq=False)
class _Waiting:
    """A message that waits for its transform."""

    message: Any
    since: float


class OctomapMonitor:
    """
    Adds measurements to a map, and puts the map into the scene.

    Messages come in the executor's thread, are transformed there and handed to a thread of the
    map; of a sensor only the newest waits for it. In lockstep none is left out, so that equal
    runs give equal maps.

    :param settings: the sensors; without any this costs nothing.
    """

    def __init__(self, context: Context, settings: OctomapSettings) -> None:
        self._context = context
        self._history = StateHistory()
        self._worker: Worker | None = None
        #: By name; in lockstep by number too.
        self._ready: dict[tuple[str, int], Callable[[], None]] = {}
        self._lockstep, self._number = context.settings.simulation.deterministic, 0
        self._waiting: dict[str, deque[_Waiting]] = {}
        self._warned: dict[str, float] = {}
        self._sensors = settings.sensors
        self._updaters = updaters_of(context, settings.sensors, self._receive)
        if not self._updaters:
            return
        context.states.recorders.append(self._history.record)
        self._busy = False
        self._timer = context.node.create_timer(
            _RETRY, self._advance, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._timer.cancel()
        self._scene_map = SceneMap(
            context.scene, settings.octomap_resolution,
            max(sensor.padding_offset for sensor in settings.sensors.values()))
        if self._lockstep:
            context.serve(Trigger, '/move_group/sync_octomap', self._sync)
        listened = ', '.join(f"'{each.topic}'" for each in self._updaters.values())
        context.logger.info(f'octomap: cells of {settings.octomap_resolution:g} m from {listened}')

    def close(self) -> None:
        """End the thread of the map."""
        if self._worker is not None:
            self._worker.close()

    def forget(self) -> None:
        """Empty the map; what is being added does not bring old cells back."""
        if self._updaters:
            self._scene_map.forget()

    def load(self, octomap: Octomap) -> None:
        """
        Replace the map, to which sensors add from then on.

        :param octomap: in the model frame.
        :raises PlanningError: FAILURE for too many cells.
        """
        if self._updaters:
            self._scene_map.load(octomap)
        else:
            self._context.scene.set_octomap(None if octomap.empty else octomap)

    async def _sync(self, _: Trigger.Request, response: Trigger.Response) -> None:
        """Answer when all that has come is in the scene."""
        while self._busy or any(self._waiting.values()):
            self._context.check_ending('octomap')
            await self._context.ticker.next()
        response.success = True

    # ---------------------------------------------------------------- messages

    def _receive(self, name: str, message: Any) -> None:
        waiting = self._waiting.setdefault(name, deque())
        if len(waiting) == _WAITING and not self._lockstep:
            self._drop(name, waiting.popleft(), 'too many wait for their transforms')
        waiting.append(_Waiting(message, self._context.clock()))
        self._advance()

    def _advance(self) -> None:
        """Hand on the messages whose transforms are known, in their order."""
        for name, waiting in self._waiting.items():
            while waiting and self._handed_on(name, waiting[0]):
                waiting.popleft()
        if not any(self._waiting.values()):
            self._timer.cancel()
        elif self._timer.is_canceled():
            self._timer.reset()

    def _handed_on(self, name: str, entry: _Waiting) -> bool:
        """Return whether a message waits no longer: it is handed on, or dropped."""
        header = entry.message.header
        scene = self._context.scene
        try:
            positions = self._history.at(ns_from_time(header.stamp))
            if positions is None:
                reason = 'there is no robot state of its time yet'
            else:
                q = scene.kinematic_model.vector(positions, scene.q)
                self._hand_on(name, entry.message, q, scene.frame_pose(header.frame_id, q))
                return True
        except (ValueError, PlanningError) as error:
            reason = str(error)
            if isinstance(error, ValueError):
                self._drop(name, entry, reason)
                return True
        if self._context.clock() - entry.since > _PATIENCE:
            self._drop(name, entry, reason)
            return True
        return False

    def _drop(self, name: str, entry: _Waiting, reason: str) -> None:
        header = entry.message.header
        stamp = ns_from_time(header.stamp) / 1e9
        self._warn(name, f"a message in the frame '{header.frame_id}' of {stamp:.3f} s is dropped:"
                   f' {reason}; the newest robot state is of {self._history.newest_ns / 1e9:.3f} s'
                   )

    def _warn(self, name: str, text: str) -> None:
        now = self._context.clock()
        if now - self._warned.get(name, -_WARNING_PERIOD) >= _WARNING_PERIOD:
            self._warned[name] = now
            self._context.logger.warning(f"octomap, sensor '{name}': {text}")

    # ---------------------------------------------------------------- the thread of the map

    def _hand_on(self, name: str, message: Any, q: Vector, sensor_pose: Matrix) -> None:
        epoch, place = self._scene_map.epoch, (self._context.scene.content, q)
        self._number += self._lockstep
        self._ready[name, self._number] = lambda: self._add(
            name, message, epoch, place, sensor_pose)
        if not self._busy:
            self._busy = True
            self._submit()

    def _submit(self) -> None:
        """Let the thread of the map work; it begins with the first message."""
        if self._worker is None:
            executor = self._context.node.executor
            assert executor is not None
            self._worker = Worker('octomap', executor)
        self._worker.submit(self._work)

    def _work(self) -> None:
        """Add what waits, the newest of each sensor."""
        while self._ready:
            name, _ = key = next(iter(self._ready))
            add = self._ready.pop(key)
            try:
                add()
            except ValueError as error:
                self._warn(name, f'a message is dropped: {error}')
        self._busy = False
        if self._ready:  # one came after the last check
            self._busy = True
            self._submit()

    def _add(
        self, name: str, message: Any, epoch: int, place: tuple[SceneContent, Vector],
        sensor_pose: Matrix,
    ) -> None:
        sensor, updater = self._sensors[name], self._updaters[name]
        parsed = updater.parse(message)
        sight = Sight(parsed.points, parsed.max_range, parsed.beyond, sensor_pose, *place,
                      *_growth(sensor))
        kept = self._scene_map.add(sight, epoch)
        updater.publish_filtered(message, parsed, kept)


def _growth(sensor: Sensor) -> tuple[float, float, float]:
    """Return factor, offset [m] and spread [m/m^2] by which bodies are larger for a sensor."""
    if isinstance(sensor, DepthImageSensor):
        return 1.0, sensor.padding_offset, DEPTH_NOISE * sensor.padding_scale
    return sensor.padding_scale, sensor.padding_offset, 0.0
