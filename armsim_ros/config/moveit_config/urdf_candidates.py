# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a package that names no URDF may leave to its launch files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
import os
from pathlib import Path
import re

from armsim_ros.config.moveit_config.files import PackageFiles
from armsim_ros.install_rules.xacro_run import xacro_finding
from armsim_ros.packages import MANIFEST, package_name, Packages

#: So many descriptions are tried, and so many of each kind are named at most.
MOST_TRIED, MOST_NAMED = 40, 5
_ENDINGS = ('.urdf', '.urdf.xacro', '.xacro')
_FOLDERS = ('urdf', 'robots', 'robot', 'description', 'config', 'xacro', '.')
_PART = re.compile(r'_macro\b|ros2_control|gazebo|\.srdf')
_LAUNCH = ('.launch.py', '_launch.py', '.launch.xml', '.launch.yaml')
_NEEDED = re.compile(r'<(?:joint|link)\s[^>]*?name="([^"$]+)"')
_REFERRED = re.compile(r'\b(?:base_link|tip_link|link1|link2)="([^"$]+)"')
_GIVEN = re.compile(r'<(?:joint|link)\s[^>]*?name="([^"]+)"')
_STATES = re.compile(r'<group_state.*?</group_state>', re.DOTALL)


def urdf_remedy(files: PackageFiles) -> str:
    """Return what a user can do about a package without URDF."""
    lines = ['name it: urdf:=FILE, with the arguments that its xacro declares']
    fitting = list(_fitting(files))
    if fitting:
        lines.append('the workspace has for this SRDF: '
                     + ', '.join(f'urdf:={file}' for file in fitting[:MOST_NAMED]))
    launch_files = sorted((file.name for file in (files.folder / 'launch').glob('*')
                           if file.name.endswith(_LAUNCH)),
                          key=lambda name: (name.startswith('_'), name))
    if launch_files:
        name = package_name(files.folder) or files.folder.name
        named = ', '.join(launch_files[1:MOST_NAMED])
        lines.append(f'or run a launch file of the package: armsim launch {name} '
                     f'{launch_files[0]}' + (f' (also {named})' if named else ''))
    return '; '.join(lines)


def _fitting(files: PackageFiles) -> Iterator[Path]:
    """Yield the descriptions of the workspace that have all joints and links of the SRDF."""
    srdf = files.srdf()
    text = _STATES.sub('', _text(srdf, files.packages)) if srdf is not None else ''
    needed = {*_NEEDED.findall(text), *_REFERRED.findall(text)}
    if not needed:
        return
    for number, file in enumerate(_descriptions(files)):
        if number == MOST_TRIED:
            return
        if needed <= set(_GIVEN.findall(_text(file, files.packages))):
            yield file


def _descriptions(files: PackageFiles) -> Iterator[Path]:
    home = (files.folder / MANIFEST).resolve()
    packages = files.packages.names().values()
    for package in sorted(packages, key=lambda place: -len(os.path.commonpath((home, place)))):
        for folder in _FOLDERS:
            yield from (file for file in sorted((package / folder).glob('*'))
                        if file.name.endswith(_ENDINGS) and not _PART.search(file.name))


def _text(file: Path, packages: Packages) -> str:
    """Return a description, after xacro; '' where it cannot be read without arguments."""
    if file.suffix != '.xacro':
        try:
            return file.read_text(encoding='utf-8', errors='replace')
        except OSError:
            return ''
    with xacro_finding(packages.folder) as xacro, redirect_stderr(StringIO()):
        try:
            return str(xacro.process_file(str(file), mappings={}, verbosity=0).toxml())
        except Exception:  # noqa: BLE001 - any error of the expressions in the file
            return ''
