# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""roboplan: RRT-Connect in C++, its shortcutter and its TOPP-RA, as in its examples."""

from __future__ import annotations

import pathlib
import sys
import tempfile
from typing import Any

# The script's folder has modules of the same names as the packages.
folder = str(pathlib.Path(__file__).parent)
sys.path.remove(folder)
import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402
import roboplan.core as core  # noqa: E402
import roboplan.rrt as rrt  # noqa: E402
import roboplan.toppra as toppra  # noqa: E402

sys.path.insert(0, folder)
from worker import serve  # noqa: E402


class Planner:
    """A scene and the three tools."""

    def __init__(self, robot: dict[str, Any]) -> None:
        self.robot = robot
        path = pathlib.Path(tempfile.mkdtemp(), 'limits.yaml')
        lines = ['joint_limits:']
        for name in robot['joints']:
            lines += [f'  {name}:', f"    max_acceleration: [{robot['acceleration']}]",
                      '    max_jerk: [1000.0]']
        path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
        self.settings = path

    def prepare(self, problem: dict[str, Any]) -> None:
        """Make a scene with the obstacles."""
        self.scene = core.Scene('robot', core.loadUrdfSceneDescription(self.robot['urdf']))
        self.scene.importSrdf(pathlib.Path(self.robot['srdf']).read_text(encoding='utf-8'))
        self.scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(self.settings))
        for each in problem['obstacles']:
            x, y, z, w = each['quat_xyzw']
            pose = np.eye(4, order='F')
            pose[:3, :3] = rotation(x, y, z, w)
            pose[:3, 3] = each['position']
            colour = np.ones(4)
            if each['type'] == 'box':
                self.scene.addBoxGeometry(
                    each['id'], 'universe', core.Box(*each['size']), pose, colour)
            else:
                self.scene.addCylinderGeometry(
                    each['id'], 'universe', core.Cylinder(each['radius'], each['length']), pose,
                    colour)
        names = [each['id'] for each in problem['obstacles']]
        self.scene.setCollisions([(a, b) for k, a in enumerate(names) for b in names[:k]], False)
        group = self.robot['group']
        self.timing = toppra.PathParameterizerTOPPRA(self.scene, group)

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Plan, shorten, time."""
        group, names = self.robot['group'], self.robot['joints']
        options = rrt.RRTOptions(
            group_name=group, max_nodes=100000, max_connection_distance=0.5,
            max_planning_time=float(seconds), rrt_connect=True)
        planner = rrt.RRT(self.scene, options)
        planner.setRngSeed(seed)
        ends = []
        for key in ('start', 'goal'):
            state = core.JointConfiguration()
            state.joint_names, state.positions = list(names), np.array(problem[key])
            ends.append(state)
        path = planner.plan(*ends)
        shortener = core.PathShortcutter(
            self.scene, core.PathShortcuttingOptions(group_name=group, seed=seed))
        path = shortener.shortcut(path)
        waypoints = np.array(path.positions)
        motion = self.timing.generate(
            path, toppra.TOPPRAOptions(dt=0.01, mode=toppra.SplineFittingMode.LinearBlend))
        return {'path': waypoints, 'times': list(motion.times),
                'positions': np.array(motion.positions)}


def rotation(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    """Return the matrix of a unit quaternion."""
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


if __name__ == '__main__':
    serve(Planner)
