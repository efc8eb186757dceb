# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``/simulation/sync``, ``digest`` and ``dump``; what a step waits for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
import os
from pathlib import Path
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from armsim_ros.config.simulation import RecorderSettings
from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.recording.flight_recorder import FlightRecorder

#: Offered by a move_group with sensors for its octomap.
SYNC_OCTOMAP = '/move_group/sync_octomap'
#: Wall time after which a step is answered without it [s].
_LONGEST_ADDING = 20.0


def serve_trigger(node: Node, work: Work, name: str, function: Callable[[], object]) -> None:
    """
    Create a ``std_srvs/srv/Trigger`` service.

    :param function: returns the message of the answer; called between two ticks.
    """
    async def answer(_: Any, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = str(await work.in_loop(function))
            response.success = True
        except SimulationError as error:
            response.message = str(error)
        return response

    node.create_service(  # type: ignore[misc] # rclpy annotates no coroutine
        Trigger, name, answer, callback_group=ReentrantCallbackGroup())


class OctomapWait:
    """
    Waits until move_group has added to its octomap what cameras have published.

    :param pictures: returns how many pictures were published up to now.
    :param sync: publishes the present joint states, without which a picture is not placed.
    """

    def __init__(
        self, node: Node, work: Work, pictures: Callable[[], int], sync: Callable[[], int]
    ) -> None:
        self._node, self._work, self._pictures, self._sync = node, work, pictures, sync
        self._added = 0
        self._client = node.create_client(
            Trigger, SYNC_OCTOMAP, callback_group=ReentrantCallbackGroup())

    async def __call__(self) -> None:
        """Wait; not for a move_group without an octomap, nor for a picture of before."""
        pictures = self._pictures()
        if pictures == self._added or not self._client.service_is_ready():
            return
        self._added = pictures
        await self._work.in_loop(self._sync)
        answer = self._client.call_async(Trigger.Request())
        patience = self._node.create_timer(
            _LONGEST_ADDING, lambda: answer.done() or answer.set_result(None),
            callback_group=ReentrantCallbackGroup(),
            clock=Clock(clock_type=ClockType.STEADY_TIME))
        if await answer is None:
            self._node.get_logger().warning(
                f"no answer on '{SYNC_OCTOMAP}' within {_LONGEST_ADDING:g} s; the octomap may "
                'lack what the cameras see now')
        self._node.destroy_timer(patience)


class Dump:
    """
    Writes the last seconds of the simulation as MCAP.

    :param recorder: has the last seconds.
    :param events: returns the controllers' latest messages.
    """

    def __init__(
        self, node: Node, work: Work, recorder: FlightRecorder, settings: RecorderSettings,
        events: Callable[[], Iterable[ControllerEvent]]
    ) -> None:
        self._node, self._work, self._recorder, self._settings = node, work, recorder, settings
        self._events = events
        self._writer = ThreadPoolExecutor(1, 'recording')
        node.create_service(  # type: ignore[misc] # rclpy annotates no coroutine
            Trigger, '/simulation/dump', self._answer,
            callback_group=ReentrantCallbackGroup())

    def write_soon(self, reason: str) -> None:
        """Write a recording in the background and log its path; from any thread."""
        self._writer.submit(self._write, self._recorder.frozen(), reason)

    def close(self) -> None:
        """Write what a recording of the whole run was asked for, and end."""
        if self._settings.file:
            path = Path(self._settings.file).expanduser()
            self._writer.submit(self._write, self._recorder.frozen(), 'the end of the run', path)
        self._writer.shutdown(wait=True)

    async def _answer(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        try:
            recorder = await self._work.in_loop(self._recorder.frozen)
        except SimulationError as error:
            response.message = str(error)
            return response
        job = self._writer.submit(self._write, recorder, 'a request')
        response.message, response.success = await self._work.finished(job)
        return response

    def _write(
        self, recorder: FlightRecorder, reason: str, path: Path | None = None
    ) -> tuple[str, bool]:
        """Return the path and True, or the reason for a failure and False."""
        path = path or self._folder() / f'{datetime.now():%Y-%m-%d_%H-%M-%S_%f}.mcap'
        try:
            recorder.save(path, self._events())
        except OSError as error:
            text = f'the recording cannot be written: {error}'
            self._node.get_logger().error(text)
            return text, False
        self._node.get_logger().info(f'recording for {reason}: {path}')
        return str(path), True

    def _folder(self) -> Path:
        if self._settings.folder:
            return Path(self._settings.folder).expanduser()
        home = os.environ.get('ROS_HOME') or '~/.ros'
        return Path(home).expanduser() / 'armsim_recordings'
