# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Planning groups and grippers, found from the kinematic tree.

An arm is a chain of movable joints that does not branch. Where it branches into short pieces
(fingers), or ends in a joint whose name is that of a jaw, those are its gripper.
"""

from __future__ import annotations

from dataclasses import dataclass
import re

from armsim_ros.model.robot_model import Joint, RobotModel

#: A chain with fewer joints of its own is not an arm.
LEAST_ARM_JOINTS = 3

_JAW = re.compile(r'grip|finger|jaw|claw|knuckle|hand', re.IGNORECASE)
_TOOL_WORDS = {'tool', 'tcp', 'ee', 'eef', 'end', 'tip', 'flange'}


@dataclass(frozen=True)
class FoundGroup:
    """
    A group for the SRDF.

    :param chain: (base link, tip link) of an arm; None for a gripper.
    :param joints: all its movable joints, those that follow others too.
    :param parent: of a gripper: the arm that carries it.
    :param parent_link: of a gripper: the arm's link that carries it.
    """

    name: str
    joints: tuple[str, ...]
    active_joints: tuple[str, ...]
    chain: tuple[str, str] | None = None
    parent: str = ''
    parent_link: str = ''


@dataclass
class _Chain:
    """Movable joints in a chain, and the link where they end or branch."""

    joints: list[Joint]
    end: str
    branches: list[list[Joint]]


def find_groups(robot: RobotModel) -> list[FoundGroup]:
    """Return arms, each followed by its gripper; empty where the robot has no chain of joints."""
    return _Finder(robot).groups()


class _Finder:
    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._below: dict[str, list[Joint]] = {name: [] for name in robot.links}
        for joint in robot.joints.values():
            self._below[joint.parent].append(joint)

    def groups(self) -> list[FoundGroup]:
        chains = self._chains(self._robot.root_link)
        arms = [chain for chain in chains if _active(chain.joints) >= LEAST_ARM_JOINTS]
        if not arms and chains:
            arms = [max(chains, key=lambda chain: _active(chain.joints))]
        found: list[FoundGroup] = []
        for chain in arms:
            found += self._arm(chain, arms)
        return found

    def _chains(self, link: str) -> list[_Chain]:
        """Return the chains that begin at or below a link, upper ones first."""
        chain = self._walk(link)
        found = [chain] if chain.joints else []
        for branch in chain.branches:
            if _active(branch) >= LEAST_ARM_JOINTS or not chain.joints:
                found += self._chains_from(branch[0])
        return found

    def _chains_from(self, joint: Joint) -> list[_Chain]:
        below = self._chains(joint.child)
        if below and below[0].joints and below[0].joints[0].parent in self._rigid(joint.child):
            below[0].joints.insert(0, joint)
            return below
        return [_Chain([joint], joint.child, []), *below]

    def _walk(self, link: str) -> _Chain:
        """Follow the only way down that has movable joints, until there is none or several."""
        joints: list[Joint] = []
        while True:
            ways = [(joint, self._movable_below(joint)) for joint in self._below[link]]
            ways = [(joint, movable) for joint, movable in ways if movable]
            if len(ways) != 1:
                return _Chain(joints, link, [movable for _, movable in ways])
            joint = ways[0][0]
            if joint.movable:
                joints.append(joint)
            link = joint.child

    def _movable_below(self, joint: Joint) -> list[Joint]:
        found = [joint] if joint.movable else []
        for inner in self._below[joint.child]:
            found += self._movable_below(inner)
        return found

    def _arm(self, chain: _Chain, arms: list[_Chain]) -> list[FoundGroup]:
        joints = list(chain.joints)
        fingers = [joint for branch in chain.branches for joint in branch
                   if _active(branch) < LEAST_ARM_JOINTS]
        palm = chain.end
        while not chain.branches and _active(joints) > 1 and _JAW.search(joints[-1].name):
            fingers.insert(0, joints.pop())
            palm = fingers[0].parent
        name = 'arm' if len(arms) == 1 else f'{_common_name(joints)}_arm'
        last = joints[-1].child
        carrier = palm if palm == last else self._robot.joints[
            self._robot.parent_joint[palm]].parent
        tip = self._tool(last) if not fingers or (palm == last and _tools(self._frames(last))) \
            else carrier
        arm = FoundGroup(name, tuple(joint.name for joint in joints),
                         tuple(joint.name for joint in joints if joint.active),
                         (joints[0].parent, tip))
        if not any(joint.active for joint in fingers):
            return [arm]
        gripper = 'gripper' if len(arms) == 1 else f'{_common_name(joints)}_gripper'
        return [arm, FoundGroup(gripper, tuple(joint.name for joint in fingers),
                                tuple(joint.name for joint in fingers if joint.active),
                                None, name, carrier)]

    def _tool(self, last: str) -> str:
        """Return the end frame: the deepest without geometry, first those named as a tool."""
        frames = self._frames(last)
        named = _tools(frames)
        for requested in ('tool0', 'tcp'):
            exact = [link for link in named if link.endswith(requested)]
            if exact:
                return exact[0]
        if named:
            return named[0]
        rigid = self._rigid(last)
        return rigid[-1] if len(frames) <= 1 else last

    def _frames(self, last: str) -> list[str]:
        """Return the bare links fixed to a link with nothing below them."""
        return [link for link in self._rigid(last)
                if link != last and not self._below[link]
                and not self._robot.links[link].collisions]

    def _rigid(self, link: str) -> list[str]:
        """Return a link and those fixed to it, the nearest first."""
        found = [link]
        for rigid in found:
            found += [joint.child for joint in self._below[rigid] if not joint.movable]
        return found


def _active(joints: list[Joint]) -> int:
    return sum(joint.active for joint in joints)


def _tools(links: list[str]) -> list[str]:
    return [link for link in links if _TOOL_WORDS & set(re.split('[^a-z]+', link.lower()))]


def _common_name(joints: list[Joint]) -> str:
    """Return the words that all names share: 'left' for left_hip, left_knee; else the base."""
    words = [joint.name.split('_') for joint in joints]
    common = [first for first, *others in zip(*words, strict=False) if {first} == {first, *others}]
    return '_'.join(word for word in common if word != 'joint') or joints[0].parent
