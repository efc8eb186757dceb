# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names of array types, and places in arrays; the shape is documented at its use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""Numbers in a row, such as joint positions (n,)."""

Matrix = NDArray[np.float64]
"""Rows of numbers, such as a path (k, n) or a pose (4, 4)."""

Mask = NDArray[np.bool_]
"""Which of several are meant."""


def selector(places: Sequence[int]) -> Any:
    """Return a slice where the places follow each other, else an index array."""
    if places and list(places) == list(range(places[0], places[0] + len(places))):
        return slice(places[0], places[0] + len(places))
    return np.array(places, dtype=np.intp)
