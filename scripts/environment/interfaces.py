# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The wheel of the ROS interface packages: one of dist/, or built once and cached."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
import platform
import shutil
import subprocess
import tempfile
from zipfile import BadZipFile, ZipFile

from environment.installer import pip_failure
from environment.machine import check_compiler, clean_environment, has_package, Interpreter
from environment.sources import content_hash, copy_files, EPOCH

FOLDER = 'interfaces'
#: Where ``make dist`` puts its wheels, or the user wheels made elsewhere.
DIST = 'dist'
#: Tells the build which packages to take.
SELECTION_VARIABLE = 'ARMSIM_INTERFACES'
#: Tells the build the hash of its sources, which the wheel then keeps in this file.
HASH_VARIABLE = 'ARMSIM_INTERFACES_HASH'
_HASH_FILE = 'armsim_ros_interfaces/sources'


class InterfaceWheel:
    """
    The wheel for one state of interfaces/ and one interpreter.

    :param root: the source tree.
    :param interpreter: what the wheel is for.
    :param ros: prefix of a sourced ROS installation, whose packages are not built again.
    """

    def __init__(self, root: Path, interpreter: Interpreter, ros: Path | None) -> None:
        self._root = root
        self._interpreter = interpreter
        self._ros = ros
        ours = sorted(path.parent.name for path in (root / FOLDER).glob('*/package.xml'))
        self.selection = [name for name in ours if ros is None or not has_package(ros, name)]
        self._complete = self.selection == ours
        self._sources = content_hash(root, [FOLDER])
        identity = '\0'.join([self._sources, interpreter.tag, *self.selection])
        self.key = hashlib.sha256(identity.encode()).hexdigest()[:32]
        self._cache = cache_folder() / 'interfaces' / self.key
        self._process: subprocess.Popen[bytes] | None = None
        self._work: Path | None = None

    def is_needed(self) -> bool:
        """Return whether there is a package that the system does not bring."""
        return bool(self.selection)

    def existing(self) -> Path | None:
        """Return the finished wheel of the cache, else one of dist/ that fits, else None."""
        cached = next(self._cache.glob('*.whl'), None)
        if cached is not None or not self._complete:
            return cached
        python = 'cp' + ''.join(self._interpreter.version.split('.')[:2])
        names = f'armsim_ros_interfaces-*-{python}-{python}-*linux*_{platform.machine()}.whl'
        return next((wheel for wheel in sorted((self._root / DIST).glob(names))
                     if _sources_of(wheel) == self._sources), None)

    def start(self, python: Path, log: Path) -> None:
        """
        Begin to build, beside whatever else goes on.

        :raises SetupError: where there is no compiler.
        """
        check_compiler(self._interpreter)
        self._cache.parent.mkdir(parents=True, exist_ok=True)
        self._work = Path(tempfile.mkdtemp(prefix='building-', dir=self._cache.parent))
        copy_files(self._root, [FOLDER], self._work)
        environment = dict(clean_environment(), SOURCE_DATE_EPOCH=EPOCH, **{
            SELECTION_VARIABLE: ','.join(self.selection), HASH_VARIABLE: self._sources})
        if self._ros is None:  # the wheel requires message packages, whatever is sourced here
            environment.pop('AMENT_PREFIX_PATH', None)
        with open(log, 'wb') as stream:
            self._process = subprocess.Popen(
                [python, '-m', 'pip', 'wheel', '--no-deps', '-w', self._work / 'wheel',
                 self._work / FOLDER],
                env=environment, stdin=subprocess.DEVNULL, stdout=stream,
                stderr=subprocess.STDOUT, umask=0o022)

    def finish(self, log: Path) -> Path:
        """
        Wait for the build and return the wheel.

        :raises SetupError: where the build failed.
        """
        assert self._process is not None
        assert self._work is not None
        status = self._process.wait()
        self._process = None
        if status != 0:
            raise pip_failure('build the ROS interface packages', log.read_text(errors='replace'),
                              log)
        try:
            os.rename(self._work / 'wheel', self._cache)
        except OSError:
            # Another source tree's run was quicker; its wheel is the same.
            if self.existing() is None:
                raise
        wheel = self.existing()
        assert wheel is not None
        return wheel

    def clean_up(self) -> None:
        """End a build that nobody waits for any more and remove its files."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
        if self._work is not None:
            shutil.rmtree(self._work, ignore_errors=True)


def _sources_of(wheel: Path) -> str | None:
    """Return the hash of the sources that a wheel was built from, None if it has none."""
    try:
        with ZipFile(wheel) as archive:
            names = [name for name in archive.namelist() if name.endswith('/' + _HASH_FILE)]
            return archive.read(names[0]).decode() if names else None
    except BadZipFile:
        return None


def cache_folder() -> Path:
    """Return the folder that keeps what was built, across source trees."""
    given = os.environ.get('XDG_CACHE_HOME')
    return (Path(given) if given else Path.home() / '.cache') / 'armsim_ros'
