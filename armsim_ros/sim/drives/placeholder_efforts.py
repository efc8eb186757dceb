# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Effort limits that cannot hold or move the robot, in packages whose hardware never reads them.

A vendor's driver, the mock components and Gazebo Classic follow positions whatever the URDF's
effort is, so many published URDFs have a placeholder there. Other simulators' plugins read it, so
there it counts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.model.robot_model import Joint, RobotModel
from armsim_ros.sim.drives.inverse_dynamics import InverseDynamics
from armsim_ros.sim.physics.robot_spec import bound_or_infinite

#: An effort limit below this multiple of the robot's weight on the joint, and of the joint's dry
#: friction, is a placeholder.
LEAST_SHARE = 1.2
#: So is one below this share of what motions of all joints at once need, which few motions do:
#: the limits of real drives are above it.
LEAST_MOTION_SHARE = 0.5
#: The replaced limit is this multiple of what motions of all joints at once need, so that steps of
#: commands do not saturate the drive.
HEADROOM = 5.0
#: Time in which the drive then brings the joint to its rated velocity [s].
RISE_TIME = 0.25
#: Rated velocity of a joint that has none [rad/s or m/s].
USUAL_VELOCITY = 2.0
#: Random states in which the weight is looked up, besides the start and the named states.
STATES = 64


def with_sufficient_efforts(
    model: RobotModel, settings: SimulationSettings, start: Mapping[str, float]
) -> tuple[RobotModel, tuple[str, ...], Vector]:
    """
    Return a robot whose position drives can hold and move it.

    :param start: joint -> position at the start [rad or m].
    :returns: the robot, a line for each effort limit that was replaced, and the robot's greatest
        weight on each active joint (n,) [N*m or N].
    """
    if not model.active_joints:
        return model, (), np.zeros(0)
    dynamics = InverseDynamics(model, settings)
    random = np.random.default_rng(0)
    states = _states(model, start, random)
    weights = np.abs(dynamics.at_rest(states)[0]).max(axis=0)
    if model.ideally_positioned_joints.isdisjoint(model.active_joints):
        return model, (), weights
    accelerations = random.choice((-1.0, 1.0), states.shape) * [
        _rated(model.joints[name]) / RISE_TIME for name in model.active_joints]
    moving = dynamics.torques(states, np.zeros_like(states), accelerations)[0]
    joints, lines = dict(model.joints), []
    for name, weight, most in zip(
            model.active_joints, weights, np.abs(moving).max(axis=0), strict=True):
        joint, declared = joints[name], joints[name].limits.effort
        load, limit = weight + joint.friction, bound_or_infinite(declared)
        if name not in model.ideally_positioned_joints:
            continue
        if limit < LEAST_SHARE * load:
            does, bears = ('move', 'weight and friction need') if joint.friction else (
                'hold', 'weight needs')
        elif limit < LEAST_MOTION_SHARE * most:
            does, bears, load = 'move', 'weight and acceleration need', most
        else:
            continue
        needed = HEADROOM * (most + joint.friction)
        joints[name] = replace(joint, limits=replace(joint.limits, effort=float(needed)))
        lines.append(
            f"joint '{name}': the URDF's effort limit {declared:g} cannot {does} the robot, whose "
            f'{bears} {load:.3g}; its drive gets {needed:.3g}, as its hardware does not read the '
            'limit')
    return replace(model, joints=joints), tuple(lines), weights


def _rated(joint: Joint) -> float:
    velocity = bound_or_infinite(joint.limits.velocity)
    return min(velocity, USUAL_VELOCITY) if np.isfinite(velocity) else USUAL_VELOCITY


def _states(model: RobotModel, start: Mapping[str, float], random: np.random.Generator) -> Matrix:
    """Return states (k, n) of the active joints: the start, named ones, and some in between."""
    named: Iterable[Mapping[str, float]] = (
        values for states in model.semantic.named_states.values() for values in states.values())
    rows = [_row(model, start), *(_row(model, {**start, **values}) for values in named)]
    lower, upper = np.array([_range(model.joints[name]) for name in model.active_joints]).T
    spread = random.uniform(lower, upper, (STATES, len(lower)))
    return np.vstack([*rows, spread])


def _row(model: RobotModel, positions: Mapping[str, float]) -> Vector:
    full = model.complete(dict(positions))
    return np.array([full[name] for name in model.active_joints])


def _range(joint: Joint) -> tuple[float, float]:
    """Return where a joint may be; if it has no limits, a full turn."""
    lower, upper = joint.limits.lower, joint.limits.upper
    endless = not (np.isfinite(lower) and np.isfinite(upper))
    return (-np.pi, np.pi) if endless else (lower, upper)
