# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The columns of a data set, as in LeRobot's ``meta/info.json``, and their statistics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.data.video import VIDEO_INFO
from armsim_ros.errors import ConfigError, Problem

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


STATE, ENVIRONMENT = 'observation.state', 'observation.environment_state'
IMAGES, ACTION = 'observation.images.', 'action'
REWARD, DONE, SUCCESS = 'next.reward', 'next.done', 'next.success'


@dataclass(frozen=True)
class Feature:
    """
    A column, or a video.

    :param dtype: ``float32``, ``int64``, ``bool`` or ``video``.
    :param shape: of a frame; (height, width, 3) of a video.
    :param names: what each number is, if it has names.
    """

    dtype: str
    shape: tuple[int, ...]
    names: tuple[str, ...] | None = None

    @property
    def is_video(self) -> bool:
        """Whether it is a video."""
        return self.dtype == 'video'

    def as_info(self, fps: int) -> dict[str, Any]:
        """Return its entry in ``info.json``."""
        entry: dict[str, Any] = {'dtype': self.dtype, 'shape': list(self.shape),
                                 'names': list(self.names) if self.names else None}
        if self.is_video:
            height, width, channels = self.shape
            entry['names'] = ['height', 'width', 'channels']
            entry['info'] = {'video.height': height, 'video.width': width, **VIDEO_INFO,
                             'video.fps': fps, 'video.channels': channels,
                             'is_depth_map': False, 'has_audio': False}
        return entry


#: Columns that every data set has besides its own.
COUNTERS = {
    'timestamp': Feature('float32', (1,)), 'frame_index': Feature('int64', (1,)),
    'episode_index': Feature('int64', (1,)), 'index': Feature('int64', (1,)),
    'task_index': Feature('int64', (1,)),
}
#: What an environment answers to an action.
ANSWERS = {REWARD: Feature('float32', (1,)), DONE: Feature('bool', (1,)),
           SUCCESS: Feature('bool', (1,))}


def whole_fps(period: float) -> int:
    """
    Return the frames per second of a period.

    :param period: [s].
    :raises ConfigError: it is not a whole number.
    """
    fps = round(1.0 / period)
    if fps < 1 or abs(1.0 / period - fps) > 1e-6 * fps:
        raise ConfigError(Problem(
            f'a period of {period:g} s gives {1.0 / period:.6g} frames per second',
            allowed='a whole number of frames per second, such as a period of 0.05 or 0.02'))
    return fps


def features_of(task: Any) -> dict[str, Feature]:
    """
    Return the columns of a task's episodes.

    :raises ConfigError: pictures of a size that the codec does not take.
    """
    space, features = task.observation_space, {}
    parts: Mapping[str, Any] = getattr(space, 'spaces', {'state': space})
    if 'agent_pos' in parts:
        features[STATE] = Feature('float32', parts['agent_pos'].shape, task.state_names)
    if 'state' in parts:
        features[STATE] = Feature('float32', space.shape)
    if 'environment_state' in parts:
        features[ENVIRONMENT] = Feature(
            'float32', parts['environment_state'].shape, task.environment_state_names)
    if 'pixels' in parts:
        for camera, picture in parts['pixels'].spaces.items():
            features[f'{IMAGES}{camera}'] = Feature('video', checked_size(picture.shape))
    features[ACTION] = Feature('float32', task.action_space.shape, tuple(task.action_names))
    return {**features, **ANSWERS}


def checked_size(shape: tuple[int, ...]) -> tuple[int, ...]:
    """
    Return the shape of pictures that a video can hold.

    :raises ConfigError: an odd height or width.
    """
    if shape[0] % 2 or shape[1] % 2:
        raise ConfigError(Problem(
            f'pictures of {shape[1]} x {shape[0]} pixels', allowed='an even width and height: the '
            "video's colours have half the resolution"))
    return shape


def frames_of(observation: Any) -> dict[str, Any]:
    """Return feature -> its value in a frame, of an observation of a task."""
    if not isinstance(observation, Mapping):
        return {STATE: observation}
    found: dict[str, Any] = {}
    if 'agent_pos' in observation:
        found[STATE] = observation['agent_pos']
    if 'environment_state' in observation:
        found[ENVIRONMENT] = observation['environment_state']
    for camera, picture in observation.get('pixels', {}).items():
        found[f'{IMAGES}{camera}'] = np.asarray(picture)
    return found
