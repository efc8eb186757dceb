# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A judge of motions that shares no code with any planner.

Pinocchio reads the URDF and its meshes; every pair that the SRDF does not allow is checked with
plain ``computeCollisions``, without a broad phase, hulls or margins, in steps of 0.0017 rad.
The requests include contacts and so penetration depths: without, as in the requests that Pinocchio
makes itself, coal loses contacts of shapes that are parallel to each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
import math
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

STEP = 0.0017
"""Largest motion of any joint between two checks [rad]."""

LIMIT_TOLERANCE = 0.01
"""Share by which velocity and acceleration may be above their limits."""

_POSITION_TOLERANCE = 1e-4
_GOAL_TOLERANCE = 1e-3
_LARGEST_SPACING = 0.1


@dataclass(frozen=True)
class Verdict:
    """
    What a judge found.

    :param clean: nothing is wrong.
    :param fault: the first thing that is, '' for nothing.
    :param length: of the polyline in joint space [rad].
    :param duration: [s], 0 for a path without times.
    """

    clean: bool
    fault: str
    length: float
    duration: float = 0.0


class Referee:
    """
    Judges paths and trajectories of one robot.

    :param urdf: with absolute paths of the meshes.
    :param joints: the moving joints in the order of all paths.
    :param velocity: limit of every joint [rad/s].
    :param acceleration: limit of every joint [rad/s^2].
    """

    def __init__(
        self, urdf: str | Path, srdf: str | Path, joints: Sequence[str], *,
        velocity: float, acceleration: float
    ) -> None:
        self._model = pin.buildModelFromUrdf(str(urdf))
        self._robot = pin.buildGeomFromUrdf(self._model, str(urdf), pin.GeometryType.COLLISION)
        self._srdf = str(srdf)
        self._order = [self._model.joints[self._model.getJointId(name)].idx_q for name in joints]
        if sorted(self._order) != list(range(self._model.nq)):
            raise ValueError('a path has to name every joint that moves')
        self._velocity, self._acceleration = velocity, acceleration

    def path(self, problem: Any, waypoints: np.ndarray) -> Verdict:
        """Judge a polyline (k, m)."""
        points = np.asarray(waypoints, dtype=float)
        fault = self._ends(problem, points) or self._bounds(points)
        if not fault:
            fault = self._collision(problem, self._between(points))
        return Verdict(not fault, fault, _length(points))

    def trajectory(
        self, problem: Any, times: np.ndarray, positions: np.ndarray,
        velocities: np.ndarray | None = None, accelerations: np.ndarray | None = None
    ) -> Verdict:
        """
        Judge timed points as a controller runs them.

        :param times: (k,) [s].
        :param positions: (k, m); straight lines lie between them, or quintic polynomials where
            the other two are given.
        """
        times, positions = np.asarray(times, float), np.asarray(positions, float)
        dense, samples = times, positions
        fault = self._ends(problem, positions)
        if not fault and np.any(np.diff(times) <= 0.0):
            fault = 'times do not increase'
        if not fault and np.max(np.diff(times), initial=0.0) > _LARGEST_SPACING + 1e-9:
            fault = 'two points are more than 0.1 s apart'
        if not fault and velocities is not None and accelerations is not None:
            dense, samples, speed, rate = _quintics(
                times, positions, np.asarray(velocities, float), np.asarray(accelerations, float))
            for name, values, limit in (('velocity', speed, self._velocity),
                                        ('acceleration', rate, self._acceleration)):
                most = float(np.max(np.abs(values)))
                if most > limit * (1.0 + LIMIT_TOLERANCE):
                    fault = fault or f'{name} {most:.3f} is above its limit {limit:.3f}'
            if np.any(np.abs(speed[[0, -1]]) > 1e-6):
                fault = fault or 'it does not begin and end at rest'
        fault = fault or self._bounds(samples)
        if not fault:
            fault = self._collision(problem, self._between(samples))
        return Verdict(not fault, fault, _length(samples), float(dense[-1]))

    # ---------------------------------------------------------------- parts

    def _ends(self, problem: Any, points: np.ndarray) -> str:
        for name, wanted, point in (('start', problem.start, points[0]),
                                    ('goal', problem.goal, points[-1])):
            off = float(np.max(np.abs(np.array(wanted) - point)))
            if not off <= _GOAL_TOLERANCE:
                return f'it is {off:.4f} rad away from the {name}'
        return ''

    def _bounds(self, points: np.ndarray) -> str:
        low = self._model.lowerPositionLimit[self._order] - _POSITION_TOLERANCE
        high = self._model.upperPositionLimit[self._order] + _POSITION_TOLERANCE
        if np.all(np.isfinite(points)) and np.all(points >= low) and np.all(points <= high):
            return ''
        return 'a position is beyond its limits'

    @staticmethod
    def _between(points: np.ndarray) -> Iterator[np.ndarray]:
        yield points[0]
        for a, b in pairwise(points):
            count = max(1, math.ceil(float(np.max(np.abs(b - a))) / STEP))
            for k in range(1, count + 1):
                yield a + (b - a) * (k / count)

    def _collision(self, problem: Any, states: Iterator[np.ndarray]) -> str:
        geometry = self._scene(problem.obstacles)
        data, geometry_data = self._model.createData(), pin.GeometryData(geometry)
        for k in range(len(geometry.collisionPairs)):
            geometry_data.collisionRequests[k] = coal.CollisionRequest(
                coal.CollisionRequestFlag.CONTACT, 1)
        q = np.zeros(self._model.nq)
        for state in _thinned(states):
            q[self._order] = state
            if pin.computeCollisions(self._model, data, geometry, geometry_data, q, True):
                pair = next(
                    pair for pair, result in zip(
                        geometry.collisionPairs, geometry_data.collisionResults, strict=True)
                    if result.isCollision())
                names = [geometry.geometryObjects[k].name for k in (pair.first, pair.second)]
                return f'{names[0]} touches {names[1]} at {np.round(state, 3).tolist()}'
        return ''

    def _scene(self, obstacles: Sequence[dict[str, Any]]) -> Any:
        geometry = pin.GeometryModel(self._robot)
        for each in obstacles:
            shape = (
                coal.Box(*each['size']) if each['type'] == 'box'
                else coal.Cylinder(each['radius'], each['length']))
            x, y, z, w = each['quat_xyzw']
            placement = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array(each['position']))
            geometry.addGeometryObject(
                pin.GeometryObject(f"obstacle {each['id']}", 0, placement, shape))
        geometry.addAllCollisionPairs()
        pin.removeCollisionPairs(self._model, geometry, self._srdf)
        return geometry


