# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Python of packages that are not built: what their build would install."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
import re

from armsim_ros.packages import package_name

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
