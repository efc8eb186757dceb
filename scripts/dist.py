# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Writes dist/: all that pip needs to install armsim_ros without a compiler.

Pure Python wheels and source archives of armsim_ros, the ros2 command, the helpers and moveit, and
a wheel of the interface packages for each supported Python of this machine. The same sources give
the same bytes. ``make dist`` runs it in the environment.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
import gzip
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tarfile
import tempfile

from env import NEWEST, OLDEST
from environment.installer import Installer
from environment.interfaces import DIST, InterfaceWheel
from environment.machine import ask_interpreter, clean_environment, Interpreter, SetupError
from environment.sources import copy_files, EPOCH, PACKAGE_SOURCES
from environment.stages import TOOLS

ROOT = Path(__file__).resolve().parent.parent
#: Each distribution without compiled code: the folder of its build files, and its sources.
PURE = {
    '.': (*PACKAGE_SOURCES, 'NOTICE', 'README.md'),
    'ros2': ('ros2',),
    'helpers': ('helpers',),
    'distributions/moveit': ('distributions/moveit',),
}
PORTABLE = 'manylinux_2_28_'
VERSIONS = [f'{OLDEST[0]}.{minor}' for minor in range(OLDEST[1], NEWEST[1] + 1)]

_HOOK = """
import sys
from setuptools import build_meta
getattr(build_meta, sys.argv[1])(sys.argv[2])
"""


def main(argv: Sequence[str]) -> int:
    """
    Write dist/.

    :returns: 0, or 1 after a message that names what is missing.
    """
    parser = argparse.ArgumentParser(prog='dist.py', description='Write wheels to dist/.')
    parser.add_argument('--python', action='append', choices=VERSIONS, metavar='3.X',
                        help='build the interface packages for this Python alone; repeatable '
                             '(default: all supported versions that are installed)')
    parser.add_argument('--to', type=Path, default=ROOT / DIST, metavar='DIR',
                        help='the folder to write to (default: dist in the source tree)')
    arguments = parser.parse_args(argv)
    try:
        with tempfile.TemporaryDirectory(prefix='armsim_ros-dist-') as name:
            made = Path(name, 'made')
            made.mkdir()
            for place, sources in PURE.items():
                build_pure(place, sources, Path(name, place if place != '.' else 'main'), made)
            for version, python, interpreter in find_pythons(arguments.python or VERSIONS):
                shutil.copy(build_interfaces(version, python, interpreter), made)
            replace_files(arguments.to, made)
    except SetupError as failure:
        print(f'dist: {failure}', file=sys.stderr)
        return 1
    return 0


def build_pure(place: str, sources: Sequence[str], work: Path, target: Path) -> None:
    """
    Make the source archive of a distribution, and its wheel from that archive.

    :param place: the folder of its build files in the source tree.
    :param sources: files and folders of the source tree.
    :param work: a scratch folder.
    :param target: the folder to write to.
    """
    copy_files(ROOT, sources, work / 'tree')
    run_hook('build_sdist', work / 'tree' / place, work)
    archive, = work.glob('*.tar.gz')
    repack(archive, target / archive.name)
    with tarfile.open(target / archive.name) as stream:
        stream.extraction_filter = getattr(tarfile, 'data_filter', None)  # not in 3.11.2
        stream.extractall(work / 'unpacked')
    tree, = (work / 'unpacked').iterdir()
    run_hook('build_wheel', tree, target)


def run_hook(hook: str, folder: Path, target: Path) -> None:
    """
    Let setuptools build in a folder.

    :raises SetupError: it failed.
    """
    done = subprocess.run(
        [sys.executable, '-c', _HOOK, hook, target], cwd=folder, capture_output=True, text=True,
        umask=0o022, env=dict(clean_environment(), SOURCE_DATE_EPOCH=EPOCH))
    if done.returncode != 0:
        raise SetupError(f'{hook} of {folder} failed:\n{(done.stderr or done.stdout).strip()}')


def repack(archive: Path, target: Path) -> None:
    """Copy a .tar.gz without what differs between two runs: times, owners, order, umask."""
    with tarfile.open(archive) as source, open(target, 'wb') as raw, \
            gzip.GzipFile('', 'wb', fileobj=raw, mtime=int(EPOCH)) as zipped, \
            tarfile.open(fileobj=zipped, mode='w', format=tarfile.GNU_FORMAT) as stream:
        for member in sorted(source.getmembers(), key=lambda member: member.name):
            member.mtime = int(EPOCH)
            member.uid = member.gid = 0
            member.uname = member.gname = ''
            member.mode = 0o755 if member.isdir() or member.mode & 0o100 else 0o644
            stream.addfile(member, source.extractfile(member) if member.isfile() else None)


def find_pythons(versions: Sequence[str]) -> Iterator[tuple[str, Path, Interpreter]]:
    """
    Yield each version, an interpreter of it that has headers, and its description.

    :raises SetupError: there is no interpreter with headers at all.
    """
    found = False
    for version in versions:
        for python in interpreters(version):
            interpreter = ask_interpreter(python)
            if interpreter is not None and interpreter.version.startswith(f'{version}.') \
                    and Path(interpreter.include, 'Python.h').is_file():
                found = True
                yield version, python, interpreter
                break
        else:
            print(f'dist: no Python {version} with headers (python{version}-dev): no wheel for it')
    if not found:
        raise SetupError(f'no Python with headers among {", ".join(versions)}: no interfaces')


def interpreters(version: str) -> Iterator[Path]:
    """Yield where an interpreter of a version may be: here, on PATH, in pyenv's folders."""
    yield Path(sys.executable)
    on_path = shutil.which(f'python{version}')
    if on_path is not None:
        yield Path(on_path)
    pyenv = Path(os.environ.get('PYENV_ROOT', Path.home() / '.pyenv'))
    yield from sorted(pyenv.glob(f'versions/{version}.*/bin/python'))


def build_interfaces(version: str, python: Path, interpreter: Interpreter) -> Path:
    """
    Return the wheel of the interface packages for an interpreter.

    :raises SetupError: the build failed, or a library needs a symbol that is too new.
    """
    wheel = InterfaceWheel(ROOT, interpreter, None)
    log = ROOT / 'build' / f'interfaces-{version}.log'
    existing = wheel.existing()
    if existing is None:
        print(f'dist: compiling the ROS interface packages for Python {version}', flush=True)
        log.parent.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix='armsim_ros-venv-') as name:
            subprocess.run([python, '-m', 'venv', name], check=True, env=clean_environment())
            Installer(Path(name)).pip('install pip', TOOLS)
            try:
                wheel.start(Path(name, 'bin/python'), log)
                existing = wheel.finish(log)
            finally:
                wheel.clean_up()
    if PORTABLE not in existing.name:
        raise SetupError(
            f'{existing.name} needs newer symbols than {PORTABLE}* has (see "needs" in {log}); '
            f'build with an older compiler, or in an image of AlmaLinux 8, and remove {existing}')
    return existing


def replace_files(folder: Path, made: Path) -> None:
    """Put new files in place of all of ours, and list them."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in [*folder.glob('armsim_*.whl'), *folder.glob('armsim_*.tar.gz')]:
        old.unlink()
    for file in sorted(made.iterdir()):
        shutil.move(file, folder / file.name)
        print(folder / file.name)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
