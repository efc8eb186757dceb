# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A leader arm, known by its joint states, and how an arm follows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math
from typing import TYPE_CHECKING

from armsim_ros.clients.client_node import ClientNode, JointStates
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import JointLimits

if TYPE_CHECKING:  # with it comes the physics
    from armsim_ros.tasks.hand import HandModel

#: The arm follows once every joint is this near to the leader's [rad or m].
NEAR = 0.1
#: Speed of the joint that has farthest to go while the arm approaches the leader [rad/s or m/s].
SLOW = 0.2
#: A leader whose last message is this old is silent [s].
SILENT = 0.3


class Following:
    """
    Follows a leader from the moment on when the arm is near to it.

    :param limits: joint -> its limits.
    :param speed: share of their velocities.
    :param approach: whether the arm goes slowly to a leader that is farther away.
    """

    def __init__(self, limits: Mapping[str, JointLimits], speed: float, *, approach: bool) -> None:
        self._limits, self._approach = limits, approach
        self._speeds = {name: speed * each.velocity for name, each in limits.items()}
        self.engaged = False
        #: For the user.
        self.state = ''

    def step(
        self, leader: Mapping[str, float] | None, at: Mapping[str, float], period: float
    ) -> dict[str, float] | None:
        """
        Return where the joints go within a period, None where they stay.

        :param leader: joint -> position [rad or m]; None where the leader is silent.
        :param at: joint -> where it is commanded to be.
        :param period: [s].
        """
        if leader is None:
            self.engaged, self.state = False, 'the leader is silent; the arm holds'
            return None
        ways = {name: max(limits.lower, min(limits.upper, leader[name])) - at[name]
                for name, limits in self._limits.items()}
        farthest = max(ways, key=lambda name: abs(ways[name]))
        far = abs(ways[farthest])
        self.engaged = self.engaged or far <= NEAR
        if self.engaged:
            self.state = 'the arm follows the leader'
            return {name: at[name] + max(-speed * period, min(speed * period, ways[name]))
                    for name, speed in self._speeds.items()}
        apart = f"'{farthest}' is more than {NEAR:g} rad from the leader's"
        if not self._approach:
            self.state = f'{apart}: move the leader to the arm, or start with --approach'
            return None
        self.state = f'{apart}; the arm approaches'
        share = min(1.0, min(SLOW, *self._speeds.values()) * period / far)
        return {name: at[name] + share * way for name, way in ways.items()}


class Leader:
    """
    The joints of a leader.

    :param topic: of its joint states.
    :param joints: what it needs to have.
    :param patience: for the first message [s].
    :raises ArmsimError: none comes, or it lacks joints.
    """

    def __init__(
        self, client: ClientNode, topic: str, joints: Sequence[str], patience: float
    ) -> None:
        self._topic, self._joints = topic, tuple(joints)
        self._states = JointStates(client, topic, "does the leader's driver run?")
        try:
            self._states.get(patience)
            self._check()
        except ArmsimError:
            self.close()
            raise

    @property
    def positions(self) -> dict[str, float] | None:
        """Joint -> position [rad or m]; None where the leader is silent or not finite."""
        if self._states.age > SILENT:
            return None
        found = self._states.positions
        values = {name: found.get(name, math.nan) for name in self._joints}
        return values if all(map(math.isfinite, values.values())) else None

    def level(self, hand: HandModel) -> float | None:
        """Return how far the leader's gripper is open; None where it has no such joint."""
        position = self._states.positions.get(hand.joint)
        if position is None or not math.isfinite(position):
            return None
        return hand.level_of(position)

    def close(self) -> None:
        """Unsubscribe."""
        self._states.close()

    def _check(self) -> None:
        found = self._states.positions
        if missing := [name for name in self._joints if name not in found]:
            raise ArmsimError(
                f"the leader on '{self._topic}' has no {', '.join(missing)}, only "
                f"{', '.join(found) or 'no joints'}; joints are matched by name")
