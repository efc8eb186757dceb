# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ament_index_python for launch files, which finds source packages too."""

from __future__ import annotations

import os
from pathlib import Path
import re
from typing import Any

from armsim_ros.launch.failures import MissingPackageError
from armsim_ros.launch.lookup import current_lookup

PackageNotFoundError = MissingPackageError


def get_package_share_directory(package_name: Any, print_warning: bool = True) -> str:
    """
    Return the share folder of a package, or its sources.

    :raises MissingPackageError: where it is nowhere.
    """
    _check(package_name)
    return str(current_lookup().share(str(package_name)))


def get_package_share_path(package_name: Any, print_warning: bool = True) -> Path:
    """Return the same as a path."""
    return Path(get_package_share_directory(package_name))


def get_package_prefix(package_name: Any) -> str:
    """Return the folder under which a package is installed; of sources, the sources."""
    _check(package_name)
    return str(current_lookup().prefix(str(package_name)))


def get_packages_with_prefixes() -> dict[str, str]:
    """Return name -> prefix of all packages."""
    lookup = current_lookup()
    return {name: str(lookup.prefix(name)) for name in lookup.packages.names()}


def get_search_paths() -> list[str]:
    """Return the prefixes that packages are installed under."""
    return [prefix for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
            if prefix and os.path.isdir(prefix)]


def has_resource(resource_type: str, resource_name: str) -> str | bool:
    """Return the prefix that has a resource, False where none has."""
    if resource_type == 'packages':
        found = current_lookup().find(resource_name)
        return str(found) if found is not None else False
    for prefix in get_search_paths():
        if os.path.isfile(_resource(prefix, resource_type, resource_name)):
            return prefix
    return False


def get_resource(resource_type: str, resource_name: str) -> tuple[str, str]:
    """
    Return content and prefix of a resource.

    :raises LookupError: where no prefix has it.
    """
    for prefix in get_search_paths():
        path = _resource(prefix, resource_type, resource_name)
        if os.path.isfile(path):
            return Path(path).read_text(encoding='utf-8'), prefix
    raise LookupError(f"no resource '{resource_name}' of type '{resource_type}'")


def get_resources(resource_type: str) -> dict[str, str]:
    """Return name -> prefix of all resources of a type."""
    found: dict[str, str] = {}
    for prefix in get_search_paths():
        folder = os.path.dirname(_resource(prefix, resource_type, 'x'))
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
            found.setdefault(name, prefix)
    return found


def _resource(prefix: str, kind: str, name: str) -> str:
    return os.path.join(prefix, 'share', 'ament_index', 'resource_index', kind, name)


def _check(name: Any) -> None:
    if not re.fullmatch(r'[a-zA-Z0-9_-]+', str(name)):
        raise ValueError(f"'{name}' is not a name of a package")
