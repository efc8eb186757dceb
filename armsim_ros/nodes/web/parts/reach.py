# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Commands about the goal, and whether it can be reached, as move_group computes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from moveit_msgs.srv import GetPositionIK, GetStateValidity

from armsim_ros.arrays import Matrix
from armsim_ros.clients.description import tip_of
from armsim_ros.clients.motion import robot_state, stamped_pose, SUCCESS
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.web.page import Page, PanelCommand


class ChooseGroup(PanelCommand):
    """Another planning group."""

    name: str


class ChooseState(PanelCommand):
    """A named state, or a keyword for others."""

    name: str


class SetJoints(PanelCommand):
    """Joint positions [rad or m]."""

    values: dict[str, float]


class ChooseStart(PanelCommand):
    """Where plans begin: the current state, a named state, or the state of the ghost."""

    name: str


#: How long inverse kinematics may search while the tool is dragged [s].
_IK_TIME = 0.05


class Reach:
    """Checks goals."""

    def __init__(self, page: Page) -> None:
        self.page = page

    async def validity(self, group: str, positions: Mapping[str, float]) -> Any:
        """Return the answer of check_state_validity for joint positions [rad or m]."""
        return await self.page.call(GetStateValidity, '/check_state_validity',
                                    GetStateValidity.Request(
                                        group_name=group, robot_state=robot_state(positions)))

    async def pose(self, robot: RobotModel, group: str, pose: Matrix,
                   seed: Mapping[str, float]) -> tuple[dict[str, float], dict[str, Any]]:
        """Return joint positions for a pose of the tip, and what they are worth."""
        found = await self._inverse(robot, group, pose, seed, False)
        if found is None:
            return dict(seed), {'kind': 'unreachable', 'touching': [],
                                'text': 'no joint positions reach this pose'}
        verdict = await self.collisions(group, found)
        if verdict['kind'] == 'collision':
            free = await self._inverse(robot, group, pose, seed, True)
            if free is not None:
                return free, await self.collisions(group, free)
        return found, verdict

    async def _inverse(self, robot: RobotModel, group: str, pose: Matrix,
                       seed: Mapping[str, float], free: bool) -> dict[str, float] | None:
        request = GetPositionIK.Request()
        query = request.ik_request
        query.group_name, query.avoid_collisions = group, free
        query.ik_link_name = tip_of(robot.group(group))
        query.robot_state = robot_state(seed)
        query.pose_stamped = stamped_pose(robot.root_link, pose)
        query.timeout.nanosec = int(_IK_TIME * 1e9)
        answer = await self.page.call(GetPositionIK, '/compute_ik', request)
        if answer.error_code.val != SUCCESS:
            return None
        state = answer.solution.joint_state
        values = dict(zip(state.name, state.position, strict=True))
        return {name: values.get(name, value) for name, value in seed.items()}

    async def collisions(self, group: str, positions: Mapping[str, float]) -> dict[str, Any]:
        """Check joint positions [rad or m]: kind, text, pairs that touch."""
        answer = await self.validity(group, positions)
        if answer.valid:
            return {'kind': 'reachable', 'text': 'reachable', 'touching': []}
        pairs = sorted({tuple(sorted((contact.contact_body_1, contact.contact_body_2)))
                        for contact in answer.contacts})
        if not pairs:
            return {'kind': 'collision', 'text': 'the joint limits or a constraint are violated',
                    'touching': []}
        names = ', '.join(f'{link} touches {other}' for link, other in pairs[:3])
        more = f' and {len(pairs) - 3} more' if len(pairs) > 3 else ''
        return {'kind': 'collision', 'text': f'in collision: {names}{more}',
                'touching': [list(pair) for pair in pairs]}
