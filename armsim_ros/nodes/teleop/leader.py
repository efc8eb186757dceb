# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A leader arm, known by its joint states."""

from __future__ import annotations

from collections.abc import Sequence
import math

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.latest_message import JointStates
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.teleop.following import SILENT
from armsim_ros.tasks.hand import HandModel


class Leader:
    """
    The joints of a leader.

    :param client: subscribes.
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
