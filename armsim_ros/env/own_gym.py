# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an environment needs of Gymnasium, where it is not installed: two spaces and a base."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from armsim_ros.arrays import Vector


class Box:
    """
    Vectors within bounds.

    :param low: (n,) smallest values.
    :param high: (n,) largest values.
    """

    def __init__(self, low: Vector, high: Vector, dtype: Any = np.float64) -> None:
        self.low, self.high, self.dtype = low.astype(dtype), high.astype(dtype), np.dtype(dtype)
        self.shape = self.low.shape
        self._random = np.random.default_rng()

    def seed(self, seed: int | None = None) -> None:
        """Have ``sample`` begin anew."""
        self._random = np.random.default_rng(seed)

    def sample(self) -> Vector:
        """Return a vector (n,), even between the bounds; normal where there are none."""
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        even = self._random.uniform(np.where(bounded, self.low, 0.0),
                                    np.where(bounded, self.high, 0.0))
        chosen = np.where(bounded, even, self._random.normal(size=self.shape))
        values: Vector = np.clip(chosen, self.low, self.high).astype(self.dtype)
        return values

    def contains(self, x: Any) -> bool:
        """Return whether x is such a vector."""
        return (isinstance(x, np.ndarray) and x.shape == self.shape
                and bool(np.all(x >= self.low) and np.all(x <= self.high)))

    __contains__ = contains


class Dict:
    """
    Named vectors.

    :param spaces: name -> its space.
    """

    def __init__(self, spaces: Mapping[str, Box]) -> None:
        self.spaces = dict(sorted(spaces.items()))

    def __getitem__(self, name: str) -> Box:
        """Return the space of a name."""
        return self.spaces[name]

    def seed(self, seed: int | None = None) -> None:
        """Have ``sample`` begin anew."""
        for place, space in enumerate(self.spaces.values()):
            space.seed(None if seed is None else seed + place)

    def sample(self) -> dict[str, Vector]:
        """Return a vector for each name."""
        return {name: space.sample() for name, space in self.spaces.items()}

    def contains(self, x: Any) -> bool:
        """Return whether x has such a vector for each name, and no others."""
        return isinstance(x, dict) and x.keys() == self.spaces.keys() and all(
            space.contains(x[name]) for name, space in self.spaces.items())

    __contains__ = contains


class Env:
    """An environment: its random numbers."""

    metadata: ClassVar[dict[str, Any]] = {'render_modes': []}
    _np_random: np.random.Generator | None = None

    @property
    def np_random(self) -> np.random.Generator:
        """The environment's random numbers; without a seed, others each time."""
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        self._np_random = value

    @property
    def unwrapped(self) -> Env:
        """The environment itself."""
        return self

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Begin the random numbers anew where there is a seed."""
        if seed is not None:
            self._np_random = np.random.default_rng(seed)

    def close(self) -> None:
        """Give back what the environment holds."""
