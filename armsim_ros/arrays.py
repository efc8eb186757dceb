# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names of array types; what shape an array has is said where it is used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""Numbers in a row, such as joint positions (n,)."""

Matrix = NDArray[np.float64]
"""Rows of numbers, such as a path (k, n) or a pose (4, 4)."""

Mask = NDArray[np.bool_]
"""Which of several are meant."""
