# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""States for the SRDF that touch nothing, the floor neither."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.shape_points import corner_points
from armsim_ros.planning.scene.allowed_collision_matrix import sorted_pair
from armsim_ros.tools.generate_config.collision_pairs import LinkPairs, random_state

#: How far the moving links stay above the floor, and from each other [m].
CLEARANCE = 0.01
_TRIES = 2000
_WANTED = 30


def find_states(robot: RobotModel, seed: int = 0) -> dict[str, dict[str, float]]:
    """
    Return 'home' (the default positions, where they are free) and 'ready', another free state.

    :param robot: with the pairs that need no check in its SRDF.
    :param seed: of the random numbers.
    """
    model = KinematicModel(robot)
    # Free in the physics too, where meshes are hulls; some robots' hulls always overlap.
    return _find(model, _Clearances(model, hulls=True), seed) or _find(
        model, _Clearances(model, hulls=False), seed)


def _find(model: KinematicModel, clearances: _Clearances, seed: int
          ) -> dict[str, dict[str, float]]:
    generator = np.random.default_rng(seed)
    middle = model.default()
    found = {'home': middle} if clearances.is_free(middle, 0.0) else {}
    free: list[Vector] = []
    for _ in range(_TRIES):
        q = np.round(middle + 0.5 * (random_state(model, generator) - middle), 3)
        q = model.apply_mimic(q)
        if model.within_limits(q) and clearances.is_free(q):
            free.append(q)
        if len(free) >= _WANTED:
            break
    if free:
        found['ready'] = max(free, key=lambda q: clearances.height(q))
    return {state: {name: round(value, 6) for name, value in model.positions(q).items()
                    if model.robot.joints[name].active} for state, q in found.items()}


class _Clearances:
    """What is around the robot in a state."""

    def __init__(self, model: KinematicModel, *, hulls: bool) -> None:
        self._model = model
        robot = model.robot
        self._links = LinkPairs(model, hulls=hulls)
        solid = self._links.links
        self._pairs = [pair for place, first in enumerate(solid) for second in solid[place + 1:]
                       for pair in [sorted_pair(first, second)]
                       if pair not in robot.semantic.disabled_collisions]
        depth = {robot.root_link: 0}
        for joint in robot.joints.values():
            depth[joint.child] = depth[joint.parent] + int(joint.movable)
        # The first moving link only turns on its base, which is on the floor.
        self._corners = [
            (name, np.vstack([corner_points(item.geometry, item.origin)
                              for item in link.collisions]))
            for name, link in robot.links.items() if depth[name] >= 2 and link.collisions]

    def is_free(self, q: Vector, distance: float = CLEARANCE) -> bool:
        """
        Return whether no links are nearer than a distance, and none is near the floor.

        :param distance: [m]; 0 asks only that nothing touches.
        """
        return self.height(q) > CLEARANCE and not self._links.nearer(q, self._pairs, distance)

    def height(self, q: Vector) -> float:
        """Return the height of the lowest corner of the moving links [m]."""
        poses = self._model.link_poses(q, [name for name, _ in self._corners])
        return min((float(np.min(corners @ pose[2, :3]) + pose[2, 3])
                    for pose, (_, corners) in zip(poses, self._corners, strict=True)
                    if len(corners)), default=np.inf)
