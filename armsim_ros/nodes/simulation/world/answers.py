# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Results, poses and states as messages of simulation_interfaces."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
import math
from typing import Any

from geometry_msgs.msg import Pose, Vector3
import numpy as np
from simulation_interfaces.msg import Bounds, EntityState, Result

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ArmsimError
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.nodes.conversions.geometry import pose_to_message
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.sim.world.entities import EntityState as State
from armsim_ros.sim.world.entities import relative_state, UnknownEntityError, WORLD_FRAME

#: How far the norm of a quaternion may be from 1.
NORM_TOLERANCE = 0.01


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
    twist = message.twist
    linear = np.array([twist.linear.x, twist.linear.y, twist.linear.z])
    angular = np.array([twist.angular.x, twist.angular.y, twist.angular.z])
    if not (np.isfinite(linear).all() and np.isfinite(angular).all()):
        raise RefusedPoseError('the twist has a number that is not finite')
    state = State(checked_pose(message.pose), linear, angular)
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
    return message


def box(low: Matrix, high: Matrix) -> Bounds:
    """Return a box by its smallest and largest corner (3,) [m]."""
    return Bounds(type=Bounds.TYPE_BOX, points=[vector(low), vector(high)])


def vector(values: Matrix) -> Vector3:
    """Return three numbers as a message."""
    x, y, z = (float(value) for value in values)
    return Vector3(x=x, y=y, z=z)
