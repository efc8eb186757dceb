# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Turns recordings into a data set: the latest values at the times of the frames."""

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

from armsim_ros.data.dataset import DataSet, EpisodeData
from armsim_ros.data.features import checked_size, Feature, picture_stats
from armsim_ros.data.features import IMAGES as IMAGE_FEATURES
from armsim_ros.data.topic_map import (
    IMAGES,
    names_of,
    numbers_of,
    picture_of,
    Source,
    stamp_of,
    TopicMap,
)
from armsim_ros.data.video import encoded
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


#: A topic that is silent for more frames has a gap.
_GAP_FRAMES = 3
#: Pictures of an episode that are measured.
_MEASURED = 100


def convert(
    paths: Sequence[Path], folder: Path, mapping: TopicMap, *, allow_gaps: bool = False
) -> DataSet:
    """
    Write the episodes of recordings as a data set.

    :param paths: MCAP files, in the order of their episodes.
    :param folder: of the set; a set of the same map and recordings is completed.
    :param allow_gaps: whether topics may be silent for more than three frames.
    :raises ConfigError: topics that are missing, or features that are not possible.
    :raises ArmsimError: stamps that run back, or gaps; topic and times are named.
    """
    recordings = [Recording(path) for path in paths]
    for recording in recordings:
        recording.check(mapping.topics)
    kinds = recordings[0].kinds
    features = {name: _feature(name, sources, recordings[0])
                for name, sources in mapping.features.items()}
    facts = {'recordings': [path.name for path in paths], 'map': mapping.model_dump(mode='json')}
    data = DataSet(folder, features, mapping.fps, mapping.robot_type, facts)
    number = 0
    for recording in recordings:
        if {topic: recording.kinds[topic] for topic in mapping.topics} != {
                topic: kinds[topic] for topic in mapping.topics}:
            raise ConfigError(Problem(f"'{recording.path}' has other types of messages than "
                                      f"'{paths[0]}'"))
        stamps = recording.stamps(mapping.topics)
        for span in recording.spans(mapping, stamps):
            number += 1
            if number > data.episodes:
                data.add(_episode(recording, span, mapping, stamps, allow_gaps))
    return data


def _feature(name: str, sources: Sequence[Source], recording: Recording) -> Feature:
    kinds = [recording.kinds[source.topic] for source in sources]
    _, _, _, first = next(recording.messages([sources[0].topic]), (None,) * 4)
    if first is None:
        raise ConfigError(Problem(f"'{recording.path}' has no message of '{sources[0].topic}'"))
    if kinds[0] in IMAGES:
        if len(sources) > 1 or not name.startswith(IMAGE_FEATURES):
            raise ConfigError(Problem(
                f"'{name}' is a picture of '{sources[0].topic}'",
                allowed=f'a name that begins with {IMAGE_FEATURES}, and one topic'))
        return Feature('video', checked_size(picture_of(first, kinds[0], sources[0].topic).shape))
    names: list[str] = []
    for source, kind in zip(sources, kinds, strict=True):
        _, _, _, message = next(recording.messages([source.topic]))
        names += names_of(kind, source, len(numbers_of(message, kind, source)))
    return Feature('float32', (len(names),), tuple(names))


def _episode(
    recording: Recording, span: Span, mapping: TopicMap, stamps: dict[str, NDArray[np.int64]],
    allow_gaps: bool,
) -> EpisodeData:
    period = 1e9 / mapping.fps
    begin = span.begin
    for topic in mapping.topics:
        if not len(stamps[topic]) or stamps[topic][0] > span.end:
            raise ArmsimError(f"'{recording.path}': no message of '{topic}' before "
                              f'{span.end * 1e-9:.6f} s, the end of an episode')
        begin = max(begin, int(stamps[topic][0]))
    count = int((span.end - begin) / period) + 1
    times = begin + np.round(np.arange(count) * period).astype(np.int64)
    places = {topic: np.searchsorted(stamps[topic], times, side='right') - 1
              for topic in mapping.topics}
    silent = {source.topic for sources in mapping.features.values() for source in sources
              if source.gaps}
    if not allow_gaps:
        for topic in mapping.topics:
            age = times - stamps[topic][places[topic]]
            if topic not in silent and (age > _GAP_FRAMES * period).any():
                at = int(np.argmax(age > _GAP_FRAMES * period))
                raise ArmsimError(
                    f"'{recording.path}': '{topic}' is silent from "
                    f'{stamps[topic][places[topic][at]] * 1e-9:.6f} s to at least '
                    f'{times[at] * 1e-9:.6f} s; --allow-gaps keeps the last value')
    columns, videos, stats = {}, {}, {}
    for name, sources in mapping.features.items():
        if recording.kinds[sources[0].topic] in IMAGES:
            measured: list[NDArray[np.uint8]] = []
            videos[name] = encoded(
                _pictures(recording, sources[0].topic, places[sources[0].topic], measured),
                mapping.fps)
            stats[name] = picture_stats(measured)
        else:
            columns[name] = np.concatenate(
                [_rows(recording, source, places[source.topic]) for source in sources],
                axis=1).astype(np.float32)
    return EpisodeData(columns, videos, stats, span.task or 'episode', {
        'recording': recording.path.name, 'begin': begin * 1e-9, 'end': span.end * 1e-9})


def _chosen(recording: Recording, topic: str, places: NDArray[np.intp]) -> Iterator[Any]:
    """Yield the message of each frame."""
    frame = 0
    for number, (_, _, _, message) in enumerate(recording.messages([topic])):
        while frame < len(places) and places[frame] == number:
            yield message
            frame += 1
        if frame == len(places):
            return


def _rows(recording: Recording, source: Source, places: NDArray[np.intp]) -> NDArray[Any]:
    kind = recording.kinds[source.topic]
    return np.stack([numbers_of(message, kind, source)
                     for message in _chosen(recording, source.topic, places)])


def _pictures(
    recording: Recording, topic: str, places: NDArray[np.intp], measured: list[NDArray[np.uint8]]
) -> Iterator[NDArray[np.uint8]]:
    """Yield the picture of each frame; some of them are kept in ``measured``."""
    count = len(places)
    kept = set(np.round(np.linspace(0, count - 1, min(count, _MEASURED))).astype(int).tolist())
    for frame, message in enumerate(_chosen(recording, topic, places)):
        picture = picture_of(message, recording.kinds[topic], topic)
        if frame in kept:
            measured.append(picture)
        yield picture
