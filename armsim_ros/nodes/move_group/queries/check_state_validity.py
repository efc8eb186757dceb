# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``check_state_validity``."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Point, Vector3
from moveit_msgs.msg import ConstraintEvalResult, ContactInformation
from moveit_msgs.srv import GetStateValidity as Service

from armsim_ros.nodes.conversions.constraints import constraints_from_message
from armsim_ros.nodes.conversions.robot_state import start_state_from_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported
from armsim_ros.nodes.move_group.planning.planning_job import log_refused
from armsim_ros.planning.collision.contacts import Contact


class CheckStateValidity:
    """
    Answers whether a state is collision-free and satisfies constraints, and lists contacts.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'check_state_validity', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        response.valid = False
        with reported(self._context.logger, 'check_state_validity', None):
            await self._fill(request, response)
        return response

    async def _fill(self, request: Service.Request, response: Service.Response) -> None:
        context = self._context
        present = await context.present_scene()
        scene = context.started(present, start_state_from_message(request.robot_state))
        log_refused(scene, context.logger)
        constraints = constraints_from_message(request.constraints)
        report = await context.queries.submit(
            lambda: context.query_planner.check_state(
                scene, scene.q, request.group_name, constraints
            )
        )
        stamp = context.node.get_clock().now().to_msg()
        response.contacts = [
            contact_message(contact, context.frame, stamp) for contact in report.contacts
        ]
        response.constraint_result = [
            ConstraintEvalResult(result=item.satisfied, distance=float(item.distance))
            for item in report.constraint_results
        ]
        response.valid = bool(report.valid)


def contact_message(contact: Contact, frame: str, stamp: Any) -> ContactInformation:
    """Return the message of a contact, in the model frame."""
    message = ContactInformation(
        depth=float(contact.depth),
        contact_body_1=contact.body1,
        contact_body_2=contact.body2,
        body_type_1=int(contact.type1),
        body_type_2=int(contact.type2),
    )
    message.header.frame_id, message.header.stamp = frame, stamp
    x, y, z = map(float, contact.position)
    message.position = Point(x=x, y=y, z=z)
    x, y, z = map(float, contact.normal)
    message.normal = Vector3(x=x, y=y, z=z)
    return message
