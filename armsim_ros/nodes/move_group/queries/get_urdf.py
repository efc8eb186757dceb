# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``get_urdf``."""

from __future__ import annotations

from xml.etree import ElementTree

from moveit_msgs.srv import GetGroupUrdf as Service

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import fill_error


class GetUrdf:
    """
    Answers with the part of the URDF that a planning group consists of.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'get_urdf', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        groups = self._context.robot.semantic.groups
        if request.group_name not in groups:
            fill_error(
                response.error_code,
                MoveItErrorCode.FAILURE,
                f"planning group '{request.group_name}' is not known; allowed: "
                f"{', '.join(groups) or 'the SRDF has none'}",
                'get_urdf',
            )
            return response
        response.urdf_string = group_urdf(
            self._context.robot.urdf, groups[request.group_name].joints
        )
        fill_error(response.error_code, MoveItErrorCode.SUCCESS)
        return response


def group_urdf(urdf: str, joints: tuple[str, ...]) -> str:
    """Return a URDF of these joints and the links they connect; the first links are empty."""
    whole = ElementTree.fromstring(urdf)
    robot = ElementTree.Element('robot', {'name': whole.get('name', '')})
    chosen = [joint for joint in whole.findall('joint') if joint.get('name') in joints]
    children = {_link(joint, 'child') for joint in chosen}
    links = [link for link in whole.findall('link') if link.get('name') in children]
    bases = {_link(joint, 'parent') for joint in chosen} - children
    robot.extend(ElementTree.Element('link', {'name': name}) for name in sorted(bases))
    robot.extend([*links, *chosen])
    return ElementTree.tostring(robot, encoding='unicode')


def _link(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    return '' if element is None else element.get('link', '')
