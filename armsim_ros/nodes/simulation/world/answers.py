# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How requests to the simulated world are carried out and answered."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future as LoopFuture
from functools import wraps
import math
from queue import SimpleQueue
import threading
from typing import Any, TypeVar

from geometry_msgs.msg import Pose, Vector3
import numpy as np
from rclpy.node import Node
from rclpy.task import Future
from simulation_interfaces.msg import Bounds, EntityState, Result

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ArmsimError, SimulationError
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.world.entities import EntityState as State
from armsim_ros.sim.world.entities import relative_state, UnknownEntityError, WORLD_FRAME

#: How far the norm of a quaternion may be from 1.
NORM_TOLERANCE = 0.01


class RefusedError(ArmsimError):
    """A request cannot be carried out; ``code`` is for its result."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class RefusedPoseError(ArmsimError):
    """A message holds a pose that no entity can have."""


def refuse(result: Result, code: int, text: str) -> None:
    """Fill in why a request is refused."""
    result.result, result.error_message = code, text


def answered(service: Callable[..., Any]) -> Callable[..., Any]:
    """Turn a service's errors into its result, which is OK otherwise."""

    @wraps(service)
    async def answer(self: Any, request: Any, response: Any) -> Any:
        response.result.result = Result.RESULT_OK
        try:
            await service(self, request, response)
        except RefusedError as error:
            refuse(response.result, error.code, str(error))
        except UnknownEntityError as error:
            refuse(response.result, Result.RESULT_NOT_FOUND, str(error))
        except ArmsimError as error:
            refuse(response.result, Result.RESULT_OPERATION_FAILED, str(error))
        return response

    return answer


def checked_pose(message: Pose) -> Matrix:
    """
    Return a pose (4, 4).

    :raises RefusedPoseError: a number that is none, or a quaternion that is not a rotation.
    """
    position, turn = message.position, message.orientation
    xyz = (position.x, position.y, position.z)
    quat = (turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, (*xyz, *quat))):
        raise RefusedPoseError(f'the pose has a number that is not finite: {[*xyz, *quat]}')
    norm = math.sqrt(sum(part * part for part in quat))
    if abs(norm - 1.0) > NORM_TOLERANCE:
        raise RefusedPoseError(
            f'the quaternion has the norm {norm:.4g}; allowed: 1 within {NORM_TOLERANCE}')
    return pose_from_quat_xyzw(xyz, quat)


def given_state(message: EntityState, frame_pose: Callable[[str], Matrix]) -> State:
    """
    Return a state of a message in the world.

    :param frame_pose: finds where a frame is in the world.
    :raises RefusedPoseError: no pose, no numbers, or an unknown frame.
    """
    twist, acceleration = message.twist, message.acceleration
    motion = [np.array((part.x, part.y, part.z)) for part in (
        twist.linear, twist.angular, acceleration.linear, acceleration.angular)]
    if not np.isfinite(motion).all():
        raise RefusedPoseError('twist or acceleration has a number that is not finite')
    state = State(checked_pose(message.pose), *motion)
    return relative_state(state, frame_of(message.header.frame_id, frame_pose))


def frame_of(name: str, frame_pose: Callable[[str], Matrix]) -> Matrix:
    """
    Return the pose of a frame in the world (4, 4).

    :raises RefusedPoseError: there is none of that name.
    """
    try:
        return frame_pose(name)
    except UnknownEntityError as error:
        raise RefusedPoseError(
            f"frame '{name}' is not known: {error}; allowed: '', '{WORLD_FRAME}', a link, an "
            'entity') from None


def state_message(state: State, time_ns: int) -> EntityState:
    """Return the message of a state at a simulated time [ns]."""
    message = EntityState(pose=pose_to_message(state.pose))
    message.header.frame_id = WORLD_FRAME
    fill_time(message.header.stamp, time_ns)
    message.twist.linear = vector(state.linear)
    message.twist.angular = vector(state.angular)
    message.acceleration.linear = vector(state.linear_acceleration)
    message.acceleration.angular = vector(state.angular_acceleration)
    return message


def box(low: Matrix, high: Matrix) -> Bounds:
    """
    Return the message of a box, whose largest corner comes first.

    :param low: its smallest corner (3,) [m].
    :param high: its largest corner (3,) [m].
    """
    return Bounds(type=Bounds.TYPE_BOX, points=[vector(high), vector(low)])


def vector(values: Matrix) -> Vector3:
    """Return three numbers as a message."""
    x, y, z = (float(value) for value in values)
    return Vector3(x=x, y=y, z=z)


ValueT = TypeVar('ValueT')


class Work:
    """
    Runs functions elsewhere and resumes the coroutine that waits for them.

    Changes of the world are made in sequence in a thread of their own: to compile a
    world takes longer than a tick of the loop.
    """

    def __init__(self, node: Node, loop: ControlLoop, dispatcher: Dispatcher) -> None:
        self.loop, self._node, self._dispatcher = loop, node, dispatcher
        self._changes: SimpleQueue[tuple[Callable[[], Any], LoopFuture[Any]]] = SimpleQueue()
        self._thread: threading.Thread | None = None

    async def in_loop(self, function: Callable[[], ValueT]) -> ValueT:
        """
        Return the result of a function that runs between two ticks.

        :raises SimulationError: the simulation ends.
        """
        return await self.finished(self.loop.call(function))

    async def beside(self, change: Callable[[], ValueT]) -> ValueT:
        """
        Return the result of a change of the world; changes are made in order of arrival.

        In it, ``wait_for_loop`` waits for what has to run between two ticks.

        :raises SimulationError: the simulation ends.
        """
        future: LoopFuture[ValueT] = LoopFuture()
        self._changes.put((change, future))
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name='world', daemon=True)
            self._thread.start()
        return await self.finished(future)

    def wait_for_loop(self, function: Callable[[], ValueT]) -> ValueT:
        """Return the result of a function that runs between two ticks; only within a change."""
        return _result(self.loop.call(function))

    async def finished(self, future: LoopFuture[ValueT]) -> ValueT:
        """
        Return the result of work in another thread.

        :raises SimulationError: the simulation ends.
        """
        done = Future()
        future.add_done_callback(lambda _: self._dispatcher.post(lambda: self._resume(done)))
        await done
        return _result(future)

    def _resume(self, done: Future) -> None:
        done.set_result(None)
        wake(self._node)

    def _run(self) -> None:
        while True:
            change, future = self._changes.get()
            try:
                future.set_result(change())
            except BaseException as error:  # noqa: BLE001 - it belongs to the caller
                future.set_exception(error)


def _result(future: LoopFuture[ValueT]) -> ValueT:
    try:
        return future.result()
    except BaseException as error:
        if future.cancelled():
            raise SimulationError('the simulation ends') from None
        raise error
