# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two motions that run at once may meet."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.trajectory import JointTrajectory

STEP = 0.05
"""No joint moves farther between two looked-at states [rad or m]."""
MOST_STATES = 80
"""More than so many states of a motion are not checked."""


def meeting(
    checker: CollisionChecker,
    q: Vector,
    first: JointTrajectory,
    second: JointTrajectory,
) -> Contact | None:
    """
    Return a contact between what two motions sweep, None where there is none.

    Each state of the first is checked with each of the second, independent of timing.

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
    given = motion.positions[~np.isnan(motion.positions).any(axis=1)]
    for values in _refined(given[:, known]):
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
