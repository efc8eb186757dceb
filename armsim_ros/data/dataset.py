# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A data set in LeRobot's layout v3.0, whole after each episode.

The files of an episode come first, ``meta/info.json`` last. It counts the episodes, and readers
do not read rows beyond that count, so that an episode is in the set with that one rename.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.data.features import COUNTERS, Feature, Stats, stats_of, together
from armsim_ros.errors import ConfigError, Problem, ResourceError

#: A file gets no more episodes when it is larger than this [bytes]; it is written anew with each
#: episode, and readers take many small files as well as a large file.
FULL = 4 * 2**20
#: Files in a folder.
FILES_PER_CHUNK = 1000


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """
    Write a file so that a reader sees the old or the new content, never a part.

    :param write: writes to the path that it gets.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f'.{path.name}.part')
    try:
        write(beside)
        os.replace(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file at once."""
    text = json.dumps(content, indent=4, ensure_ascii=False)
    write_whole(path, lambda part: part.write_text(f'{text}\n', encoding='utf-8'))


def read_json(path: Path) -> Any:
    """
    Return the content of a JSON file.

    :raises ResourceError: it is not there, or not JSON.
    """
    try:
        return json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise ResourceError(f"'{path}' cannot be read: {error}") from None


def chunk_and_file(number: int) -> tuple[int, int]:
    """Return chunk and file of the file of that number."""
    return divmod(number, FILES_PER_CHUNK)


class GrowingTable:
    """
    A table in Parquet files, which grows by a part at a time; each part is a row group.

    :param pattern: path with ``chunk_index`` and ``file_index``.
    :param key: column that orders the rows; rows from a value on can be dropped.
    """

    def __init__(self, folder: Path, pattern: str, key: str) -> None:
        self._folder, self._pattern, self._key = folder, pattern, key
        self._parts: list[Any] = []
        self._number = -1

    def open(self, end: int) -> list[Any]:
        """
        Go on with what is there.

        :param end: rows whose key is this or more are dropped.
        :returns: the tables of all files.
        """
        from pyarrow import compute, parquet

        tables: list[Any] = []
        for path in sorted(self._folder.glob(f'{self._pattern.split("/chunk-")[0]}/*/*.parquet')):
            table = parquet.read_table(path, partitioning=None)
            kept = table.filter(compute.less(table[self._key], end))
            if not len(kept):
                path.unlink()
                continue
            if len(kept) < len(table):
                write_whole(path, partial(parquet.write_table, kept))
            tables.append(kept)
        self._number = len(tables) - 1
        if tables:
            last, values = tables[-1], tables[-1][self._key]
            self._parts = [last.filter(compute.equal(values, key)) for key in values.unique()]
        return tables

    def place(self) -> tuple[int, int]:
        """Return chunk and file that get the next part; a full file is left."""
        if self._number < 0 or self._path().stat().st_size > FULL:
            self._number += 1
            self._parts = []
        return chunk_and_file(self._number)

    def add(self, part: Any) -> None:
        """Add a part to the file of ``place``."""
        from pyarrow import parquet

        def write(path: Path) -> None:
            with parquet.ParquetWriter(path, part.schema) as writer:
                for table in (*self._parts, part):
                    writer.write_table(table)

        write_whole(self._path(), write)
        self._parts.append(part)

    def _path(self) -> Path:
        chunk, file = chunk_and_file(self._number)
        return self._folder / self._pattern.format(chunk_index=chunk, file_index=file)


VERSION = 'v3.0'
DATA = 'data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet'
VIDEO = 'videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4'
EPISODES = 'meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet'
INFO, STATS, TASKS, OWN = ('meta/info.json', 'meta/stats.json', 'meta/tasks.parquet',
                           'meta/armsim.json')


@dataclass(frozen=True, eq=False)
class EpisodeData:
    """
    An episode of t frames.

    :param columns: feature -> (t, ...).
    :param videos: feature -> an MP4 file with t pictures.
    :param picture_stats: feature -> statistics of its pictures.
    :param task: what is done, a sentence.
    :param facts: what ``meta/armsim.json`` keeps of it.
    """

    columns: Mapping[str, NDArray[Any]]
    videos: Mapping[str, bytes]
    picture_stats: Mapping[str, Stats]
    task: str
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def length(self) -> int:
        """Number of frames."""
        return len(next(iter(self.columns.values())))


