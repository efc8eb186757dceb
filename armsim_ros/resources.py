# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds files: the package's own configuration, and what ``package://`` and ``$(find)`` name."""

from __future__ import annotations

from collections.abc import Iterable
import os
from pathlib import Path
import re

from armsim_ros.errors import nearest, ResourceError
from armsim_ros.packages import MANIFEST, package_name, package_of, Packages

PACKAGE = 'armsim_ros'
#: The file that makes a folder that of a cell with several robots.
ROBOTS_FILE = 'robots.yaml'
_SOURCE_TREE = Path(__file__).resolve().parent.parent
_FIND = re.compile(r'\$\(find(?:-pkg-share)?\s+([^)\s]+)\s*\)')
_SCHEMES = ('package://', 'model://')


def share_folder(package: str, packages: Packages | Iterable[Path] = ()) -> Path:
    """
    Return the folder that holds a package's files.

    Where this code runs from its source tree, its own files are always those beside it: code and
    files of the same version.

    :param package: the package's name.
    :param packages: the lookup; or folders to search before all others.
    :raises ResourceError: where no place has it.
    """
    if package == PACKAGE and (_SOURCE_TREE / MANIFEST).is_file():
        return _SOURCE_TREE
    return as_packages(packages).folder(package)


def as_packages(packages: Packages | Iterable[Path]) -> Packages:
    """Return the lookup of packages; mere folders are searched before all others."""
    return packages if isinstance(packages, Packages) else Packages(packages)


def resolve_uri(text: str, packages: Packages | Iterable[Path] = (), *,
                base: Path | None = None, within: Iterable[Path] | None = None) -> Path:
    """
    Return the file that a URDF or YAML text names.

    :param text: ``package://pkg/x``, ``model://pkg/x``, ``file:///x``, ``$(find pkg)/x`` or a
        path.
    :param packages: see :func:`share_folder`.
    :param base: the folder that a relative path starts from; the working folder where None.
    :param within: the folders that a file may lie in, besides those of packages that the text
        names; None allows all.
    :raises ResourceError: where the package or the file does not exist, or lies elsewhere.
    """
    found = as_packages(packages)
    path = Path(os.path.expanduser(_plain_path(text, found)))
    if base is not None:
        path = base / path
    if within is not None:
        check_inside(path, (*within, *_named_packages(text, found), *_own_package(path, found)))
    if not path.exists():
        raise ResourceError(f"file '{path}' does not exist" +
                            (f" (named as '{text}')" if str(path) != text else ''))
    return path


def expand_find(text: str, packages: Packages | Iterable[Path] = ()) -> str:
    """
    Replace every ``$(find pkg)`` and ``$(find-pkg-share pkg)`` by the package's folder.

    :raises ResourceError: where a package does not exist.
    """
    found = as_packages(packages)
    return _FIND.sub(lambda match: str(share_folder(match.group(1), found)), text)


def check_inside(path: Path, folders: Iterable[Path]) -> None:
    """
    Refuse a file that does not lie below any of the folders, whatever ``..`` its path has.

    :raises ResourceError: names the first of the folders.
    """
    roots = [Path(os.path.abspath(folder)) for folder in folders]
    if not any(Path(os.path.abspath(path)).is_relative_to(root) for root in roots):
        raise ResourceError(f"file '{path}' lies outside of the robot's folders; copy it into "
                            f'{roots[0]}')


def find_robot(name_or_folder: str) -> Path:
    """
    Return a robot's configuration folder.

    :param name_or_folder: a name under ``config/``, or a path (absolute, or with a separator, or
        an existing folder under the working folder that is not a name under ``config/``).
    :raises ResourceError: where there is neither; names the robots that there are.
    """
    return _find_named('robot', 'config', name_or_folder, [*robot_names(), *cell_names()],
                       suffixes=('',))


def find_world(name_or_file: str) -> Path:
    """
    Return a world's file.

    :param name_or_file: a name under ``worlds/`` with or without its suffix, or a path.
    :raises ResourceError: where there is neither; names the worlds that there are.
    """
    names = sorted(path.stem for path in _listing('worlds') if path.is_file())
    suffixes = ('', *sorted({path.suffix for path in _listing('worlds')}))
    return _find_named('world', 'worlds', name_or_file, names, suffixes=suffixes)


def robot_names() -> list[str]:
    """Return the names of the robots that the package brings."""
    return sorted(path.name for path in _listing('config')
                  if path.is_dir() and not (path / ROBOTS_FILE).is_file())


def cell_names() -> list[str]:
    """Return the names of the cells of several robots that the package brings."""
    return sorted(path.name for path in _listing('config') if (path / ROBOTS_FILE).is_file())


def _find_named(kind: str, folder: str, given: str, names: list[str],
                suffixes: tuple[str, ...]) -> Path:
    if given and os.sep not in given and not given.startswith('~'):
        for suffix in suffixes:
            own = share_folder(PACKAGE) / folder / f'{given}{suffix}'
            if own.exists():
                return own
    path = Path(given).expanduser()
    if given and path.exists():
        return path.resolve()
    hint = nearest(given, names)
    others = '; no such path or package' if kind == 'robot' else '; no such path'
    raise ResourceError(f"{kind} '{given}' is not found (included: {', '.join(names) or 'none'}"
                        f"{others}){'; ' + hint if hint else ''}")


def _listing(folder: str) -> list[Path]:
    place = share_folder(PACKAGE) / folder
    return [path for path in place.iterdir() if path.name[0] not in '._'] if place.is_dir() else []


def _own_package(path: Path, packages: Packages) -> list[Path]:
    """Return the package that a file lies in, where its name leads to it."""
    folder = package_of(Path(os.path.abspath(path)))
    name = package_name(folder) if folder is not None else None
    return [folder] if folder is not None and name and packages.find(name) == folder else []


def _plain_path(text: str, packages: Packages) -> str:
    for scheme in _SCHEMES:
        if text.startswith(scheme):
            package, _, rest = text[len(scheme):].partition('/')
            return str(share_folder(package, packages) / rest)
    if text.startswith('file://'):
        path = text[len('file://'):]  # more than one slash begins no other folder
        return f'/{path.lstrip("/")}' if path.startswith('/') else path
    return expand_find(text, packages)


def _named_packages(text: str, packages: Packages) -> list[Path]:
    names = [match[1] for match in _FIND.finditer(text)]
    names += [text[len(scheme):].partition('/')[0] for scheme in _SCHEMES
              if text.startswith(scheme)]
    return [share_folder(name, packages) for name in names]


def own_version() -> str:
    """Return the package's version, from where it is defined."""
    from xml.etree import ElementTree

    manifest = share_folder(PACKAGE) / 'package.xml'
    return ElementTree.parse(manifest).findtext('version', 'unknown')
