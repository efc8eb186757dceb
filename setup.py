# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Builds armsim_ros in both of its worlds.

ROS (colcon, bloom: ``setup.py install`` or ``develop``): every program is a console script that
setup.cfg puts into ``lib/armsim_ros``, where ``ros2 run`` looks.

pip (``setup.py bdist_wheel``): a wheel's console scripts all go to ``bin``, whatever setup.cfg
says, and a ``bin/bringup`` would be a bad neighbour. So there is one command, ``armsim``, and
``lib/armsim_ros`` gets a small shell script a program as a data file.
"""

from pathlib import Path
from runpy import run_path
import sys
from xml.etree import ElementTree

from setuptools import setup

PACKAGE = 'armsim_ros'
SHARE = f'share/{PACKAGE}'
SHARED_FOLDERS = ('config', 'urdf', 'worlds', 'launch', 'rviz', 'examples')
PROGRAMS = tuple(run_path('armsim_ros/cli/programs.py')['PROGRAMS'])
BUILDS_WHEEL = bool({'bdist_wheel', 'dist_info', 'editable_wheel'} & set(sys.argv))

FORWARDING_SCRIPT = """#!/bin/sh
exec "$(dirname "$0")/../../bin/armsim" "$(basename "$0")" "$@"
"""


def shared_files():
    """Return (target folder, files) for everything under the shared folders, as it lies there."""
    found = {}
    for top in SHARED_FOLDERS:
        for path in sorted(Path(top).rglob('*')):
            hidden = any(part[0] == '.' or part == '__pycache__' for part in path.parts)
            if path.is_file() and not hidden:
                found.setdefault(f'{SHARE}/{path.parent}', []).append(str(path))
    return list(found.items())


def forwarding_scripts():
    """Write the shell scripts of the programs and return their paths."""
    folder = Path('build', 'programs')
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for program in PROGRAMS:
        path = folder / program
        path.write_text(FORWARDING_SCRIPT, encoding='utf-8')
        path.chmod(0o755)
        paths.append(str(path))
    return paths


def console_scripts():
    """Return the console scripts of this world."""
    if BUILDS_WHEEL:
        return [f'armsim = {PACKAGE}.cli.main:main']
    return [f'{program} = {PACKAGE}.cli.main:{program}' for program in PROGRAMS]


def data_files():
    """Return the files outside the Python package."""
    files = [
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (SHARE, ['package.xml']),
        *shared_files(),
    ]
    if 'bdist_wheel' in sys.argv:
        files.append((f'lib/{PACKAGE}', forwarding_scripts()))
    return files


manifest = ElementTree.parse('package.xml').getroot()
maintainer = manifest.find('maintainer')
setup(
    name=manifest.findtext('name'),
    version=manifest.findtext('version'),
    description=' '.join(manifest.findtext('description').split()),
    maintainer=maintainer.text,
    maintainer_email=maintainer.get('email'),
    license=manifest.findtext('license'),
    # Not in setup.cfg: colcon cannot read back what setuptools makes of it there.
    python_requires='>=3.10',
    data_files=data_files(),
    entry_points={
        'console_scripts': console_scripts(),
        'pytest11': [f'armsim = {PACKAGE}.testing.plugin'],
    },
)
