# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs/msg/RobotState`` to a start state, and full states back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from moveit_msgs.msg import AttachedCollisionObject, RobotState

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.conversions.collision_object import (
    attached_in_state_from_message,
    attached_object_to_message,
)
from armsim_ros.planning.scene.objects import AttachedObject
from armsim_ros.planning.scene.update import StartState

Value = TypeVar('Value')


def readable(
    convert: Callable[[Any], Value], messages: Iterable[Any]
) -> tuple[tuple[Value, ...], tuple[PlanningError, ...]]:
    """Return what could be converted, and why the rest could not."""
    values: list[Value] = []
    errors: list[PlanningError] = []
    for message in messages:
        try:
            values.append(convert(message))
        except PlanningError as error:
            errors.append(error)
    return tuple(values), tuple(errors)


def start_state_from_message(
    message: RobotState,
    convert: Callable[[AttachedCollisionObject], AttachedObject] = attached_in_state_from_message,
) -> StartState:
    """
    Return the state as it was given; joints are checked where it is used.

    A multi-DOF joint is left out: a fixed arm has none.

    :param convert: reads an attached object; by default as that of a request's start state.
    """
    attached, unreadable = readable(convert, message.attached_collision_objects)
    return StartState(
        joint_names=tuple(message.joint_state.name),
        positions=tuple(float(value) for value in message.joint_state.position),
        velocities=tuple(float(value) for value in message.joint_state.velocity),
        is_diff=bool(message.is_diff),
        attached_objects=attached,
        unreadable=unreadable,
    )


def robot_state_to_message(
    positions: Mapping[str, float],
    frame_id: str,
    *,
    attached: Iterable[AttachedObject] = (),
    is_diff: bool = False,
) -> RobotState:
    """
    Return a full robot state.

    :param positions: joint -> [rad or m].
    :param frame_id: the model frame, for the header.
    :param attached: objects that the robot carries.
    """
    message = RobotState(is_diff=is_diff)
    message.joint_state.header.frame_id = frame_id
    message.joint_state.name = list(positions)
    message.joint_state.position = [float(value) for value in positions.values()]
    message.attached_collision_objects = [attached_object_to_message(item) for item in attached]
    return message
