# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shorter paths: shortcuts between points of a path, waypoints left out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ompl import geometric as og

from armsim_ros.planning.ompl_space import JointSpace

Vector = NDArray[np.float64]

ROUNDS = 5
"""Largest number of passes over a path."""


def shorten(
    space: JointSpace, path: Any, stop: Callable[[], bool], rounds: int = ROUNDS
) -> None:
    """
    Shorten an OMPL path in place; it stays free by the space's own checks.

    Partial shortcuts (Geraerts and Overmars 2007, DOI 10.1177/0278364907079280) and the
    removal of waypoints take turns until nothing changes.

    :param path: ``ompl.geometric.PathGeometric``.
    :param stop: asked before every pass.
    """
    simplifier = og.PathSimplifier(space.information)
    for _ in range(rounds):
        if stop() or path.getStateCount() < 3:
            return
        changed = simplifier.partialShortcutPath(path)
        changed = simplifier.reduceVertices(path) or changed
        if not changed:
            return


def path_length(waypoints: Vector) -> float:
    """Return the length of a polyline (k, m) in joint space [rad or m]."""
    return float(np.sum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1)))
