# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line of ``armsim launch``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
import os
from pathlib import Path

from armsim_ros.cli.arguments import UsageError
from armsim_ros.errors import nearest
from armsim_ros.launch.failures import MissingPackageError
from armsim_ros.launch.lookup import Lookup, make_lookup, STAND_INS
from armsim_ros.packages import split_path

USAGE = """usage: armsim launch PACKAGE FILE [NAME:=VALUE ...]
       armsim launch PATH [NAME:=VALUE ...]

Run a launch file (.launch.py, .launch.xml, .launch.yaml, ROS 1 .launch) as it is. Programs of
Gazebo, ros2_control and MoveIt are replaced by those of this package, others run where they are
installed, or from the sources of a Python package.

options:
  -s, --show-args          the arguments of the launch file
  -n, --dry-run            start nothing; print what would be started, and what is missing
  -p, --print-description  the launch file as a tree, not evaluated
  -d, --debug              print more
  -a, --show-all-subprocesses-output
                           show all output (always so here)
  packages_path:=DIR[:DIR] folders that are searched first for packages"""

_FLAGS = {
    '-s': 'show_arguments', '--show-args': 'show_arguments', '--show-arguments': 'show_arguments',
    '-n': 'dry', '--dry-run': 'dry',
    '-p': 'print_description', '--print': 'print_description',
    '--print-description': 'print_description',
    '-d': 'debug', '--debug': 'debug',
    '-a': 'all_output', '--show-all-subprocesses-output': 'all_output',
    '--noninteractive': 'noninteractive',
}
ENDINGS = ('launch.py', '_launch.py', 'launch.xml', 'launch.yaml', 'launch.yml', '.launch')


@dataclass
class LaunchWords:
    """
    The command line, parsed.

    :param arguments: in the order of the command line, the last of a name counts.
    """

    file: Path
    lookup: Lookup
    arguments: dict[str, str] = field(default_factory=dict)
    show_arguments: bool = False
    dry: bool = False
    print_description: bool = False
    debug: bool = False
    all_output: bool = False
    noninteractive: bool = False


def parse_words(words: Sequence[str]) -> LaunchWords:
    """
    Parse the words after ``launch``.

    :raises UsageError: where they cannot be understood, or the file does not exist.
    """
    places: list[str] = []
    arguments: dict[str, str] = {}
    flags: dict[str, bool] = {}
    for word in words:
        name, sign, value = word.partition(':=')
        if sign and not word.startswith('-'):
            if not name:
                raise UsageError(f"cannot read '{word}': arguments are written name:=value")
            arguments[name] = value
        elif word in _FLAGS:
            flags[_FLAGS[word]] = True
        elif word.startswith('-') and len(word) > 2 and not word.startswith('--') and all(
                f'-{letter}' in _FLAGS for letter in word[1:]):
            flags.update({_FLAGS[f'-{letter}']: True for letter in word[1:]})
        elif word.startswith('-'):
            raise UsageError(f"unknown option '{word}'; {nearest(word, tuple(_FLAGS)) or USAGE}")
        else:
            places.append(word)
    if not places:
        raise UsageError(f'no launch file is named\n{USAGE}')
    if len(places) > 2:
        raise UsageError(f"cannot read '{places[2]}': arguments are written name:=value")
    path = split_path(arguments.get('packages_path', ''))
    file, lookup = _find(places, path)
    return LaunchWords(file, lookup, arguments, **flags)


def _find(places: Sequence[str], path: tuple[Path, ...]) -> tuple[Path, Lookup]:
    first = Path(places[0]).expanduser()
    if len(places) == 1:
        if first.is_file():
            file = first.resolve() if first.is_symlink() else first.absolute()
            return first.absolute(), make_lookup(path, [first.absolute(), file])
        if first.is_dir():
            raise UsageError(f"'{first}' is a folder; {_choice(_launch_files(first))}")
        raise UsageError(f"launch file '{places[0]}' does not exist"
                         + ('' if first.suffix else '; with a package: armsim launch PACKAGE '
                            'FILE'))
    package, name = places
    lookup = make_lookup(path, [first.absolute()] if first.is_dir() else [])
    folder = first.absolute() if first.is_dir() and (first / 'package.xml').is_file() else None
    if folder is None:
        try:
            folder = lookup.share(package)
        except MissingPackageError as error:
            raise UsageError(str(error)) from None
    # Links may lead to a file in two ways.
    found = list({file.resolve(): file for file in _launch_files(folder)
                  if file.name == name}.values())
    if not found and folder != STAND_INS / package and (STAND_INS / package).is_dir():
        found = [file for file in _launch_files(STAND_INS / package) if file.name == name]
    if not found:
        files = list(_launch_files(folder))
        hint = nearest(name, [file.name for file in files])
        raise UsageError(f"package '{package}' ({folder}) has no launch file '{name}'; "
                         f'{hint or _choice(files)}')
    if len(found) > 1:
        raise UsageError(f"package '{package}' has several files '{name}': "
                         f"{', '.join(map(str, found))}; name one by its path")
    return found[0], make_lookup(path, [found[0]])


def _launch_files(folder: Path) -> Iterator[Path]:
    # The folder of a package that is not built may consist of links.
    found, seen = [], set()
    for place, folders, names in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        found += [Path(place, name) for name in names]
    for file in sorted(found):
        if file.is_file() and (file.name.endswith(ENDINGS) or (file.parent.name == 'launch'
                               and file.suffix in ('.py', '.xml', '.yaml'))):
            yield file


def _choice(files: Iterator[Path] | Sequence[Path]) -> str:
    names = ', '.join(dict.fromkeys(file.name for file in files))
    return f'there are: {names}' if names else 'it has none'
