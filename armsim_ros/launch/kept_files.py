# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Files that programs of a launch read, removed at its end."""

from __future__ import annotations

import itertools
from pathlib import Path
import shutil
import tempfile

from armsim_ros.launch.lookup import current_lookup


class KeptFiles:
    """A folder that is made when it is first needed."""

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._order = itertools.count()

    def write(self, name: str, text: str) -> str:
        """Write a text into a file of its own and return its path."""
        path = self._kept() / f'{next(self._order)}_{name}'
        path.write_text(text, encoding='utf-8')
        return str(path)

    def source_modules(self) -> str:
        """Return a folder with links to the Python modules in the sources of all packages."""
        folder = self._kept() / 'python'
        if not folder.exists():
            folder.mkdir()
            for name, place in current_lookup().modules().items():
                (folder / (place.name if place.is_file() else name)).symlink_to(place)
        return str(folder)

    def remove(self) -> None:
        """Remove the files."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _kept(self) -> Path:
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix='armsim_launch_'))
        return self._folder
