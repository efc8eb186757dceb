# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""OMPL's Python package as its demos use it: RRTConnect, everything else at its default."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou
import pinocchio as pin
from pinocchio_models import PinocchioModels
from toppra import algorithm, constraint, SplineInterpolator
from worker import serve

ou.setLogLevel(ou.LOG_NONE)


class Planner:
    """SimpleSetup with a callback that asks Pinocchio for collisions of the meshes."""

    def __init__(self, robot: dict[str, Any]) -> None:
        self.robot = robot
        self.models = PinocchioModels(robot)
        self.model = self.models.model
        self.data = self.model.createData()

    def prepare(self, problem: dict[str, Any]) -> None:
        """Add the obstacles."""
        self.scene = self.models.scene(problem)
        self.scene_data = pin.GeometryData(self.scene)

    def valid(self, state: Any) -> bool:
        """Return whether a state is free."""
        q = np.array([state[k] for k in range(self.model.nq)])
        return not pin.computeCollisions(
            self.model, self.data, self.scene, self.scene_data, q, True)

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Solve, simplify, and time with toppra on a spline."""
        ou.RNG.setSeed(seed + 1)
        count = self.model.nq
        space = ob.RealVectorStateSpace(count)
        bounds = ob.RealVectorBounds(count)
        for k in range(count):
            bounds.setLow(k, float(self.model.lowerPositionLimit[k]))
            bounds.setHigh(k, float(self.model.upperPositionLimit[k]))
        space.setBounds(bounds)
        setup = og.SimpleSetup(space)
        information = setup.getSpaceInformation()
        setup.setStateValidityChecker(self.valid)
        start, goal = information.allocState(), information.allocState()
        for k in range(count):
            start[k], goal[k] = problem['start'][k], problem['goal'][k]
        setup.setStartAndGoalStates(start, goal)
        setup.setPlanner(og.RRTConnect(information))
        setup.solve(float(seconds))
        if not setup.haveExactSolutionPath():
            return {'message': 'no solution'}
        setup.simplifySolution()
        path = np.array([
            [state[k] for k in range(count)] for state in setup.getSolutionPath().getStates()])
        return {'path': path, **timed(path, self.robot)}


def timed(path: NDArray[np.float64], robot: dict[str, Any]) -> dict[str, Any]:
    """Return the motion that toppra's README gets from waypoints."""
    count = path.shape[1]
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    limits = [np.full(count, robot[name]) for name in ('velocity', 'acceleration')]
    instance = algorithm.TOPPRA(
        [constraint.JointVelocityConstraint(np.stack([-limits[0], limits[0]], axis=1)),
         constraint.JointAccelerationConstraint(np.stack([-limits[1], limits[1]], axis=1))],
        SplineInterpolator(places, path), parametrizer='ParametrizeConstAccel')
    motion = instance.compute_trajectory()
    if motion is None:
        return {}
    times = np.append(np.arange(0.0, motion.duration, 0.01), motion.duration)
    return {'times': times, 'positions': motion(times)}


if __name__ == '__main__':
    serve(Planner)
