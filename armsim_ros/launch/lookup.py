# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds packages and their programs for launch files, also in sources that are not built."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import lru_cache
import itertools
import os
from pathlib import Path
import re
import shutil
import sys
from tempfile import mkdtemp, TemporaryDirectory

from armsim_ros.cli.environment import add_own_prefix, AMENT_PREFIX_PATH
from armsim_ros.errors import ResourceError
from armsim_ros.install_rules.view import installed_programs
from armsim_ros.launch.failures import MissingPackageError
from armsim_ros.packages import package_name, Packages, sourced_prefixes

#: ``ament_python_install_package(NAME [PACKAGE_DIR folder])`` of a CMakeLists.txt.
_CMAKE = re.compile(r'ament_python_install_(?:package|module)\(\s*([^\s)]+)'
                    r'(?:[^)]*?PACKAGE_DIR\s+([^\s)]+))?')
_PROJECT = re.compile(r'^\s*project\(\s*([\w-]+)', re.MULTILINE | re.IGNORECASE)
#: ``program = module:function``, as in setup.py and setup.cfg; pyproject.toml quotes the right.
_SCRIPT = re.compile(r'^[ \t]*["\']?([\w.-]+)["\']?\s*=\s*["\']?([\w.{}]+:[\w.]+)["\']?',
                     re.MULTILINE)
_STRING = re.compile(r'[frFR]*(["\'])(?P<text>[^"\'\n]*=[^"\'\n]*:[^"\'\n]*)\1')
_VARIABLE = re.compile(r'^(\w+)\s*=\s*["\']([\w.-]+)["\']\s*$', re.MULTILINE)
_ADDED = re.compile(r'(\w+)\s*\+\s*(["\'])')
_JOINED = re.compile(r'(["\'])\s*\+\s*\1')
#: Folders with an __init__.py that a build does not install.
_NOT_INSTALLED = ('test', 'tests', 'build', 'install')
_SECTIONS = {'setup.cfg': 'console_scripts', 'pyproject.toml': 'project.scripts'}


@dataclass(frozen=True)
class PythonSources:
    """
    What a build would install of a package's Python.

    :param modules: name -> folder of the package, or file of the module.
    :param scripts: program -> ``module:function``.
    """

    modules: dict[str, Path] = field(default_factory=dict)
    scripts: dict[str, str] = field(default_factory=dict)


@lru_cache(None)
def python_sources(folder: Path) -> PythonSources:
    """
    Return the Python of the package in a folder.

    A folder of the package's own name is a module even where no file of the build names it.
    """
    modules = dict(_cmake_modules(folder))
    is_python = any((folder / name).is_file()
                    for name in ('setup.py', 'setup.cfg', 'pyproject.toml'))
    own = package_name(folder) or folder.name
    for place in (folder / 'src', folder):
        modules.update((entry.parent.name, entry.parent)
                       for entry in sorted(place.glob('*/__init__.py'))
                       if entry.parent.name == own
                       or (is_python and entry.parent.name not in _NOT_INSTALLED))
    return PythonSources(modules, dict(_scripts(folder)))


def script_text(target: str) -> str:
    """Return a program that calls ``module:function`` and ends with what it returns."""
    module, _, function = target.partition(':')
    return (f'import sys\n\nfrom {module} import {function.partition(".")[0]}\n\n'
            f'sys.exit({function}())\n')


def _cmake_modules(folder: Path) -> Iterator[tuple[str, Path]]:
    text = _text(folder / 'CMakeLists.txt')
    project = _PROJECT.search(text)
    name = project[1] if project else package_name(folder) or folder.name
    for module, place in _CMAKE.findall(text):
        module = module.strip('"').replace('${PROJECT_NAME}', name)
        place = place.strip('"').replace('${PROJECT_NAME}', name)
        found = folder / (place or module).replace('${CMAKE_CURRENT_SOURCE_DIR}/', '')
        if found.exists():
            yield Path(module).stem, found


def _scripts(folder: Path) -> Iterator[tuple[str, str]]:
    text = _text(folder / 'setup.py')
    names = dict(_VARIABLE.findall(text))
    text = _ADDED.sub(lambda match: f'{match[2]}{names.get(match[1], match[1])}', text)
    text = _JOINED.sub('', text)
    for variable, value in names.items():
        text = text.replace(f'{{{variable}}}', value)
    for match in _STRING.finditer(text):
        yield from _SCRIPT.findall(match['text'])
    for name, section in _SECTIONS.items():
        _, found, rest = _text(folder / name).partition(section)
        if found:
            # Up to the next section, or to the next key that is not a program.
            block = re.split(r'^\[|^\w+\s*=\s*$', rest, maxsplit=1, flags=re.MULTILINE)[0]
            yield from _SCRIPT.findall(block)


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return ''


#: Prefix of paths below a missing package; many are never opened.
NOWHERE = Path('/nonexistent/share')
#: Launch files of upstream that users include, and ours in their place.
STAND_INS = Path(__file__).resolve().parent / 'stand_ins'


