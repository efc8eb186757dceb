# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Values of messages that name what they are for, in any order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import nearest


class NamedValues:
    """
    Brings values and their derivatives into a fixed order.

    :param names: (n,) in that order.
    :param rows: 1 for values alone, 2 for their derivatives too.
    """

    def __init__(self, names: Sequence[str], rows: int) -> None:
        self._names = tuple(names)
        self._rows = rows

    def sorted(
        self, names: Sequence[str], values: Sequence[float], derivatives: Sequence[float]
    ) -> Vector | str:
        """
        Return values and derivatives (rows * n,), NaN for those that are not given.

        :param names: those that are given; empty is all.
        :returns: in words what is wrong, where something is.
        """
        given = tuple(names) or self._names
        expected = f'; expected a value for each of {", ".join(self._names)}'
        if len(given) != len(set(given)):
            return f'a name comes twice among {", ".join(given)}'
        for name in given:
            if name not in self._names:
                hint = nearest(name, self._names)
                return f"'{name}' is not controlled{'; ' if hint else expected}{hint}"
        if len(values) != len(given):
            return f'{len(values)} values for {len(given)} names{expected}'
        if len(derivatives) and self._rows < 2:
            return 'derivatives are given, but none are controlled'
        if len(derivatives) not in (0, len(given)):
            return f'{len(derivatives)} derivatives for {len(given)} names'
        found = np.full((self._rows, len(self._names)), np.nan)
        places = [self._names.index(name) for name in given]
        found[0, places] = values
        if len(derivatives):
            found[1, places] = derivatives
        if np.isinf(found).any() or not np.isfinite(found).any():
            return f'values {list(values)} {list(derivatives)}'.rstrip(' []') + expected
        return np.asarray(found.ravel())
