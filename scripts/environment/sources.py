# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which files make up what is installed, and the hash of their content."""

from __future__ import annotations

from collections.abc import Iterable
from configparser import ConfigParser
import hashlib
import os
from pathlib import Path
import shutil

#: What setup.py reads or installs.
PACKAGE_SOURCES = ('armsim_ros', 'config', 'urdf', 'worlds', 'launch', 'rviz', 'examples',
                   'resource', 'setup.py', 'setup.cfg', 'requirements.txt', 'package.xml',
                   'LICENSE')
#: Distributions of this source tree, which no index has to have.
OWN = ('armsim-ros-interfaces', 'armsim-ros2', 'armsim-ros-helpers', 'armsim-moveit')
#: The time stamp of all files in wheels and archives, the first that a zip file can have
#: (SOURCE_DATE_EPOCH): the same sources give the same bytes.
EPOCH = '315532800'
_SKIPPED = {'__pycache__', 'build', 'dist'}


def list_files(root: Path, names: Iterable[str]) -> list[Path]:
    """Return every file under the named files and folders, sorted, without what builds leave."""
    found: list[Path] = []
    for name in names:
        top = root / name
        if top.is_file():
            found.append(top)
        for folder, folders, files in os.walk(top, followlinks=True):
            folders[:] = sorted(entry for entry in folders if _counts(entry))
            found += [Path(folder, file) for file in sorted(files) if _counts(file)]
    return found


def content_hash(root: Path, names: Iterable[str]) -> str:
    """Return a hash of the files' paths below root, their bytes, and whether they may run."""
    digest = hashlib.sha256()
    for path in list_files(root, names):
        content = path.read_bytes()
        mode = path.stat().st_mode & 0o100
        digest.update(f'{path.relative_to(root)}\0{mode}\0{len(content)}\0'.encode())
        digest.update(content)
    return digest.hexdigest()[:32]


def copy_files(root: Path, names: Iterable[str], target: Path) -> None:
    """Copy the files, so that a build leaves nothing in the source tree and finds nothing old."""
    for path in list_files(root, names):
        place = target / path.relative_to(root)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, place)
        place.chmod(0o755 if path.stat().st_mode & 0o100 else 0o644)  # whatever the umask was


def requirements(root: Path, extra: str | None = None) -> list[str]:
    """
    Return what the package requires from the Python package index.

    :param extra: an extra of setup.cfg whose requirements are asked for instead.
    """
    if extra is None:
        text = (root / 'requirements.txt').read_text(encoding='utf-8')
    else:
        parser = ConfigParser()
        parser.read(root / 'setup.cfg', encoding='utf-8')
        text = parser['options.extras_require'][extra]
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not line.startswith(('#', *OWN))]


def _counts(name: str) -> bool:
    return name not in _SKIPPED and not name.endswith(('.pyc', '.egg-info'))