class DataSet:
    """
    Writes episodes; goes on with a set that is there.

    :param folder: is created, or holds a set with the same features.
    :param features: columns and videos, without the counters.
    :param fps: frames per second.
    :param robot_type: the robot's name.
    :param facts: how the episodes came about; a set that is there must have the same.
    :raises ConfigError: the folder has other files, or another set; all differences are named.
    """

    def __init__(
        self, folder: Path, features: Mapping[str, Feature], fps: int, robot_type: str,
        facts: Mapping[str, Any],
    ) -> None:
        self.folder, self._features = folder, dict(features)
        self._facts: dict[str, Any] = {**facts, 'episodes': []}
        self._info: dict[str, Any] = {
            'codebase_version': VERSION, 'fps': fps,
            'features': {name: feature.as_info(fps)
                         for name, feature in {**features, **COUNTERS}.items()},
            'total_episodes': 0, 'total_frames': 0, 'total_tasks': 0,
            'chunks_size': FILES_PER_CHUNK, 'data_files_size_in_mb': 100,
            'video_files_size_in_mb': 200, 'data_path': DATA,
            'video_path': VIDEO if any(f.is_video for f in features.values()) else None,
            'robot_type': robot_type, 'splits': {}}
        self._tasks: list[str] = []
        self._stats: dict[str, Stats] = {}
        self._data = GrowingTable(folder, DATA, 'episode_index')
        self._episodes = GrowingTable(folder, EPISODES, 'episode_index')
        self.dropped = ''
        """What was found of an episode that was not finished, '' for nothing."""
        if (folder / INFO).exists():
            self._go_on()
        elif folder.exists() and any(folder.iterdir()) and not _only_parts(folder):
            raise ConfigError(Problem(
                f"'{folder}' is not empty and is not a data set", remedy='name a new folder'))

    @property
    def episodes(self) -> int:
        """Number of finished episodes."""
        return int(self._info['total_episodes'])

    @property
    def frames(self) -> int:
        """Number of their frames."""
        return int(self._info['total_frames'])

    @property
    def facts(self) -> list[dict[str, Any]]:
        """What ``meta/armsim.json`` keeps of each episode."""
        return list(self._facts['episodes'])

    def add(self, episode: EpisodeData) -> None:
        """Write an episode; after that it is in the set whatever happens."""
        import pyarrow as pa

        number, length, fps = self.episodes, episode.length, self._info['fps']
        if episode.task not in self._tasks:
            self._tasks.append(episode.task)
            self._write_tasks()
        frames = np.arange(length)
        columns = {
            **episode.columns, 'timestamp': (frames / fps).astype(np.float32),
            'frame_index': frames, 'episode_index': np.full(length, number),
            'index': frames + self.frames,
            'task_index': np.full(length, self._tasks.index(episode.task)),
        }
        row: dict[str, Any] = {
            'episode_index': number, 'tasks': [episode.task], 'length': length,
            'dataset_from_index': self.frames, 'dataset_to_index': self.frames + length}
        for key, content in episode.videos.items():
            row.update(self._write_video(key, number, content, length / fps))
        row['data/chunk_index'], row['data/file_index'] = self._data.place()
        self._data.add(pa.table({
            name: _array(columns[name], feature)
            for name, feature in {**self._features, **COUNTERS}.items() if not feature.is_video}))
        row['meta/episodes/chunk_index'], row['meta/episodes/file_index'] = self._episodes.place()
        stats = {**{name: stats_of(values) for name, values in columns.items()},
                 **episode.picture_stats}
        row |= {f'stats/{name}/{statistic}': values.tolist()
                for name, found in stats.items() for statistic, values in found.items()}
        self._episodes.add(pa.table({name: [value] for name, value in row.items()}))
        self._stats = _merged(self._stats, stats)
        self._facts['episodes'].append(dict(episode.facts))
        self._info |= {
            'total_episodes': number + 1, 'total_frames': self.frames + length,
            'total_tasks': len(self._tasks), 'splits': {'train': f'0:{number + 1}'}}
        self._write_meta()

    def _write_video(self, key: str, number: int, content: bytes, end: float) -> dict[str, Any]:
        chunk, file = chunk_and_file(number)
        path = self.folder / VIDEO.format(video_key=key, chunk_index=chunk, file_index=file)
        write_whole(path, lambda part: part.write_bytes(content))
        return {f'videos/{key}/chunk_index': chunk, f'videos/{key}/file_index': file,
                f'videos/{key}/from_timestamp': 0.0, f'videos/{key}/to_timestamp': end}

    def _write_tasks(self) -> None:
        import pyarrow as pa
        from pyarrow import parquet

        count = len(self._tasks)
        table = pa.table({'task_index': pa.array(range(count), pa.int64()),
                          'task': pa.array(self._tasks, pa.string())})
        table = table.replace_schema_metadata({'pandas': _index_of_tasks()})
        write_whole(self.folder / TASKS, lambda part: parquet.write_table(table, part))

    def _write_meta(self) -> None:
        write_json(self.folder / STATS, {
            name: {statistic: values.tolist() for statistic, values in found.items()}
            for name, found in self._stats.items()})
        write_json(self.folder / OWN, self._facts)
        write_json(self.folder / INFO, self._info)

    def _go_on(self) -> None:
        """Take up a set that is there; what is not counted in it is dropped."""
        info, facts = read_json(self.folder / INFO), read_json(self.folder / OWN)
        differences = _differences(self._info, info, ('fps', 'robot_type', 'features'))
        differences += _differences(
            self._facts, facts, [name for name in self._facts if name != 'episodes'])
        if differences:
            raise ConfigError([
                Problem(f"the set in '{self.folder}' has {difference}",
                        remedy='repeat the arguments that it was made with, or name a new folder')
                for difference in differences])
        self._info, count = info, int(info['total_episodes'])
        self._facts['episodes'] = facts['episodes'][:count]
        rows_before = self._data.open(count)
        tables = self._episodes.open(count)
        left = [path for path in self.folder.glob('videos/*/*/*.mp4')
                if _number(path) >= count] + [*self.folder.rglob('.*.part')]
        if left or len(facts['episodes']) > count:
            self.dropped = f'episode {count}, which was not finished'
        for path in left:
            path.unlink()
        assert sum(map(len, rows_before)) == info['total_frames'], 'rows and info.json differ'
        for table in tables:
            for row in table.to_pylist():
                self._stats = _merged(self._stats, _stats_in(row))
                self._tasks += [task for task in row['tasks'] if task not in self._tasks]


