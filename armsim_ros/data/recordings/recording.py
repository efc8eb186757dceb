# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A recording: its topics, when their messages came, and where episodes begin and end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from numpy.typing import NDArray

from armsim_ros.data.recordings.messages import stamp_of
from armsim_ros.data.recordings.topic_map import TopicMap
from armsim_ros.errors import ArmsimError, ConfigError, nearest, Problem, ResourceError


@dataclass(frozen=True)
class Span:
    """
    An episode of a recording.

    :param begin: [ns].
    :param end: [ns].
    :param task: what is done.
    """

    begin: int
    end: int
    task: str


class Recording:
    """
    An MCAP file, as the recorder of this package and rosbag2 write it.

    :param path: the file.
    :raises ResourceError: it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open('rb') as stream:
                summary = make_reader(stream).get_summary()
        except (OSError, McapError) as error:
            raise ResourceError(f"'{path}' cannot be read: {error}") from None
        if summary is None:
            raise ResourceError(f"'{path}' has no index: the recording was not finished; "
                                "'mcap recover' repairs it")
        self.kinds: dict[str, str] = {}
        """Topic -> type of its messages."""
        for channel in summary.channels.values():
            if channel.topic in self.kinds:
                raise ConfigError(Problem(f"'{path}': '{channel.topic}' was recorded from two "
                                          'publishers', remedy='record each by itself'))
            schema = summary.schemas.get(channel.schema_id)
            self.kinds[channel.topic] = schema.name if schema else ''

    def check(self, topics: Sequence[str]) -> None:
        """
        Check that topics were recorded.

        :raises ConfigError: those that were not.
        """
        known = tuple(self.kinds)
        problems = [Problem(f"'{self.path}' has no topic '{topic}'", allowed=', '.join(known),
                            remedy=nearest(topic, known))
                    for topic in topics if topic not in self.kinds]
        if problems:
            raise ConfigError(problems)

    def messages(self, topics: Sequence[str]) -> Iterator[tuple[str, int, int, Any]]:
        """
        Yield topic, stamp [ns], arrival [ns] and message, in the order of arrival.

        :raises ArmsimError: a message cannot be read.
        """
        try:
            with self.path.open('rb') as stream:
                reader = make_reader(stream, decoder_factories=[DecoderFactory()])
                for _, channel, record, message in reader.iter_decoded_messages(
                        topics=list(topics)):
                    stamp = stamp_of(message, record.log_time)
                    yield channel.topic, stamp, record.log_time, message
        except McapError as error:
            raise ArmsimError(f"'{self.path}': {error}") from None

    def stamps(self, topics: Sequence[str]) -> dict[str, NDArray[np.int64]]:
        """
        Return topic -> (n,) the stamps of its messages [ns].

        :raises ArmsimError: stamps of a topic run back; both are named.
        """
        found: dict[str, list[int]] = {topic: [] for topic in topics}
        for topic, stamp, _, _ in self.messages(topics):
            times = found[topic]
            if times and stamp < times[-1]:
                raise ArmsimError(
                    f"'{self.path}': the stamps of '{topic}' run back from "
                    f'{times[-1] * 1e-9:.6f} s to {stamp * 1e-9:.6f} s')
            times.append(stamp)
        return {topic: np.array(times, dtype=np.int64) for topic, times in found.items()}

    def spans(self, mapping: TopicMap, stamps: dict[str, NDArray[np.int64]]) -> list[Span]:
        """
        Return the episodes.

        :raises ConfigError: a topic that marks episodes and is neither a Bool nor a String.
        """
        marks = mapping.episode
        last = max(int(times[-1]) for times in stamps.values() if len(times))
        if marks.topic:
            self.check([marks.topic])
            return list(self._marked(marks.topic, mapping.task, last))
        times = np.sort(np.concatenate(list(stamps.values())))
        cuts = np.flatnonzero(np.diff(times) > marks.gap * 1e9)
        begins, ends = [0, *(cuts + 1)], [*cuts, len(times) - 1]
        return [Span(int(times[a]), int(times[b]), mapping.task)
                for a, b in zip(begins, ends, strict=True)]

    def _marked(self, topic: str, task: str, last: int) -> Iterator[Span]:
        kind = self.kinds[topic]
        if kind not in ('std_msgs/msg/Bool', 'std_msgs/msg/String'):
            raise ConfigError(Problem(f"'{topic}' is a {kind} and cannot mark episodes",
                                      allowed='std_msgs/msg/Bool, std_msgs/msg/String'))
        begin, now = 0, ''
        for _, stamp, _, message in self.messages([topic]):
            value = message.data if isinstance(message.data, str) else (
                (task or 'episode') if message.data else '')
            if value == now:
                continue
            if now:
                yield Span(begin, stamp, now)
            begin, now = stamp, value
        if now:
            yield Span(begin, last, now)
