# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The links of a simulated robot: where they are, how they move, and pushes."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.physics.plant import Plant


class SimulatedLinks:
    """What a simulation answers about the links of its robot."""

    model: RobotModel
    _plant: Plant

    def apply_wrench(
        self, link: str, force: ArrayLike = (0, 0, 0), torque: ArrayLike = (0, 0, 0)
    ) -> None:
        """
        Push a link until another wrench is set.

        :param force: (3,) at its centre of mass, world axes [N].
        :param torque: (3,) world axes [N*m].
        :raises SimulationError: a link that is not there.
        """
        self._plant.push(self._link_body(link), force, torque)

    def link_pose(self, link: str) -> Matrix:
        """
        Return where a link is in the world (4, 4).

        :raises SimulationError: a link that is not there.
        """
        return self._plant.pose(self._link_body(link))

    def link_motion(self, link: str) -> tuple[Vector, Vector]:
        """
        Return how a link moves: (3,) [m/s] of its origin and (3,) [rad/s], world axes.

        :raises SimulationError: a link that is not there.
        """
        return self._plant.motion(self._link_body(link))

    def link_bounds(self, links: Sequence[str], frame: str) -> tuple[Vector, Vector]:
        """
        Return the smallest and the largest corner of some links now, (3,) each [m].

        :param frame: the link in whose axes.
        :raises SimulationError: a link that is not there.
        """
        bodies = [self._link_body(link) for link in links]
        return self._plant.bounds(bodies, self._link_body(frame))

    def _link_body(self, link: str) -> int:
        if link not in self.model.links:
            raise SimulationError(
                f"robot '{self.model.name}' has no link '{link}'; "
                + (nearest(link, tuple(self.model.links)) or 'see its URDF')
            )
        return self._plant.body(link)