class Lookup:
    """
    Finds packages and remembers the missing ones, and which problems of files were reported.

    :param packages: where to look.
    """

    def __init__(self, packages: Packages) -> None:
        self.packages = packages
        self.missing: dict[str, str] = {}
        self.reported: set[str] = set()

    def beside(self, file: Path) -> None:
        """Search around a file, too."""
        self.packages = self.packages.beside(file)

    def find(self, package: str) -> Path | None:
        """Return the share folder of a package, or its sources; None if it is not found."""
        found = self.packages.find(package)
        if found is None and (STAND_INS / package).is_dir():
            return STAND_INS / package
        return found

    def share(self, package: str) -> Path:
        """
        Return the share folder of a package, or its sources.

        :raises MissingPackageError: where it is nowhere.
        """
        found = self.find(package)
        if found is not None:
            return found
        try:
            self.packages.folder(package)
        except ResourceError as error:
            self.missing[package] = str(error)
            raise MissingPackageError(package, str(error)) from None
        raise MissingPackageError(package)

    def prefix(self, package: str) -> Path:
        """Return the folder under which a package is installed; of sources, the sources."""
        own = Path(sys.prefix)
        if (own / 'share' / package / 'package.xml').is_file():
            return own
        found = self.share(package)
        return found.parent.parent if found.parent.name == 'share' else found

    def program(self, package: str, name: str) -> Path | None:
        """
        Return the executable file of a package's program, None if it is not found.

        What is installed comes before the sources.
        """
        found = self.packages.find(package)
        installed = self.installed(package, name)
        if installed is not None or found is None:
            return installed
        return _source_program(found, name) or installed_programs(found, package).get(name)

    def installed(self, package: str, name: str) -> Path | None:
        """Return the executable file of a program of a package that is built, else None."""
        found = self.packages.find(package)
        prefixes = sourced_prefixes()
        if found is not None and found.parent.name == 'share':
            prefixes.insert(0, found.parent.parent)
        for prefix in (*prefixes, Path(sys.prefix)):
            installed = prefix / 'lib' / package / name
            if installed.is_file() and os.access(installed, os.X_OK):
                return installed
        return None

    def console_script(self, package: str, name: str) -> str:
        """Return ``module:function`` of a program in a package's sources, '' if there is none."""
        found = self.packages.find(package)
        return '' if found is None else python_sources(found).scripts.get(name, '')

    def module(self, name: str) -> Path | None:
        """Return folder or file of a Python module in the sources of a package, None without."""
        own = self.packages.find(name)
        if own is not None and name in python_sources(own).modules:
            return python_sources(own).modules[name]
        return self.modules().get(name)

    def modules(self) -> dict[str, Path]:
        """Return name -> folder or file of the Python modules in the sources of all packages."""
        found: dict[str, Path] = {}
        for folder in self.packages.names().values():
            if folder.parent.name != 'share':
                found = {**python_sources(folder).modules, **found}
        return found


def missing_package_of(path: str | Path) -> str:
    """Return the missing package of a path, '' for any other path."""
    parts = Path(path).parts
    start = len(NOWHERE.parts)
    return parts[start] if parts[:start] == NOWHERE.parts and len(parts) > start else ''


def check_not_missing(path: str | Path) -> None:
    """
    Refuse a file of a missing package.

    :raises MissingPackageError: names the package.
    """
    package = missing_package_of(path)
    if package:
        current_lookup().share(package)


def stand_in_of(path: Path) -> Path | None:
    """Return our replacement of an upstream launch file, None if there is none; it is in XML."""
    names = dict.fromkeys((path.name, path.with_suffix('.xml').name))
    places = (STAND_INS / package / 'launch' / name
              for package in path.parent.parts for name in names)
    return next((place for place in places if place.is_file()), None)


def _source_program(folder: Path, name: str) -> Path | None:
    """Return a Python program in the sources of a package."""
    names = (name, f'{name}.py') if not name.endswith('.py') else (name,)
    places = (folder / 'scripts', folder / 'nodes', folder / 'src', folder / 'bin', folder,
              folder / folder.name)
    for place in places:
        for candidate in names:
            if (place / candidate).is_file() and _is_python(place / candidate):
                return place / candidate
    return None


def _is_python(file: Path) -> bool:
    if file.suffix == '.py':
        return True
    with file.open('rb') as stream:
        first = stream.readline(200)
    return first.startswith(b'#!') and b'python' in first


_CURRENT: ContextVar[Lookup | None] = ContextVar('lookup', default=None)


def current_lookup() -> Lookup:
    """Return the lookup of the launch that is being evaluated."""
    found = _CURRENT.get()
    return found if found is not None else Lookup(Packages())


@contextmanager
def looking_with(lookup: Lookup) -> Iterator[Lookup]:
    """
    Have launch files that are evaluated inside use this lookup.

    The programs that they start find the packages in sources through the ament index.
    """
    token = _CURRENT.set(lookup)
    before = os.environ.get(AMENT_PREFIX_PATH)
    try:
        with TemporaryDirectory(prefix='armsim_sources_') as prefix:
            lookup.packages.link_sources(Path(prefix))
            os.environ[AMENT_PREFIX_PATH] = os.pathsep.join(filter(None, (prefix, before)))
            add_own_prefix()
            yield lookup
    finally:
        if before is None:
            os.environ.pop(AMENT_PREFIX_PATH, None)
        else:
            os.environ[AMENT_PREFIX_PATH] = before
        _CURRENT.reset(token)


def make_lookup(path: Iterable[Path], near: Iterable[Path]) -> Lookup:
    """Return a lookup that starts from some folders and files."""
    return Lookup(Packages(path, near=near))


class KeptFiles:
    """A folder that is made when it is first needed."""

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._order = itertools.count()

    def write(self, name: str, text: str) -> str:
        """Write a text into a file of its own and return its path."""
        path = self._kept() / f'{next(self._order)}_{name}'
        path.write_text(text, encoding='utf-8')
        return str(path)

    def source_modules(self) -> str:
        """Return a folder with links to the Python modules in the sources of all packages."""
        folder = self._kept() / 'python'
        if not folder.exists():
            folder.mkdir()
            for name, place in current_lookup().modules().items():
                (folder / (place.name if place.is_file() else name)).symlink_to(place)
        return str(folder)

    def remove(self) -> None:
        """Remove the files."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _kept(self) -> Path:
        if self._folder is None:
            self._folder = Path(mkdtemp(prefix='armsim_launch_'))
        return self._folder
