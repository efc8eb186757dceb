# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
An overlay for a ROS installation: upstream's package names, our programs.

``. $(armsim overlay)`` puts it before the installation; the user's own ``ros2 launch`` then starts
ours. A shell that has not sourced it sees nothing of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import hashlib
import os
from pathlib import Path
import shlex
import shutil
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.cli.environment import child_environment, program_command
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.packages import MARKERS, sourced_prefixes

USAGE = """usage: . $(armsim overlay)         use this package in this shell; source ROS first
       armsim overlay --check FILE [NAME:=VALUE ...]

Write an overlay with the package names of ros2_control and MoveIt and this package's programs,
and print the file to source. --check shows where each program of a launch file comes from."""
#: Package -> its programs here -> the replacement.
PROGRAMS: Mapping[str, Mapping[str, str]] = {
    'controller_manager': {
        'ros2_control_node': 'ros2_control_node', 'spawner': 'spawner', 'spawner.py': 'spawner',
        'unspawner': 'unspawner', 'unspawner.py': 'unspawner',
        'hardware_spawner': 'hardware_spawner'},
    'moveit_ros_move_group': {'move_group': 'move_group'},
}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write the overlay and print the file to source, or check a launch file against it.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0, or 2 for an error.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if {'-h', '--help'} & set(words):
        print(USAGE)
        return 0
    try:
        if words[:1] == ['--check']:
            return _check(words[1:])
        if words:
            raise UsageError(f"cannot read '{words[0]}'\n{USAGE}")
        print(write_overlay(overlay_folder()) / 'setup.sh')
    except ArmsimError as error:
        print(f'overlay: {error}', file=sys.stderr)
        return USAGE_STATUS
    return 0


def overlay_folder() -> Path:
    """Return where the overlay of this Python environment and this installation lies."""
    cache = os.environ.get('XDG_CACHE_HOME') or str(Path.home() / '.cache')
    identity = '\0'.join([sys.prefix, *(str(prefix) for prefix in _prefixes(None))])
    key = hashlib.sha256(identity.encode()).hexdigest()[:12]
    return Path(cache, 'armsim_ros', f'overlay-{key}')


def write_overlay(folder: Path) -> Path:
    """
    Write the overlay anew and return its folder.

    An upstream package's ``share`` is linked; its programs that are not ours stay reachable.
    """
    if folder.exists():
        shutil.rmtree(folder)
    for package, programs in PROGRAMS.items():
        upstream = next((prefix for prefix in _prefixes(folder)
                         if (prefix / MARKERS / package).is_file()), None)
        marker = folder / MARKERS / package
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.write_text('')
        share = folder / 'share' / package
        if upstream is not None and (upstream / 'share' / package).is_dir():
            share.symlink_to(upstream / 'share' / package)
        else:
            share.mkdir()
            (share / 'package.xml').write_text(
                f'<package format="3"><name>{package}</name></package>\n', encoding='utf-8')
        _write_programs(folder / 'lib' / package, programs,
                        upstream / 'lib' / package if upstream is not None else None)
    quoted = shlex.quote(str(folder))
    (folder / 'setup.sh').write_text(
        f'export AMENT_PREFIX_PATH={quoted}"${{AMENT_PREFIX_PATH:+:$AMENT_PREFIX_PATH}}"\n',
        encoding='utf-8')
    return folder


def environment_with(folder: Path) -> dict[str, str]:
    """Return this process's environment with an overlay sourced."""
    rest = [str(prefix) for prefix in _prefixes(folder)]
    return {**os.environ, 'AMENT_PREFIX_PATH': os.pathsep.join([str(folder), *rest])}


def _write_programs(folder: Path, programs: Mapping[str, str], upstream: Path | None) -> None:
    folder.mkdir(parents=True)
    for name, program in programs.items():
        words = program_command('original', [program])
        place = child_environment().get('PYTHONPATH', '')
        lines = ['#!/bin/sh']
        if place:
            lines.append(f'export PYTHONPATH={shlex.quote(place)}"${{PYTHONPATH:+:$PYTHONPATH}}"')
        lines.append(f'exec {shlex.join(words)} "$@"')
        path = folder / name
        path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
        path.chmod(0o755)
    for other in sorted(upstream.iterdir()) if upstream is not None and upstream.is_dir() else ():
        if other.name not in programs:
            (folder / other.name).symlink_to(other)


def _prefixes(without: Path | None) -> list[Path]:
    return [prefix for prefix in sourced_prefixes() if prefix != without]


def _check(words: Sequence[str]) -> int:
    """Print the origin of each program of a launch file."""
    from armsim_ros.launch.main import Launch, parse_words

    if not words:
        raise UsageError(f'--check needs a launch file\n{USAGE}')
    return Launch(parse_words([*words, '-n'])).show_origins(
        {f'{package}/{name}' for package, programs in PROGRAMS.items() for name in programs})
