# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds ROS packages by the name in their ``package.xml``, installed or as sources."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
import os
from pathlib import Path
import re
import sys

from armsim_ros.errors import nearest, ResourceError
from armsim_ros.install_rules.view import installed_view

MANIFEST = 'package.xml'
#: Files that hide a folder and all below it from colcon.
IGNORE_MARKS = frozenset({'COLCON_IGNORE', 'AMENT_IGNORE', 'CATKIN_IGNORE'})
DEEPEST = 6
#: So many folders are looked into at most: a wrong path is no reason to read a whole disk.
MOST_FOLDERS = 20_000
#: Around a package that lies in no workspace: as deep as a repository beside it has packages.
NEIGHBOUR_DEPTH = 3
#: Where an installation lists its packages, below the prefix.
MARKERS = Path('share', 'ament_index', 'resource_index', 'packages')
#: A file in the prefix of links that a launch makes.
LINKS_MARK = '.armsim_sources'
_SKIPPED = frozenset({'build', 'node_modules', '__pycache__'})
_COMMENT = re.compile(rb'<!--.*?-->', re.DOTALL)
_NAME = re.compile(rb'<name>\s*([^<\s]+)\s*</name>')
_MOST_PLACES = 5


def package_name(folder: Path) -> str | None:
    """Return the name of the package in a folder, None where the folder is none."""
    data = _read(os.path.join(folder, MANIFEST))
    if data is None:
        return None
    match = _NAME.search(_COMMENT.sub(b'', data))
    return match[1].decode(errors='replace') if match else folder.name


def depends_on(folder: Path, name: str) -> bool:
    """Return whether the manifest of a package names another as needed."""
    needed = re.compile(rf'<(?:\w+_)?depend>\s*{re.escape(name)}\s*</'.encode())
    data = _read(os.path.join(folder, MANIFEST)) or b''
    return needed.search(_COMMENT.sub(b'', data)) is not None


