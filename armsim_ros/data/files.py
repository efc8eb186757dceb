# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files that are whole at any moment: written beside, then renamed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import json
import os
from pathlib import Path
from typing import Any

from armsim_ros.errors import ResourceError

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
