# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""vamp: RRT-Connect on spheres with SIMD; its robots are compiled in. Not exact by design."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import vamp
from worker import serve


class Planner:
    """vamp's planner for a robot that it knows by the name of the URDF file."""

    def __init__(self, robot: dict[str, Any]) -> None:
        self.robot = getattr(vamp, pathlib.Path(robot['urdf']).stem)
        name = pathlib.Path(robot['urdf']).stem
        (self.module, self.plan_with, self.settings, self.simplify) = (
            vamp.configure_robot_and_planner_with_kwargs(name, 'rrtc'))

    def prepare(self, problem: dict[str, Any]) -> None:
        """Make an environment."""
        world = vamp.Environment()
        for each in problem['obstacles']:
            x, y, z, w = each['quat_xyzw']
            angles = _euler(x, y, z, w)
            if each['type'] == 'box':
                world.add_cuboid(vamp.Cuboid(
                    each['position'], angles, [0.5 * size for size in each['size']]))
            else:
                world.add_capsule(vamp.Cylinder(
                    each['position'], angles, each['radius'], each['length']))
        self.world = world

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Plan and simplify."""
        sampler = self.module.halton()
        result = self.plan_with(
            problem['start'], problem['goal'], self.world, self.settings, sampler)
        if not result.solved:
            return {'message': 'not solved'}
        path = self.simplify(result.path, self.world, self.settings, sampler).path
        return {'path': np.array(path.numpy())}


def _euler(x: float, y: float, z: float, w: float) -> list[float]:
    """Return roll, pitch, yaw [rad] of a unit quaternion."""
    return [
        float(np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))),
        float(np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))),
        float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))]


if __name__ == '__main__':
    serve(Planner)