def _read(path: str) -> bytes | None:
    """Return the beginning of a file; a workspace has hundreds, so nothing is wrapped here."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        return os.read(descriptor, 1 << 16)
    except OSError:
        return None
    finally:
        os.close(descriptor)


def package_of(path: Path) -> Path | None:
    """Return the folder of the package that a file or folder belongs to, None if there is none."""
    for folder in (path, *path.parents):
        if (folder / MANIFEST).is_file():
            return folder
    return None


def workspace_of(path: Path) -> Path | None:
    """Return the nearest folder around a path that has ``src`` or ``install``, None without."""
    for folder in path.parents:
        if folder.parent == folder or folder == Path('/usr'):
            return None
        if (folder / 'src').is_dir() or (folder / 'install').is_dir():
            return folder
    return None


def packages_below(
    folder: Path, depth: int = DEEPEST, *, ignored: bool = False
) -> dict[str, Path]:
    """
    Return name -> folder of the packages in a tree of sources.

    Folders are searched in the order of their depth and their names, and of two packages of one
    name the first counts. There are no packages inside packages, nor below a folder with
    ``COLCON_IGNORE`` or ``AMENT_IGNORE``, nor in ``build`` and hidden folders.

    :param depth: so many folders below the given folder at most.
    :param ignored: whether packages that are marked so are returned, too.
    """
    found: dict[str, Path] = {}
    pending = deque([(os.fspath(folder), 0)])
    budget = MOST_FOLDERS
    while pending and budget:
        place, level = pending.popleft()
        budget -= 1
        try:
            with os.scandir(place) as entries:
                names = {entry.name: entry for entry in entries}
        except OSError:
            continue
        if not ignored and not IGNORE_MARKS.isdisjoint(names):
            continue
        if MANIFEST in names:
            name = package_name(Path(place))
            if name is not None:
                found.setdefault(name, Path(place))
            continue
        if level < depth:
            pending.extend((names[name].path, level + 1) for name in sorted(names)
                           if name[0] != '.' and name not in _SKIPPED and _is_folder(names[name]))
    return found


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:
        return False


@dataclass(frozen=True)
class _Tree:
    """A tree of sources, its packages read when they are first needed."""

    folder: Path
    depth: int = DEEPEST


class Packages:
    """
    The search path of packages; each place is read once and only when it is needed.

    In this order: the folders given; the packages around the files given; their workspace, or
    what lies beside them where they lie in none; the workspace around the working folder;
    ``AMENT_PREFIX_PATH``; ``sys.prefix/share``; at last a folder around the files that is called
    so, regardless of its manifest.

    :param path: folders that are a package, contain packages at any depth, or are an installation
        with ``share`` in it.
    :param near: the files or folders that the user named.
    """

    def __init__(self, path: Iterable[Path] = (), *, near: Iterable[Path] = ()) -> None:
        self.path = tuple(Path(os.path.abspath(folder)) for folder in path)
        self.near = tuple(dict.fromkeys(Path(os.path.abspath(folder)) for folder in near))
        self._trees: dict[_Tree, dict[str, Path]] = {}
        self._found: dict[str, Path | None] = {}

    def beside(self, *files: Path) -> Packages:
        """Return the same places and, before the others, those around further files."""
        found = Packages(self.path, near=(*files, *self.near))
        found._trees = self._trees  # what was read is not read again
        return found

    def find(self, name: str) -> Path | None:
        """
        Return the folder with a package's files, None where no place has it.

        Of sources it is a folder as their build would install it, see :meth:`installed`.
        """
        if name not in self._found:
            found = next(self._candidates(name), None)
            self._found[name] = found  # the build of a package finds its sources
            self._found[name] = found if found is None else self.installed(found)
        return self._found[name]

    def installed(self, folder: Path) -> Path:
        """
        Return the folder of a package as its build would install it: mostly the same.

        :raises ResourceError: the build makes files, and they cannot be kept.
        """
        name = package_name(folder)
        if name is None or folder.parent.name == 'share':
            return folder
        workspace = workspace_of(folder)
        around = folder.parent if workspace is None or not (workspace / 'src').is_dir() \
            else workspace / 'src'
        return installed_view(folder, name, around=around, find=self.folder)

    def folder(self, name: str) -> Path:
        """
        Return the folder with a package's files: installed its ``share``, else its sources.

        :raises ResourceError: where no place has it; the places are named.
        """
        found = self.find(name)
        if found is not None:
            return found
        places = [str(place) for place in self._places(name)]
        shown = ', '.join(places[:_MOST_PLACES]) or 'nowhere, no folder is set'
        if len(places) > _MOST_PLACES:
            shown += f' and {len(places) - _MOST_PLACES} more'
        known = tuple(each for tree in self._trees.values() for each in tree)
        hint = nearest(name, known)
        ignored = [folder for tree in self._source_trees() if (folder := packages_below(
            tree.folder, tree.depth, ignored=True).get(name)) is not None]
        if ignored:
            hint = (f'{ignored[0]} is left out of builds by {" or ".join(sorted(IGNORE_MARKS))}, '
                    'which you can remove')
        raise ResourceError(
            f"package '{name}' is not found; searched: {shown}; "
            + (f'{hint}; ' if hint else '')
            + 'clone it into src/ of your workspace, source the workspace that has it, or name '
            'the folder that contains it with packages_path:=DIR')

    def names(self) -> dict[str, Path]:
        """Return name -> folder of all packages that would be found."""
        found: dict[str, Path] = {}
        for tree in self._source_trees():
            found = {**self._read(tree), **found}
        for share in self._shares():
            index = share.parent / MARKERS
            for marker in sorted(index.iterdir()) if index.is_dir() else ():
                if (share / marker.name).is_dir():
                    found.setdefault(marker.name, share / marker.name)
        return found

    def link_sources(self, prefix: Path) -> None:
        """
        Make an installation of links to the packages in sources.

        Programs that look packages up in the ament index find them there.

        :param prefix: an empty folder.
        """
        (prefix / MARKERS).mkdir(parents=True)
        (prefix / LINKS_MARK).touch()
        for name, folder in self.names().items():
            if folder.parent.name != 'share':
                with suppress(ResourceError):  # the reason is in the error of its first use
                    (prefix / 'share' / name).symlink_to(self.find(name) or folder)
                    (prefix / MARKERS / name).touch()

    def _candidates(self, name: str) -> Iterator[Path]:
        for folder in self.path:
            yield from self._in_tree(_Tree(folder), name)
            yield from _installed(folder, name)
            yield from _of_this_name(folder, name)
        for package in self._own_packages():
            if package_name(package) == name:
                yield package
        for folder in self._folders_around():
            yield from _of_this_name(folder, name)
        for workspace in self._workspaces():
            yield from self._in_tree(_Tree(workspace / 'src'), name)
            yield from _installed(workspace / 'install', name)
        for tree in self._neighbours():
            yield from self._in_tree(tree, name)
        for prefix in sourced_prefixes():
            if (prefix / MARKERS / name).is_file() and (prefix / 'share' / name).is_dir():
                yield prefix / 'share' / name
        own = Path(sys.prefix, 'share', name)
        if own.is_dir():
            yield own
        for folder in (*self.path, *self._folders_around()):
            yield from (candidate for candidate in (folder, folder / name)
                        if candidate.name == name and candidate.is_dir())

    def _in_tree(self, tree: _Tree, name: str) -> Iterator[Path]:
        found = self._read(tree).get(name)
        if found is not None:
            yield found

    def _read(self, tree: _Tree) -> dict[str, Path]:
        if tree not in self._trees:
            self._trees[tree] = packages_below(tree.folder, tree.depth)
        return self._trees[tree]

    def _own_packages(self) -> list[Path]:
        found = (package_of(path) for path in self.near)
        return list(dict.fromkeys(folder for folder in found if folder is not None))

    def _folders_around(self) -> list[Path]:
        """Return the folders near the files given in which a package without manifest may lie."""
        starts = (path if path.is_dir() else path.parent for path in self.near)
        places = (place for start in starts for place in (start, *list(start.parents)[:3]))
        return [place for place in dict.fromkeys(places) if place != Path(place.anchor)]

    def _workspaces(self) -> list[Path]:
        places = (*self.near, Path.cwd() / 'x')
        found = (workspace_of(path) for path in places)
        return list(dict.fromkeys(folder for folder in found if folder is not None))

    def _neighbours(self) -> list[_Tree]:
        """Return what lies beside packages, or beside files, that are in no workspace."""
        homes = {Path.home(), Path('/')}
        places: list[Path] = []
        for path in self.near:
            if workspace_of(path) is None:
                package = package_of(path) or path
                around = list(package.parents)[:2] if package.is_dir() else list(
                    package.parents)[:3]
                places += [place for place in around if place not in homes]
        return [_Tree(place, NEIGHBOUR_DEPTH) for place in dict.fromkeys(places)]

    def _source_trees(self) -> list[_Tree]:
        return [*(_Tree(folder) for folder in self.path),
                *(_Tree(package) for package in self._own_packages()),
                *(_Tree(workspace / 'src') for workspace in self._workspaces()),
                *self._neighbours()]

    def _shares(self) -> list[Path]:
        return [*(prefix / 'share' for prefix in sourced_prefixes()), Path(sys.prefix, 'share')]

    def _places(self, name: str) -> list[Path]:
        """Return the places that were searched for a missing package."""
        given = [folder / name for folder in self.path]
        trees = [tree.folder for tree in self._source_trees() if tree.folder not in self.path]
        shares = [share / name for share in self._shares()]
        return list(dict.fromkeys([*given, *trees, *shares]))


def split_path(text: str) -> tuple[Path, ...]:
    """Return the folders of a ``DIR:DIR`` text."""
    return tuple(Path(part).expanduser() for part in text.split(os.pathsep) if part)


def sourced_prefixes() -> list[Path]:
    """Return the installations in ``AMENT_PREFIX_PATH``, without the links of a launch."""
    return [Path(prefix) for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
            if prefix and not Path(prefix, LINKS_MARK).is_file()]


def _of_this_name(folder: Path, name: str) -> Iterator[Path]:
    """Yield a folder, or the folder inside it, that has the name and no manifest with another."""
    for candidate in (folder, folder / name):
        if (candidate.name == name and candidate.is_dir()
                and package_name(candidate) in (None, name)):
            yield candidate


def _installed(prefix: Path, name: str) -> Iterator[Path]:
    """Yield a package's ``share`` folder in an installation, merged or a folder per package."""
    for share in (prefix / name / 'share' / name, prefix / 'share' / name):
        if share.is_dir():
            yield share
