# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Runs every launch file below a folder of checkouts dry, and counts how they end.

    python scripts/launch_files.py FOLDER [--list CLASS] [--jobs N]

The folder holds one checkout a repository; packages of one are found by the files of another.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
import contextlib
from dataclasses import dataclass
import io
import multiprocessing
import os
from pathlib import Path
import re
import sys
import time
import traceback

from armsim_ros.cli.environment import add_own_prefix
from armsim_ros.launch.lookup import Lookup
from armsim_ros.launch.main import Launch, LaunchWords
from armsim_ros.packages import Packages, packages_below

#: Tests of launch itself, and files that only a test driver can run.
_SKIPPED = re.compile(r'/(ros2\+launch|ros2\+launch_ros)/|/test_[^/]*$|_test\.launch\.py$|/test/')
_ENDINGS = ('.launch.py', '_launch.py', '.launch.xml', '.launch.yaml', '.launch.yml')
CLASSES = {
    'evaluates': 'evaluates with its defaults',
    'lacks package': 'names the packages that are missing',
    'lacks argument': 'names the arguments that have to be given',
    'lacks module': 'names the modules that are missing',
    'lacks file': 'names files, programs, variables or answers that are missing',
    'raises': 'raises; answered with its own file and line',
    'stopped': 'does not come to an end; stopped',
    'traceback of ours': 'a fault of this package',
}


@dataclass
class Outcome:
    """How one file ended."""

    file: str
    kind: str
    seconds: float
    text: str


def launch_files(folder: Path) -> Iterator[Path]:
    """Yield the launch files below a folder."""
    for path, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if name[0] != '.')
        for name in sorted(names):
            file = Path(path, name)
            if name.endswith(_ENDINGS) and not _SKIPPED.search(str(file)):
                yield file


def dry_run(file: Path, found: dict[str, Path]) -> Outcome:
    """Run one file dry, in this process."""
    packages = Packages((), near=(file,))
    known = packages.find

    def find(name: str) -> Path | None:
        return known(name) or found.get(name)

    packages.find = find  # type: ignore[method-assign] # this one object finds more
    packages.beside = lambda *files: packages  # type: ignore[method-assign] # as above
    lookup = Lookup(packages)
    start = time.perf_counter()
    output, errors = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            status = Launch(LaunchWords(file, lookup)).dry_run()
    except BaseException:  # noqa: BLE001 - that is what is counted
        kind, text = 'traceback of ours', traceback.format_exc()
    else:
        text = output.getvalue() + errors.getvalue()
        kind = classify(status, text, str(file))
    return Outcome(str(file), kind, time.perf_counter() - start, text)


def classify(status: int, text: str, file: str) -> str:
    """Return the class of an output."""
    if status == 0:
        return 'evaluates'
    failures = [line for line in text.splitlines()
                if line.startswith(('launch: ', 'missing package', 'needs argument',
                                    'unknown: module'))]
    rest = [line for line in failures if line.startswith('launch: ')]
    for line in rest:
        if 'does not come to an end' in line or 'again and again' in line:
            return 'stopped'
    lacks = ('does not exist', 'is not set', 'is not installed', 'cannot be read',
             'cannot be started', 'is not found', 'has no program', 'asks for an answer')
    raised = [line for line in rest if not any(word in line for word in lacks)]
    if raised:
        return 'raises'
    for start, kind in (('missing package', 'lacks package'), ('needs arg', 'lacks argument'),
                        ('unknown: module', 'lacks module'), ('launch: ', 'lacks file')):
        if any(line.startswith(start) for line in failures):
            return kind
    return 'traceback of ours'


_FOUND: dict[str, Path] = {}


def _work(file: Path) -> Outcome:
    return dry_run(file, _FOUND)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--list', action='append', default=[], metavar='CLASS')
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--only', default='')
    arguments = parser.parse_args()
    add_own_prefix()
    folder = arguments.folder.absolute()  # xacro resolves relative names by the including file
    for checkout in sorted(folder.iterdir()):
        if checkout.is_dir():
            _FOUND.update({**packages_below(checkout), **_FOUND})
    files = [file for file in launch_files(folder) if re.search(arguments.only, str(file))]
    with multiprocessing.get_context('fork').Pool(arguments.jobs, maxtasksperchild=1) as pool:
        outcomes = pool.map(_work, files, chunksize=1)
    counts = Counter(one.kind for one in outcomes)
    print(f'{len(files)} files, {len(_FOUND)} packages; longest '
          f'{max(one.seconds for one in outcomes):.1f} s')
    for kind, text in CLASSES.items():
        print(f'{counts[kind]:6} {100 * counts[kind] / len(files):5.1f} %  {text}')
    for one in outcomes:
        if one.kind in arguments.list:
            print(f'\n== {one.file} ({one.seconds:.1f} s)\n{one.text}')
    return 1 if counts['traceback of ours'] else 0


if __name__ == '__main__':
    sys.exit(main())
