# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a ROS installation is sourced, its own packages are imported."""

import os
from pathlib import Path
import subprocess
import sys

import pytest

PROJECT = Path(__file__).parents[2] / 'helpers/pyproject.toml'
PACKAGES = sorted(path.parent.name for path in PROJECT.parent.glob('*/__init__.py'))


@pytest.fixture
def sourced(tmp_path):
    """Return the environment of a shell in which ROS is sourced."""
    site = tmp_path / 'lib/python/site-packages'
    for package in PACKAGES:
        (site / package).mkdir(parents=True)
        (site / package / '__init__.py').write_text('ORIGINAL = True\n')
    return {**os.environ, 'PYTHONPATH': str(site)}


@pytest.mark.parametrize('package', PACKAGES)
def test_the_original_comes_first(package, sourced):
    """PYTHONPATH is before the packages of the environment."""
    subprocess.run([sys.executable, '-c', f'import {package}; assert {package}.ORIGINAL'],
                   env=sourced, check=True)


def test_all_packages_are_in_the_distribution():
    """Each folder is listed; workspaces ignore them all."""
    listed = PROJECT.read_text().partition('packages = [')[2].partition(']')[0]
    assert [line.strip(" ,'") for line in listed.split()] == PACKAGES
    assert (PROJECT.parent / 'COLCON_IGNORE').is_file()
