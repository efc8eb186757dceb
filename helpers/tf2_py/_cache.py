# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The samples of one frame: those of the last seconds, or the only one of a static frame."""

from __future__ import annotations

from bisect import bisect_right
from typing import NoReturn

from tf2_py._exceptions import ExtrapolationException
from tf2_py._rigid import interpolate, Sample

#: Pruned samples that a cache keeps before it moves the others in memory.
_SLACK = 256


class TimeCache:
    """
    The samples of a moving frame.

    :param duration: how far before the newest sample older samples are kept [ns].
    """

    def __init__(self, duration: int) -> None:
        self._duration = duration
        self._stamps: list[int] = []
        self._samples: list[Sample] = []
        # The samples before this index are pruned.
        self._first = 0

    def __len__(self) -> int:
        return len(self._stamps) - self._first

    def insert(self, sample: Sample) -> bool:
        """Add a sample unless it is too old; a sample that is there already is not doubled."""
        stamps, stamp = self._stamps, sample[0]
        if not stamps:
            stamps.append(stamp)
            self._samples.append(sample)
            return True
        oldest = stamps[-1] - self._duration
        while stamps[self._first] < oldest:
            self._first += 1
        if self._first > _SLACK and 2 * self._first > len(stamps):
            del stamps[:self._first]
            del self._samples[:self._first]
            self._first = 0
        if stamp > stamps[-1]:
            stamps.append(stamp)
            self._samples.append(sample)
            return True
        if stamp < oldest:
            return False
        place = bisect_right(stamps, stamp, self._first)
        same = place
        while same > self._first and stamps[same - 1] == stamp:
            same -= 1
            if self._samples[same] == sample:
                return True
        stamps.insert(place, stamp)
        self._samples.insert(place, sample)
        return True

    def clear(self) -> None:
        """Remove all samples."""
        self._stamps.clear()
        self._samples.clear()
        self._first = 0

    def newest(self) -> Sample | None:
        """Return the newest sample."""
        return self._samples[-1] if self._samples else None

    def newest_stamp(self) -> int:
        """Return the stamp of the newest sample [ns], 0 without samples."""
        return self._stamps[-1] if self._stamps else 0

    def oldest_stamp(self) -> int:
        """Return the stamp of the oldest sample [ns], 0 without samples."""
        return self._stamps[self._first] if self._stamps else 0

    def at(self, time: int) -> Sample:
        """
        Return the frame's pose at a time.

        :param time: [ns]; 0: the newest.
        :raises ExtrapolationException: the time is not between the oldest and the newest sample.
        """
        stamps, samples = self._stamps, self._samples
        if not stamps:
            raise ExtrapolationException('Lookup would require extrapolation at time '
                                         f'{seconds(time)}, but no data is in the buffer')
        newest = stamps[-1]
        if time in (0, newest):
            return samples[-1]
        oldest = stamps[self._first]
        if time == oldest:
            return samples[self._first]
        if time > newest or time < oldest:
            self._refuse(time)
        after = bisect_right(stamps, time, self._first)
        older, newer = samples[after - 1], samples[after]
        if older[0] == time or older[1] != newer[1]:
            return older
        return interpolate(older, newer, time)

    def _refuse(self, time: int) -> NoReturn:
        newest, oldest = self._stamps[-1], self._stamps[self._first]
        if len(self) == 1:
            raise ExtrapolationException(
                f'Lookup would require extrapolation at time {seconds(time)}, but only time '
                f'{seconds(newest)} is in the buffer')
        where, extreme, limit = ('future', 'latest', newest) if time > newest else (
            'past', 'earliest', oldest)
        raise ExtrapolationException(
            f'Lookup would require extrapolation into the {where}.  Requested time '
            f'{seconds(time)} but the {extreme} data is at time {seconds(limit)}')


class StaticCache:
    """The sample of a static frame, valid at all times."""

    def __init__(self) -> None:
        self._sample: Sample | None = None

    def __len__(self) -> int:
        return 1

    def insert(self, sample: Sample) -> bool:
        """Replace the sample."""
        self._sample = (0, *sample[1:])
        return True

    def clear(self) -> None:
        """Do nothing: static frames stay."""

    def newest(self) -> Sample | None:
        """Return the sample, whose stamp is 0."""
        return self._sample

    def newest_stamp(self) -> int:
        """Return 0: static frames have no stamp."""
        return 0

    oldest_stamp = newest_stamp

    def at(self, _: int) -> Sample:
        """Return the sample."""
        assert self._sample is not None
        return self._sample


def seconds(time: int) -> str:
    """Return a time [ns] in seconds, as tf2 prints it."""
    return f'{time * 1e-9:.6f}'
