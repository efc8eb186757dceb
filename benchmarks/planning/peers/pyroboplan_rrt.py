# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""pyroboplan: RRT-Connect and shortcuts in Python, as in its examples."""

from __future__ import annotations

from typing import Any

import numpy as np
from pinocchio_models import PinocchioModels
from pyroboplan.planning.path_shortcutting import shortcut_path
from pyroboplan.planning.rrt import RRTPlanner, RRTPlannerOptions
from worker import serve


class Planner:
    """pyroboplan's planner."""

    def __init__(self, robot: dict[str, Any]) -> None:
        self.models = PinocchioModels(robot)

    def prepare(self, problem: dict[str, Any]) -> None:
        """Add the obstacles."""
        self.scene = self.models.scene(problem)

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Plan and shorten; its ways of timing keep neither path nor duration in view."""
        np.random.seed(seed)
        options = RRTPlannerOptions(
            max_step_size=0.05, max_connection_dist=5.0, goal_biasing_probability=0.15,
            bidirectional_rrt=True, max_planning_time=float(seconds), rng_seed=seed)
        planner = RRTPlanner(self.models.model, self.scene, options=options)
        path = planner.plan(np.array(problem['start']), np.array(problem['goal']))
        if path is None:
            return {'message': 'no path'}
        return {'path': np.array(shortcut_path(
            self.models.model, self.scene, path, max_iters=100, max_step_size=0.05))}


if __name__ == '__main__':
    serve(Planner)
