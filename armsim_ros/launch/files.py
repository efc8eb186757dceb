# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reads launch files of all kinds."""

from __future__ import annotations

from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import re
from types import ModuleType

from armsim_ros.errors import Location
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.failures import InvalidLaunchFileError
from armsim_ros.launch.lookup import current_lookup

XML_ENDINGS = ('.xml', '.launch', '.test')
YAML_ENDINGS = ('.yaml', '.yml')


def read_launch_file(path: Path) -> LaunchDescription:
    """
    Return the description in a launch file; its code runs.

    :raises InvalidLaunchFileError: where it is not a launch file.
    """
    path = path.absolute()
    current_lookup().beside(path)
    if path.suffix == '.py':
        return _of_python(path)
    from armsim_ros.launch.frontend.files import read_frontend_file

    if path.suffix in XML_ENDINGS or path.suffix in YAML_ENDINGS:
        return read_frontend_file(path)
    raise InvalidLaunchFileError('this is not a launch file by its name', Location(str(path)))


def load_python_file(path: Path) -> ModuleType:
    """Run a Python file and return it as a module, which is not cached."""
    name = re.sub(r'\W', '_', f'launch_file_{path.stem}')
    spec = spec_from_file_location(name, path, loader=SourceFileLoader(name, str(path)))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _of_python(path: Path) -> LaunchDescription:
    module = load_python_file(path)
    make = getattr(module, 'generate_launch_description', None)
    if make is None:
        raise InvalidLaunchFileError('the launch file has no function '
                                     'generate_launch_description()', Location(str(path)))
    made = make()
    if not hasattr(made, 'visit'):
        raise InvalidLaunchFileError(
            f'generate_launch_description() returned {type(made).__name__}; allowed: a '
            'LaunchDescription', Location(str(path)))
    if not isinstance(made, LaunchDescription):
        return LaunchDescription([made])
    return made
