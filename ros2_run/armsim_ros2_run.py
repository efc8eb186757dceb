# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A ``ros2`` that can ``run``, ``launch`` and ``control``, for an environment without ros2cli.

Where a real ros2 lies further down PATH, that one does everything: it is told of this
environment's packages and takes this process over.
"""

from __future__ import annotations

from collections.abc import Sequence
import difflib
import os
from pathlib import Path
import shlex
import sys

USAGE = """usage: ros2 run [--prefix COMMAND] PACKAGE PROGRAM [argument ...]
       ros2 launch PACKAGE FILE [NAME:=VALUE ...]
       ros2 control load_controller | unload_controller | set_controller_state |
                    switch_controllers | set_hardware_component_state ...

This ros2 belongs to a Python environment without ROS 2's own tools: it can only run programs
and launch files, and switch controllers. For the other verbs (topic, action ...) install ROS 2
Jazzy (https://docs.ros.org/en/jazzy/Installation.html) and source it; this command then hands over
to that ros2 by itself."""

#: How another copy of this program, in another environment, is told from the real one.
_OWN_MARK = b'armsim_ros2_run'


class RunError(Exception):
    """What cannot be run; the text is for the user."""


def main() -> int:
    """Run ``ros2``; comes back only where nothing could be started."""
    argv = sys.argv[1:]
    real = find_real_ros2(os.environ.get('PATH', ''))
    if real is not None:
        os.execve(real, [str(real), *argv], environment_for_real_ros2())
    try:
        if not argv or argv[0] in ('-h', '--help'):
            print(USAGE)
            return 0 if argv else 2
        if argv[0] == 'launch':
            command = armsim_command('launch', argv[1:])
        elif argv[0] == 'control':
            command = armsim_command('original', ['ros2_control', *argv[1:]])
        elif len(argv) == 3 and argv[0] == 'run' and argv[2] in ('-h', '--help'):
            print(programs_text(argv[1], package_prefixes()))
            return 0
        elif argv[0] == 'run':
            command = run_command(argv[1:], package_prefixes())
        else:
            raise RunError(f"this ros2 cannot '{argv[0]}'\n{USAGE}")
        os.execvp(command[0], command)
    except RunError as error:
        print(f'ros2: {error}', file=sys.stderr)
    except OSError as error:
        print(f'ros2: cannot start {error.filename}: {error.strerror}', file=sys.stderr)
    return 2


def run_command(argv: Sequence[str], prefixes: Sequence[Path]) -> list[str]:
    """
    Return the words that the verb run starts.

    :param argv: the words after ``run``.
    :param prefixes: where packages are installed, first wins.
    :raises RunError: where words are missing, or the package or program does not exist.
    """
    words = list(argv)
    before: list[str] = []
    while words and words[0].startswith('-'):
        option = words.pop(0)
        if option in ('-h', '--help'):
            raise RunError(USAGE)
        if option == '--prefix' and words:
            before = shlex.split(words.pop(0))
        elif option.startswith('--prefix='):
            before = shlex.split(option.partition('=')[2])
        else:
            raise RunError(f"unknown option '{option}'\n{USAGE}")
    if len(words) < 2:
        raise RunError(f'run needs a package and a program\n{USAGE}')
    package, program, *rest = words
    return [*before, str(find_program(package, program, prefixes)), *rest]


def find_program(package: str, program: str, prefixes: Sequence[Path]) -> Path:
    """
    Return the executable file of a package's program.

    :raises RunError: where there is none; names those there are.
    """
    folder, names = programs_of(package, prefixes)
    if program in names:
        return folder / program
    raise RunError(f"package '{package}' has no program '{program}'"
                   f'{_hint(program, names)} (it has: {", ".join(names) or "none"})')


def programs_of(package: str, prefixes: Sequence[Path]) -> tuple[Path, list[str]]:
    """
    Return the folder of a package's programs and their names.

    :raises RunError: there is no such package.
    """
    for prefix in prefixes:
        if _marker_folder(prefix).joinpath(package).is_file():
            folder = prefix / 'lib' / package
            files = folder.iterdir() if folder.is_dir() else ()
            return folder, sorted(path.name for path in files if _is_program(path))
    known = sorted({path.name for prefix in prefixes if _marker_folder(prefix).is_dir()
                    for path in _marker_folder(prefix).iterdir()})
    raise RunError(f"package '{package}' not found{_hint(package, known)} (looked in: "
                   f'{", ".join(map(str, prefixes))})')


def programs_text(package: str, prefixes: Sequence[Path]) -> str:
    """
    Return what ``ros2 run PACKAGE --help`` says: the package's programs.

    :raises RunError: where there is no such package.
    """
    rows = [f'  ros2 run {package} {name}' for name in programs_of(package, prefixes)[1]]
    return '\n'.join([f"programs of '{package}' (each has a --help of its own):", *rows])


def package_prefixes() -> list[Path]:
    """Return the folders that packages are installed under: the sourced ones, then this one."""
    sourced = [Path(entry) for entry in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
               if entry]
    own = Path(sys.prefix)
    return sourced if own in sourced else [*sourced, own]


def find_real_ros2(search_path: str) -> Path | None:
    """
    Return the first ros2 on the search path that is none of this kind.

    :param search_path: folders, as in PATH.
    """
    for entry in search_path.split(os.pathsep):
        candidate = Path(entry or '.', 'ros2')
        if not _is_program(candidate):
            continue
        with open(candidate, 'rb') as stream:
            if _OWN_MARK not in stream.read(4096):
                return candidate
    return None


def environment_for_real_ros2() -> dict[str, str]:
    """Return the environment in which another Python finds its own libraries and our packages."""
    environment = dict(os.environ)
    # The start-up hook of the rclpy wheels sets both for this environment's Python alone.
    if environment.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None):
        paths = environment.pop('LD_LIBRARY_PATH', '').split(os.pathsep)
        others = [path for path in paths if path and not path.startswith(sys.prefix + os.sep)]
        if others:
            environment['LD_LIBRARY_PATH'] = os.pathsep.join(others)
    environment['AMENT_PREFIX_PATH'] = os.pathsep.join(map(str, package_prefixes()))
    return environment


def armsim_command(program: str, argv: Sequence[str]) -> list[str]:
    """
    Return the words that start a program of armsim_ros.

    :param argv: its arguments.
    :raises RunError: where armsim_ros is not in this environment.
    """
    armsim = Path(sys.prefix, 'bin', 'armsim')
    if not _is_program(armsim):
        raise RunError(f'there is no {armsim}; install armsim_ros into this environment')
    return [str(armsim), program, *argv]


def _marker_folder(prefix: Path) -> Path:
    return prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'


def _is_program(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)


def _hint(word: str, known: Sequence[str]) -> str:
    hits = difflib.get_close_matches(word, known, n=1)
    return f"; did you mean '{hits[0]}'?" if hits else ''
