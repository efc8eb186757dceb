# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Statistics of columns, of an episode and of all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {'q01': 0.01, 'q10': 0.10, 'q50': 0.50, 'q90': 0.90, 'q99': 0.99}
#: Of a column: statistic -> its values.
Stats = dict[str, NDArray[Any]]
#: So many pictures of an episode are measured at most.
_MOST_PICTURES = 100


def stats_of(values: NDArray[Any]) -> Stats:
    """Return the statistics of a column (t, n) or (t,)."""
    rows = values.reshape(len(values), -1).astype(np.float64)
    found = {'min': rows.min(axis=0), 'max': rows.max(axis=0), 'mean': rows.mean(axis=0),
             'std': rows.std(axis=0), 'count': np.array([len(rows)])}
    quantiles = np.quantile(rows, list(QUANTILES.values()), axis=0)
    return {**found, **dict(zip(QUANTILES, quantiles, strict=True))}


def picture_stats(pictures: Sequence[NDArray[np.uint8]]) -> Stats:
    """
    Return the statistics of the channels of pictures (h, w, 3), each (3, 1, 1) in 0..1.

    :param pictures: of an episode; at most a hundred of them, evenly spread, are measured.
    """
    count = min(len(pictures), _MOST_PICTURES)
    chosen = np.round(np.linspace(0, len(pictures) - 1, count)).astype(int)
    pixels = np.stack([pictures[i] for i in chosen]).reshape(-1, 3)
    counts = np.stack([np.bincount(pixels[:, channel], minlength=256) for channel in range(3)])
    levels, total = np.arange(256) / 255.0, counts.sum(axis=1)
    mean = counts @ levels / total
    variance = np.maximum(0.0, counts @ levels**2 / total - mean**2)
    found = {'min': levels[(counts > 0).argmax(axis=1)],
             'max': levels[255 - (counts[:, ::-1] > 0).argmax(axis=1)],
             'mean': mean, 'std': np.sqrt(variance)}
    for name, share in QUANTILES.items():
        reached = counts.cumsum(axis=1) >= share * total[:, None]
        found[name] = levels[reached.argmax(axis=1)]
    return {**{name: values.reshape(3, 1, 1) for name, values in found.items()},
            'count': np.array([count])}


def together(first: Stats, second: Stats) -> Stats:
    """
    Return the statistics of two parts of a column as one.

    The quantiles are means weighted by the number of values, as LeRobot's.
    """
    total = first['count'] + second['count']
    parts = [(part, float(part['count'][0]) / float(total[0])) for part in (first, second)]

    def mean(name: str) -> NDArray[Any]:
        return np.asarray(sum(share * part[name] for part, share in parts))

    middle = mean('mean')
    variance = sum(share * _squares(part, middle) for part, share in parts)
    return {
        'min': np.minimum(first['min'], second['min']),
        'max': np.maximum(first['max'], second['max']),
        'mean': middle, 'std': np.sqrt(variance), 'count': total,
        **{name: mean(name) for name in QUANTILES}}


def _squares(part: Stats, middle: NDArray[Any]) -> NDArray[Any]:
    squares: NDArray[Any] = part['std']**2 + (part['mean'] - middle)**2
    return squares
