# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Does a planned and executed motion end in the same bytes in every Python? Standard library only.

Each Python gets an environment of its own below ``build/digests``, with the versions of all
libraries that the oldest of them takes, and runs ``examples/no_ros.py``.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
import shutil
import subprocess
import sys
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PLACE = ROOT / 'build' / 'digests'
MINORS = range(10, 14)


def main() -> int:
    """Print a line for each Python; return 0 where all of them say the same."""
    parser = argparse.ArgumentParser(description='Compare the bytes of a run in every Python.')
    parser.add_argument('pythons', nargs='*', metavar='PYTHON', default=None,
                        help='interpreters, the oldest first; every one from 3.10 to 3.13 '
                             'that PATH or pyenv has')
    arguments = parser.parse_args()
    pythons = arguments.pythons or [found for minor in MINORS if (found := _found(minor))]
    if len(pythons) < 2:
        sys.exit(f'digests: {len(pythons)} of Python 3.10 to 3.13 found, two are needed; name '
                 'interpreters: python3 scripts/digests.py PYTHON PYTHON ...')
    versions = PLACE / 'versions.txt'
    versions.unlink(missing_ok=True)
    digests: set[str] = set()
    for number, python in enumerate(pythons):
        interpreter = _environment(python, PLACE / str(number), versions)
        run = _run(interpreter, ROOT / 'examples' / 'no_ros.py', cwd=ROOT,
                   env={**os.environ, 'PYTHONPATH': str(ROOT)})
        digest = run.split()[-1]
        digests.add(digest)
        print(f'{_run(interpreter, "-V").strip()}: {digest}', flush=True)
    physics = [line for line in versions.read_text().splitlines()
               if line.startswith(('mujoco==', 'numpy=='))]
    print(f'{len(digests)} different, with {", ".join(physics)}')
    return int(len(digests) != 1)


def _found(minor: int) -> str:
    """Return the Python of this minor version, an empty text where there is none."""
    pyenv = Path(os.environ.get('PYENV_ROOT', Path.home() / '.pyenv')) / 'versions'
    candidates = [shutil.which(f'python3.{minor}'),
                  *sorted(pyenv.glob(f'3.{minor}.*/bin/python'), reverse=True)]
    for one in candidates:
        if one is None:
            continue
        # A shim may stand for nothing.
        if not subprocess.run([one, '-V'], capture_output=True, check=False).returncode:
            return str(one)
    return ''


def _environment(python: str, folder: Path, versions: Path) -> Path:
    """Return the interpreter of an environment with all that the package needs."""
    subprocess.run([python, '-m', 'venv', '--clear', folder], check=True)
    interpreter = folder / 'bin' / 'python'
    # The pip of an old Python can look for versions that fit together for ever.
    _run(interpreter, '-m', 'pip', 'install', '-q', '-U', 'pip')
    pinned: list[str | Path] = ['-c', versions] if versions.exists() else []
    _run(interpreter, '-m', 'pip', 'install', '-q', '-r', ROOT / 'requirements.txt', *pinned)
    if not pinned:
        versions.write_text(_run(interpreter, '-m', 'pip', 'freeze'))
    return interpreter


def _run(*words: str | Path, **options: Any) -> str:
    """Return what a command prints; end with what it says where it fails."""
    done: subprocess.CompletedProcess[str] = subprocess.run(
        words, capture_output=True, text=True, check=False, **options)
    if done.returncode:
        sys.exit(f'digests: {" ".join(map(str, words))} failed:\n{done.stderr}')
    return done.stdout


if __name__ == '__main__':
    sys.exit(main())
