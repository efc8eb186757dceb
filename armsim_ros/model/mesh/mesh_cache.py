# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What takes long to make of a mesh is kept in the user's cache folder, by what it is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import hashlib
import io
import os
from pathlib import Path
import tempfile
from typing import Any
import zipfile

import numpy as np
from numpy.typing import NDArray

from armsim_ros.install_rules.view import cache_folder

#: Changes when what is kept changes its meaning.
_VERSION = 'v2'

Arrays = Sequence[NDArray[Any]]


def cached(data: bytes, ending: str, make: Callable[[bytes], Arrays]) -> Arrays:
    """
    Return the arrays that were made of these bytes before, else make them and keep them.

    :param ending: the kind of result; the same bytes may differ in another format.
    :raises ValueError: where ``make`` does.
    """
    digest = hashlib.sha256(data).hexdigest()
    kept = cache_folder('meshes') / f'{_VERSION}-{digest}{ending}.npz'
    found = _load(kept)
    if found is None:
        found = make(data)
        _keep(kept, found)
    return found


def _load(kept: Path) -> Arrays | None:
    try:
        with np.load(io.BytesIO(kept.read_bytes()), allow_pickle=False) as arrays:
            return [arrays[f'arr_{number}'] for number in range(len(arrays.files))]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def _keep(kept: Path, arrays: Arrays) -> None:
    """Keep arrays; where the folder cannot be written they are made anew the next time."""
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=kept.parent, suffix='.npz', delete=False) as stream:
            np.savez(stream, *arrays)
        os.replace(stream.name, kept)
    except OSError:
        return
