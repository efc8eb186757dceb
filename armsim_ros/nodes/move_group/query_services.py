# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``check_state_validity``, ``compute_fk``, ``compute_ik`` and ``get_urdf``."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from geometry_msgs.msg import Point, PoseStamped, Vector3
from moveit_msgs.msg import ConstraintEvalResult, ContactInformation
from moveit_msgs.srv import GetGroupUrdf as Service
from moveit_msgs.srv import GetPositionFK, GetPositionIK, GetStateValidity

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.nodes.conversions.geometry import pose_from_message, pose_to_message
from armsim_ros.nodes.conversions.motion_plan_request import (
    constraints_from_message,
    robot_state_to_message,
    start_state_from_message,
)
from armsim_ros.nodes.conversions.time import seconds_from_duration
from armsim_ros.nodes.move_group.context import Context, fill_error
from armsim_ros.nodes.move_group.planning.planning_job import log_refused
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.queries import IKRequest, LinkPose


class CheckStateValidity:
    """Answers whether a state is collision-free and satisfies constraints, and lists contacts."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(GetStateValidity, 'check_state_validity', self._fill)

    async def _fill(
        self, request: GetStateValidity.Request, response: GetStateValidity.Response
    ) -> None:
        context = self._context
        present = await context.present_scene()
        scene = context.started(present, start_state_from_message(request.robot_state))
        log_refused(scene, context.logger)
        constraints = constraints_from_message(request.constraints)
        planner = context.query_planner
        submit = (context.queries.submit_short if planner.follows(scene) else
                  context.queries.submit)
        report = await submit(
            lambda: planner.check_state(scene, scene.q, request.group_name, constraints))
        stamp = context.node.get_clock().now().to_msg()
        response.contacts = [
            contact_message(contact, context.frame, stamp) for contact in report.contacts]
        response.constraint_result = [
            ConstraintEvalResult(result=item.satisfied, distance=float(item.distance))
            for item in report.constraint_results]
        response.valid = bool(report.valid)


def contact_message(contact: Contact, frame: str, stamp: Any) -> ContactInformation:
    """Return the message of a contact, in the model frame."""
    message = ContactInformation(
        depth=float(contact.depth), contact_body_1=contact.body1, contact_body_2=contact.body2,
        body_type_1=int(contact.type1), body_type_2=int(contact.type2))
    message.header.frame_id, message.header.stamp = frame, stamp
    x, y, z = map(float, contact.position)
    message.position = Point(x=x, y=y, z=z)
    x, y, z = map(float, contact.normal)
    message.normal = Vector3(x=x, y=y, z=z)
    return message


class ComputeFk:
    """Returns the poses of links, attached objects and subframes."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(
            GetPositionFK, 'compute_fk', self._fill, lambda response: response.error_code)

    async def _fill(
        self, request: GetPositionFK.Request, response: GetPositionFK.Response
    ) -> None:
        if not request.fk_link_names:
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME, 'no link names were given', 'compute_fk')
        context = self._context
        present = await context.present_scene()
        scene = context.started(present, start_state_from_message(request.robot_state))
        frame = request.header.frame_id or context.frame
        to_frame = inverse_pose(present.transform(frame))
        unknown = []
        for name in request.fk_link_names:
            if scene.robot_frame(name) is None:
                unknown.append(name)
                continue
            message: Any = PoseStamped()
            message.header.frame_id = frame
            message.header.stamp = context.node.get_clock().now().to_msg()
            message.pose = pose_to_message(to_frame @ scene.frame_pose(name))
            response.pose_stamped.append(message)
            response.fk_link_names.append(name)
        if unknown:
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f"no link, attached object or subframe is called {', '.join(map(repr, unknown))}",
                'compute_fk')
        log_refused(scene, context.logger)
        fill_error(response.error_code, MoveItErrorCode.SUCCESS, scene.refused)


class ComputeIk:
    """Finds joint positions that put links at poses."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(
            GetPositionIK, 'compute_ik', self._fill, lambda response: response.error_code)

    async def _fill(self, asked: GetPositionIK.Request, response: GetPositionIK.Response) -> None:
        context, message = self._context, asked.ik_request
        scene = await context.present_scene()
        request = IKRequest(
            group_name=message.group_name, targets=self._targets(message),
            start_state=start_state_from_message(message.robot_state),
            constraints=constraints_from_message(message.constraints),
            avoid_collisions=bool(message.avoid_collisions),
            timeout=seconds_from_duration(message.timeout))
        clock = context.planning_clock()
        answer = await context.queries.submit(
            lambda: context.query_planner.ik_in_turns(request, scene, clock=clock))
        fill_error(response.error_code, answer.error_code, answer.message, 'compute_ik')
        if answer.error_code == MoveItErrorCode.SUCCESS:
            response.solution = robot_state_to_message(answer.positions, context.frame)

    def _targets(self, message: Any) -> tuple[LinkPose, ...]:
        """Return the targets; a vector of a single pose needs no link."""
        if not message.pose_stamped_vector:
            return (self._target(message.ik_link_name, message.pose_stamped),)
        names = message.ik_link_names
        if len(message.pose_stamped_vector) == 1:
            names = [*names, ''][:1]
        if len(names) != len(message.pose_stamped_vector):
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f'{len(names)} ik_link_names and {len(message.pose_stamped_vector)} poses; '
                'each pose needs its link',
                'compute_ik')
        return tuple(
            self._target(name, pose)
            for name, pose in zip(names, message.pose_stamped_vector, strict=True))

    @staticmethod
    def _target(link_name: str, message: Any) -> LinkPose:
        return LinkPose(link_name, pose_from_message(message.pose), message.header.frame_id)


class GetUrdf:
    """Answers with the part of the URDF that a planning group consists of."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'get_urdf', self._fill, lambda response: response.error_code)

    async def _fill(self, request: Service.Request, response: Service.Response) -> None:
        groups = self._context.robot.semantic.groups
        if request.group_name not in groups:
            fill_error(
                response.error_code, MoveItErrorCode.FAILURE,
                f"planning group '{request.group_name}' is not known; allowed: "
                f"{', '.join(groups) or 'the SRDF has none'}", 'get_urdf')
            return
        response.urdf_string = group_urdf(
            self._context.robot.urdf, request.group_name, groups[request.group_name].joints)
        fill_error(response.error_code, MoveItErrorCode.SUCCESS)


def group_urdf(urdf: str, name: str, joints: tuple[str, ...]) -> str:
    """
    Return a URDF of these joints and the links they connect; the first links are empty.

    :param name: of the group, and of the robot that is returned.
    """
    whole = ElementTree.fromstring(urdf)
    robot = ElementTree.Element('robot', {'name': name})
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
