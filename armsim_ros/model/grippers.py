# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which links of a robot are the fingers of a gripper."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from armsim_ros.config.controllers.gripper_action_controller import GripperParameters
from armsim_ros.model.cell import Cell, Robot
from armsim_ros.model.robot_model import JointType, RobotModel


@dataclass(frozen=True, slots=True)
class Gripper:
    """
    Links that can hold something between them.

    :param name: that of the SRDF's end effector, else of the controller.
    :param palm: the link that carries the fingers, and what they hold.
    :param bodies: link -> the first link of the rigid body that it belongs to; the fingers'
        links and the palm's.
    """

    name: str
    palm: str
    bodies: dict[str, str]

    @property
    def links(self) -> tuple[str, ...]:
        """All links that may touch what is held."""
        return tuple(self.bodies)


def grippers_of(robot: Robot, joints: Iterable[str] = ()) -> tuple[Gripper, ...]:
    """
    Return the grippers of a robot.

    Each end effector of the SRDF whose group has moving joints is a gripper, and each joint of a
    gripper controller that belongs to none of these.

    :param joints: further ones that move fingers.
    """
    model, found = robot.model, []
    taken: set[str] = set()
    for effector in model.semantic.end_effectors.values():
        group = model.semantic.groups.get(effector.group)
        members = _with_followers(model, group.joints if group is not None else ())
        if members:
            found.append(_gripper(model, effector.name, members))
            taken |= members
    drives = [(controller.name, controller.parameters.joint)
              for controller in robot.settings.controllers
              if isinstance(controller.parameters, GripperParameters)]
    for name, joint in (*drives, *((joint, joint) for joint in joints)):
        members = _with_followers(model, [joint])
        if members and joint not in taken:
            found.append(_gripper(model, name, members))
            taken |= members
    return tuple(found)


def grippers_in(cell: Cell) -> tuple[Gripper, ...]:
    """Return the grippers of all robots."""
    return tuple(gripper for robot in cell.robots for gripper in grippers_of(robot))


def _with_followers(model: RobotModel, names: Iterable[str]) -> frozenset[str]:
    joints = {name for name in names if name in model.joints and model.joints[name].movable}
    followers = (name for name, joint in model.joints.items()
                 if joint.mimic is not None and joint.mimic.joint in joints)
    return frozenset((*joints, *followers))


def _gripper(model: RobotModel, name: str, joints: frozenset[str]) -> Gripper:
    first = next(joint for joint in model.joints.values() if joint.name in joints)
    roots = {_rigid_root(model, first.parent)}
    roots |= {joint.child for joint in model.joints.values() if joint.name in joints}
    bodies = {link: _rigid_root(model, link) for link in model.links}
    return Gripper(name, first.parent,
                   {link: root for link, root in bodies.items() if root in roots})


def _rigid_root(model: RobotModel, link: str) -> str:
    """Return the uppermost link that nothing moves against a link."""
    above = model.parent_joint.get(link)
    while above is not None and model.joints[above].type is JointType.FIXED:
        link = model.joints[above].parent
        above = model.parent_joint.get(link)
    return link
