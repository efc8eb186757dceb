# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What differs from episode to episode: ranges by name, and what is drawn from them.

A name is a dotted path such as ``objects.cube.mass``. Each name has a stream of random numbers of
its own, so that another range does not change what it draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
import hashlib
import math
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import ConfigError, nearest, Problem

Value = float | tuple[float, ...]
Values = Mapping[str, Value]


@dataclass(frozen=True)
class Quantity:
    """
    The values that a name can have.

    :param width: 1 for a number, 3 for a vector.
    :param low: least value.
    :param high: greatest value.
    :param above: whether ``low`` itself is too small.
    :param whole: whether only whole numbers are values.
    """

    width: int = 1
    low: float = -math.inf
    high: float = math.inf
    above: bool = False
    whole: bool = False


@dataclass(frozen=True)
class Range:
    """A range of a name; a fixed value where ``low`` equals ``high``."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    quantity: Quantity

    def draw(self, random: np.random.Generator) -> Value:
        """Return a value."""
        if self.quantity.whole:
            return float(random.integers(int(self.low[0]), int(self.high[0]), endpoint=True))
        if self.low == self.high:
            drawn: Sequence[float] = self.low
        else:
            drawn = random.uniform(self.low, self.high).tolist()
        return drawn[0] if self.quantity.width == 1 else tuple(drawn)


Ranges = dict[str, Range]


@dataclass(frozen=True)
class Episode:
    """
    What was drawn for an episode.

    :param values: dotted path -> value.
    :param seed: of the planner's random numbers and of the noise.
    """

    values: Values
    seed: int

    def under(self, prefix: str) -> Iterator[tuple[str, str, Value]]:
        """Yield (name, quantity, value) of the paths ``prefix.name.quantity``."""
        for path, value in self.values.items():
            if path.startswith(f'{prefix}.'):
                name, _, quantity = path[len(prefix) + 1:].rpartition('.')
                yield name, quantity, value

    def get(self, path: str, default: float) -> float:
        """Return a number, or the default where none was drawn."""
        return number(self.values.get(path, default))


def number(value: Value) -> float:
    """Return a value of width 1."""
    assert not isinstance(value, tuple)
    return float(value)


def flat(given: Mapping[str, Any], prefix: str = '') -> dict[str, Any]:
    """Return nested mappings as dotted path -> what is there; dotted paths stay as they are."""
    found: dict[str, Any] = {}
    for name, value in given.items():
        path = f'{prefix}.{name}' if prefix else str(name)
        if isinstance(value, Mapping):
            found.update(flat(value, path))
        else:
            found[path] = value
    return found or ({prefix: {}} if prefix else {})


def ranges_from(given: Mapping[str, Any], known: Mapping[str, Quantity], title: str) -> Ranges:
    """
    Return checked ranges.

    :param given: nested, or dotted path -> value or (low, high).
    :param known: all names that there are.
    :param title: what is read, for messages.
    :raises ConfigError: each unknown name, and each value that is not possible.
    """
    problems: list[Problem] = []
    ranges: Ranges = {}
    for path, value in flat(given).items():
        if value == {} and any(name.startswith(f'{path}.') for name in known):
            continue
        if path not in known:
            problems.append(Problem(f"{title}: there is no '{path}'", allowed=_allowed(known),
                                    remedy=nearest(path, tuple(known))))
            continue
        quantity = known[path]
        complaint = ''
        try:
            low, high = _both_ends(np.asarray(value, dtype=np.float64), quantity.width)
            complaint = _complaint(low, high, quantity)
        except (TypeError, ValueError):
            count = 'a number' if quantity.width == 1 else f'{quantity.width} numbers'
            complaint = f'must be {count}, or (low, high) of these'
        if complaint:
            problems.append(Problem(f'{title}: {path}={value!r} {complaint}'))
        else:
            ranges[path] = Range(tuple(low.tolist()), tuple(high.tolist()), quantity)
    if problems:
        raise ConfigError(problems)
    return ranges


def drawn(ranges: Ranges, random: np.random.Generator) -> Episode:
    """
    Return an episode.

    :param ranges: of ``ranges_from``.
    :param random: gives one number, from which the streams of all names begin.
    """
    key = int(random.integers(2**63))
    values = {path: ranges[path].draw(stream(key, path)) for path in sorted(ranges)}
    return Episode(values, key)


def stream(key: int, name: str) -> np.random.Generator:
    """Return the random numbers of a name in an episode."""
    digest = hashlib.sha256(name.encode()).digest()
    words = np.frombuffer(digest[:16], dtype='<u4').tolist()
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([key, *words])))


def _both_ends(value: Vector, width: int) -> tuple[Vector, Vector]:
    if value.shape == (() if width == 1 else (width,)):
        return np.atleast_1d(value), np.atleast_1d(value)
    if value.shape == ((2,) if width == 1 else (2, width)):
        low, high = value.reshape(2, -1)
        return low, high
    raise ValueError(value.shape)


def _complaint(low: Vector, high: Vector, quantity: Quantity) -> str:
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return 'is not finite'
    if (low > high).any():
        return 'has a low above its high'
    if (low < quantity.low).any() or (quantity.above and (low == quantity.low).any()):
        return f'must be {"above" if quantity.above else "at least"} {quantity.low:g}'
    if (high > quantity.high).any():
        return f'must be at most {quantity.high:g}'
    if quantity.whole and not all(float(v).is_integer() for v in (*low, *high)):
        return 'must be whole numbers'
    return ''


def _allowed(known: Iterable[str]) -> str:
    """Return the names, those of an object or a joint together."""
    groups: dict[str, list[str]] = {}
    for path in known:
        head, _, last = path.rpartition('.')
        groups.setdefault(head, []).append(last)
    parts = [', '.join(names) if not head else f'{head}.{{{", ".join(names)}}}'
             for head, names in groups.items()]
    return ', '.join(parts[:12]) + (', ...' if len(parts) > 12 else '') or 'none'
