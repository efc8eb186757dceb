# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a controller has to know of its joints besides their states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.model.robot_model import JointType, RobotModel


@dataclass(frozen=True, slots=True, eq=False)
class JointProperties:
    """
    Types and limits of n joints; infinite limits where nothing is known.

    :param names: (n,).
    :param continuous: indices of the joints that turn without end.
    :param lower: (n,) [rad or m].
    :param upper: (n,) [rad or m].
    :param velocity: (n,) [rad/s or m/s]; a URDF's 0 is no limit.
    :param units: (n,) ``rad`` or ``m``, '' where nothing is known.
    """

    names: tuple[str, ...]
    continuous: NDArray[np.intp]
    lower: Vector
    upper: Vector
    velocity: Vector
    units: tuple[str, ...]

    @classmethod
    def of(cls, names: Sequence[str], model: RobotModel | None) -> JointProperties:
        """Look the joints up; without a model, or for a joint that it lacks, nothing is known."""
        known = model.joints if model is not None else {}
        joints = [known.get(name) for name in names]
        turning = [
            i for i, j in enumerate(joints) if j is not None and j.type is JointType.CONTINUOUS
        ]
        lower, upper, velocity = (np.full(len(names), s * np.inf) for s in (-1.0, 1.0, 1.0))
        units = []
        for i, joint in enumerate(joints):
            if joint is None:
                units.append('')
                continue
            velocity[i] = joint.limits.velocity or np.inf
            units.append('m' if joint.type is JointType.PRISMATIC else 'rad')
            if i not in turning:
                lower[i], upper[i] = joint.limits.lower, joint.limits.upper
        return cls(
            tuple(names), np.array(turning, dtype=np.intp), lower, upper, velocity, tuple(units)
        )