def _thinned(states: Iterator[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield a state once it is half a step away from the one before, and the last."""
    kept, waiting = None, None
    for state in states:
        if kept is None or float(np.max(np.abs(state - kept))) >= 0.5 * STEP:
            kept, waiting = state, None
            yield state
        else:
            waiting = state
    if waiting is not None:
        yield waiting


def _length(points: np.ndarray) -> float:
    return float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def _quintics(
    times: np.ndarray, p: np.ndarray, v: np.ndarray, a: np.ndarray, parts: int = 12
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return times, positions, velocities and accelerations of the polynomials in between."""
    found: list[tuple[Any, ...]] = []
    for k, h in enumerate(np.diff(times)):
        d = p[k + 1] - p[k] - v[k] * h - 0.5 * a[k] * h**2
        e = (v[k + 1] - v[k] - a[k] * h) * h
        f = (a[k + 1] - a[k]) * h**2
        c3, c4, c5 = 10 * d - 4 * e + 0.5 * f, -15 * d + 7 * e - f, 6 * d - 3 * e + 0.5 * f
        for x in np.linspace(0.0, 1.0, parts, endpoint=False):
            found.append((
                times[k] + x * h,
                p[k] + v[k] * h * x + 0.5 * a[k] * (h * x)**2 + c3 * x**3 + c4 * x**4 + c5 * x**5,
                v[k] + a[k] * h * x + (3 * c3 * x**2 + 4 * c4 * x**3 + 5 * c5 * x**4) / h,
                a[k] + (6 * c3 * x + 12 * c4 * x**2 + 20 * c5 * x**3) / h**2,
            ))
    found.append((times[-1], p[-1], v[-1], a[-1]))
    t, positions, velocities, accelerations = zip(*found, strict=True)
    return np.array(t), np.array(positions), np.array(velocities), np.array(accelerations)
