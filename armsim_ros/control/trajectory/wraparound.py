# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Angles of joints that turn without end."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector

TURN = 2.0 * math.pi
ROUNDING = 1e-12


def whole_turns(displacement: Vector) -> Vector:
    """
    Return the whole turns in a displacement [rad], such that at most half a turn remains.

    Exactly half a turn keeps its sign.
    """
    turns = np.ceil(np.abs(displacement) / TURN - 0.5 - ROUNDING)
    return np.asarray(np.copysign(turns * TURN, displacement))


def shortest(displacement: Vector) -> Vector:
    """Return displacements [rad] without their whole turns."""
    return displacement - whole_turns(displacement)


def wrap_in_place(errors: Vector, continuous: NDArray[np.intp]) -> None:
    """
    Take the whole turns out of the errors of the continuous joints.

    :param errors: (n,) [rad], changed in place.
    :param continuous: indices of the continuous joints.
    """
    part = errors[continuous]
    errors[continuous] = part - np.rint(part / TURN) * TURN
