# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which interface packages are built, and in which order.

A sourced ROS installation that already offers one of the packages to this Python keeps it: the
wheel leaves the package out, so that a virtual environment never shadows the system's messages.
``ARMSIM_INTERFACES`` overrules the search: ``all`` or the names to build, separated by commas or
blanks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
import os
from pathlib import Path
import re
import sys

from build_support.errors import BuildError

SELECTION_VARIABLE = 'ARMSIM_INTERFACES'
DISTRIBUTION = 'armsim_ros_interfaces'

# Every service and action refers to these, named in its definition or not.
IMPLICIT_DEPENDENCIES = (
    'action_msgs', 'builtin_interfaces', 'service_msgs', 'unique_identifier_msgs')
# A field whose type is another package's.
FOREIGN_TYPE = re.compile(r'^[ \t]*([a-z]\w*)/[A-Z]', re.MULTILINE)


@dataclass(frozen=True)
class InterfacePackage:
    """One folder with a package.xml and definition files below msg/, srv/ and action/."""

    name: str
    folder: Path

    @property
    def definitions(self) -> list[Path]:
        """Paths of the definition files, relative to the folder, sorted."""
        return sorted(
            path.relative_to(self.folder)
            for kind in ('msg', 'srv', 'action')
            for path in (self.folder / kind).glob(f'*.{kind}'))

    @cached_property
    def named(self) -> dict[str, Path]:
        """The packages that the definitions name, each with the first file that names it."""
        found: dict[str, Path] = {}
        for path in self.definitions:
            for name in FOREIGN_TYPE.findall((self.folder / path).read_text('utf-8')):
                if name != self.name:
                    found.setdefault(name, path)
        return found

    @property
    def dependencies(self) -> tuple[str, ...]:
        """Names of the packages whose types these refer to, sorted."""
        return tuple(sorted({*self.named, *IMPLICIT_DEPENDENCIES}))


def read_packages(source: Path) -> list[InterfacePackage]:
    """
    Return the packages below a folder, each after those it depends on, large ones early.

    A manifest only marks a package: its tags vary and cover more than its definitions need.

    :param source: the folder that holds one folder a package.
    """
    found = {
        manifest.parent.name: InterfacePackage(manifest.parent.name, manifest.parent)
        for manifest in source.glob('*/package.xml')}
    ordered: dict[str, InterfacePackage] = {}

    def visit(package: InterfacePackage) -> None:
        for name in package.dependencies:
            if name in found and name not in ordered:
                visit(found[name])
        ordered[package.name] = package

    for package in sorted(
            found.values(), key=lambda package: (-len(package.definitions), package.name)):
        if package.name not in ordered:
            visit(package)
    return list(ordered.values())


def providing_prefix(name: str, environ: Mapping[str, str]) -> Path | None:
    """
    Return the sourced ROS prefix from which this Python imports a package, or None.

    A prefix counts when its ament index lists the package and it holds the package's module for
    this Python version; a prefix into which our own distribution was installed does not.

    :param name: the package's name.
    :param environ: the environment; AMENT_PREFIX_PATH is read.
    """
    version = f'python{sys.version_info.major}.{sys.version_info.minor}'
    for entry in environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        prefix = Path(entry)
        if not entry or not (
                prefix / 'share/ament_index/resource_index/packages' / name).is_file():
            continue
        folders = [
            prefix / library / version / packages
            for library in ('lib', 'local/lib')
            for packages in ('site-packages', 'dist-packages')]
        ours = any(any(folder.glob(f'{DISTRIBUTION}-*.dist-info')) for folder in folders)
        if not ours and any((folder / name / '__init__.py').is_file() for folder in folders):
            return prefix
    return None


def select(
    packages: list[InterfacePackage], environ: Mapping[str, str],
) -> tuple[list[InterfacePackage], dict[str, Path]]:
    """
    Return the packages to build and, for those left out, the prefix that provides each.

    :param packages: all packages, in order of dependence.
    :param environ: the environment; ARMSIM_INTERFACES and AMENT_PREFIX_PATH are read.
    :raises BuildError: ARMSIM_INTERFACES names a package that is not here.
    """
    wanted = environ.get(SELECTION_VARIABLE, '').replace(',', ' ').split()
    known = [package.name for package in packages]
    unknown = sorted(set(wanted) - {*known, 'all'})
    if unknown:
        raise BuildError(
            f'{SELECTION_VARIABLE} names {", ".join(unknown)}: no such package here; '
            f'known are {", ".join(known)}, or all')
    if 'all' in wanted:
        wanted = known
    provided = {
        name: prefix for name in known
        if name not in wanted and (prefix := providing_prefix(name, environ)) is not None}
    chosen = wanted or [name for name in known if name not in provided]
    return [package for package in packages if package.name in chosen], provided
