# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""pyroboplan: RRT-Connect and shortcuts in Python, as in its examples."""

import coal
import numpy as np
import pinocchio as pin
from pyroboplan.planning.path_shortcutting import shortcut_path
from pyroboplan.planning.rrt import RRTPlanner, RRTPlannerOptions
from worker import serve


class Planner:
    """pyroboplan's planner."""

    def __init__(self, robot):
        self.robot = robot
        self.model = pin.buildModelFromUrdf(robot['urdf'])
        self.geometry = pin.buildGeomFromUrdf(
            self.model, robot['urdf'], pin.GeometryType.COLLISION)

    def prepare(self, problem):
        """Add the obstacles."""
        scene = pin.GeometryModel(self.geometry)
        for each in problem['obstacles']:
            shape = (
                coal.Box(*each['size']) if each['type'] == 'box'
                else coal.Cylinder(each['radius'], each['length'])
            )
            placement = pin.XYZQUATToSE3(np.array([*each['position'], *each['quat_xyzw']]))
            scene.addGeometryObject(pin.GeometryObject(each['id'], 0, placement, shape))
        scene.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, scene, self.robot['srdf'])
        self.scene = scene

    def plan(self, problem, seed, seconds):
        """Plan and shorten; its ways of timing keep neither path nor duration in view."""
        np.random.seed(seed)
        options = RRTPlannerOptions(
            max_step_size=0.05, max_connection_dist=5.0, goal_biasing_probability=0.15,
            bidirectional_rrt=True, max_planning_time=float(seconds), rng_seed=seed)
        planner = RRTPlanner(self.model, self.scene, options=options)
        path = planner.plan(np.array(problem['start']), np.array(problem['goal']))
        if path is None:
            return {'message': 'no path'}
        return {'path': np.array(shortcut_path(
            self.model, self.scene, path, max_iters=100, max_step_size=0.05))}


if __name__ == '__main__':
    serve(Planner)