def _array(values: NDArray[Any], feature: Feature) -> Any:
    import pyarrow as pa

    kind = pa.type_for_alias(feature.dtype)
    flat = pa.array(np.ascontiguousarray(values).reshape(-1), kind)
    if feature.shape == (1,):
        return flat
    return pa.FixedSizeListArray.from_arrays(flat, int(np.prod(feature.shape)))


def _merged(first: dict[str, Stats], second: Mapping[str, Stats]) -> dict[str, Stats]:
    return {name: together(first[name], stats) if name in first else stats
            for name, stats in second.items()}


def _stats_in(row: Mapping[str, Any]) -> dict[str, Stats]:
    found: dict[str, Stats] = {}
    for path, values in row.items():
        if path.startswith('stats/'):
            name, _, statistic = path[len('stats/'):].rpartition('/')
            found.setdefault(name, {})[statistic] = np.array(values)
    return found


def _differences(ours: Any, theirs: Any, names: Any) -> list[str]:
    """Return 'name x, not y' for what two descriptions have in different."""
    found = []
    for name in names:
        mine, other = ours.get(name), theirs.get(name)
        if mine == other:
            continue
        if isinstance(mine, Mapping) and isinstance(other, Mapping):
            inner = dict.fromkeys((*mine, *other))
            found += [f'{name}.{text}' for text in _differences(mine, other, inner)]
        else:
            found.append(f'{name} {other!r}, not {mine!r}')
    return found


def _number(video: Path) -> int:
    chunk, file = video.parent.name.removeprefix('chunk-'), video.stem.removeprefix('file-')
    return int(chunk) * FILES_PER_CHUNK + int(file)


def _only_parts(folder: Path) -> bool:
    """Return whether there is nothing but what an interrupted first episode has left."""
    own = {'data', 'meta', 'videos'}
    return {path.name for path in folder.iterdir()} <= own


def _index_of_tasks() -> str:
    """Return what pandas keeps in a Parquet file, to make the tasks the index of its rows."""
    import json

    def column(name: str, kind: str, stored: str) -> dict[str, Any]:
        return {'name': name, 'field_name': name, 'pandas_type': kind, 'numpy_type': stored,
                'metadata': None}

    names = {'name': None, 'field_name': None, 'pandas_type': 'unicode', 'numpy_type': 'object',
             'metadata': {'encoding': 'UTF-8'}}
    return json.dumps({
        'index_columns': ['task'], 'column_indexes': [names],
        'columns': [column('task_index', 'int64', 'int64'), column('task', 'unicode', 'object')],
        'attributes': {}, 'creator': {'library': 'pyarrow', 'version': '15'},
        'pandas_version': '2.2.0'})
