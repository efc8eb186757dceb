# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether motions are free between the states that are looked at, too, and free of each other.

A state from which no joint can move by half a piece's travel and touch anything proves the whole
piece. Pieces that are not proved are halved, down to a millimetre of motion; so states are
looked at closely where something is near, and hardly at all where nothing is (the idea of
Schwarzer, Saha and Latombe 2005, DOI 10.1109/TRO.2004.838012, with margins for distances).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.collision_model import CollisionChecker, Exactly
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.trajectory import JointTrajectory

LONGEST_PIECE = 0.06
"""Largest motion [m] of any point within a piece that is tried to be proved."""

HULL_PIECE = 0.024
"""Longer pieces [m] are judged on hulls alone: halving them is quicker than looking closer."""

EXACT_PIECE = 0.003
"""Pieces up to this length [m] are judged on exact shapes wherever hulls are near."""

SHORTEST_PIECE = 0.001
"""A piece in which no point moves further [m] counts as proved by a free state in it."""


def first_blocked(
    points: Matrix, validity: StateValidity, step: float, places: Vector | None = None,
    clearance: float = 0.0,
) -> float | None:
    """
    Return where a polyline in joint space is not free, None where it is free throughout.

    :param points: (k, m) joint positions; fewer than two are no motion.
    :param step: largest motion [m] of any point between two looks at path constraints.
    :param places: (k,) increasing; what to return a place in, default the number of the point.
    :param clearance: [m] that shall be left to everything.
    """
    if len(points) < 2:
        return None
    travel = np.vstack([np.zeros(points.shape[1]),
                        np.cumsum(np.abs(np.diff(points, axis=0)), axis=0)])
    covered = travel @ validity.displacement_weights
    # Points that move nothing have no place of their own.
    covered += np.arange(len(points)) * (1e-12 * max(float(covered[-1]), 1.0))
    length, width = float(covered[-1]), points.shape[1]
    both = np.hstack([points, travel])
    rates = (both[1:] - both[:-1]) / (covered[1:] - covered[:-1])[:, None]

    def at(where: Vector) -> tuple[Matrix, Matrix]:
        """Return positions and travel at some places."""
        part = covered[1:-1].searchsorted(where, side='right')
        values = both[part] + (where - covered[part])[:, None] * rates[part]
        return values[:, :width], values[:, width:]

    def blocked(where: Vector) -> float | None:
        for place, values in zip(where, at(where)[0], strict=True):
            if not validity.free(values, clearance=clearance):
                known = np.arange(float(len(points))) if places is None else places
                return float(np.interp(place, covered, known))
        return None

    found = None
    longest = LONGEST_PIECE
    if validity.path_constraints is not None:
        longest = min(longest, step)
    borders = np.linspace(0.0, length, 1 + math.ceil(length / longest))
    if validity.path_constraints is not None:
        found = blocked(borders)
    lows, highs = borders[:-1], borders[1:]
    while found is None and len(lows):
        middles = 0.5 * (lows + highs)
        states, half = at(middles)
        reach = np.maximum(half - at(lows)[1], at(highs)[1] - half)
        longest = float(np.max(highs - lows))
        near = validity.may_collide(states, reach, _exactly(longest), clearance)
        lows, middles, highs = lows[near], middles[near], highs[near]
        last = longest <= SHORTEST_PIECE
        if last or longest > HULL_PIECE:
            found = blocked(middles)
        if last:
            break
        lows, highs = np.concatenate([lows, middles]), np.concatenate([middles, highs])
        order = np.argsort(lows)
        lows, highs = lows[order], highs[order]
    return found


def _exactly(length: float) -> Exactly:
    """Return how closely pieces of a length [m] are looked at."""
    if length > HULL_PIECE:
        return Exactly.NEVER
    return Exactly.WHERE_HULLS_TOUCH if length > EXACT_PIECE else Exactly.ALWAYS


STEP = 0.05
"""No joint moves farther between two looked-at states [rad or m]."""
MOST_STATES = 80
"""More than so many states of one motion are not looked at."""


def meeting(
    checker: CollisionChecker,
    q: Vector,
    first: JointTrajectory,
    second: JointTrajectory,
) -> Contact | None:
    """
    Return a contact between what two motions sweep, None where there is none.

    Each state of the one is looked at with each of the other: who comes first does not matter.

    :param checker: in the scene of both motions.
    :param q: (n,) the robot; joints that neither motion has stay as they are.
    :param first: positions of each point.
    :param second: of other joints than the first.
    """
    model = checker.scene.kinematic_model
    moved = [_moved_links(model, motion.joint_names) for motion in (first, second)]
    for state in _states(model, q, first):
        for both in _states(model, state, second):
            if not checker.in_collision(both):
                continue
            for contact in checker.contacts(both):
                links = [_link(checker, name) for name in (contact.body1, contact.body2)]
                if any(links[i] in moved[0] and links[1 - i] in moved[1] for i in (0, 1)):
                    return contact
    return None


def _states(model: KinematicModel, q: Vector, motion: JointTrajectory) -> list[Vector]:
    """Return robot states (n,) along a motion."""
    known = [k for k, name in enumerate(motion.joint_names) if name in model.names]
    places = [model.index(motion.joint_names[k]) for k in known]
    states = []
    for values in _refined(motion.positions[:, known]):
        state = q.copy()
        state[places] = values
        states.append(model.apply_mimic(state))
    return states


def _refined(positions: Matrix) -> Matrix:
    """Return positions (k, m) on straight lines through those given, a step apart."""
    parts = [positions[:1]]
    for before, after in pairwise(positions):
        count = max(1, math.ceil(float(np.abs(after - before).max(initial=0.0)) / STEP))
        shares = np.arange(1, count + 1)[:, None] / count
        parts.append(before + shares * (after - before))
    all_of_them = np.concatenate(parts)
    chosen = np.linspace(0, len(all_of_them) - 1, min(len(all_of_them), MOST_STATES))
    refined: Matrix = all_of_them[np.unique(np.round(chosen).astype(int))]
    return refined


def _moved_links(model: KinematicModel, joints: Sequence[str]) -> frozenset[str]:
    """Return the links that joints move: those below them."""
    moved: set[str] = set()
    for name, joint in model.robot.joints.items():
        if name in joints or joint.parent in moved:
            moved.add(joint.child)
    return frozenset(moved)


def _link(checker: CollisionChecker, body: str) -> str:
    """Return the link that a body is or that carries it."""
    carried = checker.scene.attached.get(body)
    return body if carried is None else carried.link_name
