# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Packages of sources with the files of their build."""

import pytest

from armsim_ros.packages import Packages


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return a function that writes a package of sources; the cache is below tmp_path."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    monkeypatch.chdir(tmp_path)

    def write(name='arm_description', **files):
        folder = tmp_path / 'ws' / 'src' / name
        folder.mkdir(parents=True)
        (folder / 'package.xml').write_text(f'<package><name>{name}</name></package>')
        for path, text in files.items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return folder

    return write


@pytest.fixture
def share(tmp_path):
    """Return a function that gives the folder of a package as installed."""
    return lambda name='arm_description': Packages([tmp_path / 'ws']).folder(name)
