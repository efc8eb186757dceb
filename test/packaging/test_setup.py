# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What colcon and pip get from the one setup.py."""

import os
from pathlib import Path
from runpy import run_path
import shutil
import sys

import pytest
import setuptools

from armsim_ros.cli import main as door
from armsim_ros.cli.programs import PROGRAMS

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture
def setup_arguments(tmp_path, monkeypatch):
    """Return a function that gives setup()'s arguments for a command line, in a small tree."""
    (tmp_path / 'armsim_ros/cli').mkdir(parents=True)
    for name in ('setup.py', 'package.xml', 'armsim_ros/cli/programs.py'):
        shutil.copy(ROOT / name, tmp_path / name)
    for name in ('config/gantry/deep/a.yaml', 'config/gantry/.hidden', 'urdf/a.urdf'):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)

    def get(*words):
        given = {}
        monkeypatch.setattr(setuptools, 'setup', lambda **arguments: given.update(arguments))
        monkeypatch.setattr(sys, 'argv', ['setup.py', *words])
        run_path('setup.py')
        return given

    return get


@pytest.mark.parametrize('words', [('install',), ('develop', '--editable'), ('--dry-run',)])
def test_colcon_gets_the_programs_as_console_scripts(words, setup_arguments):
    """setup.cfg sends them to lib/armsim_ros; a file of the same name would collide."""
    arguments = setup_arguments(*words)
    scripts = arguments['entry_points']['console_scripts']
    assert [line.split(' = ')[0] for line in scripts] == list(PROGRAMS)
    assert not any(target.startswith('lib/') for target, _ in arguments['data_files'])


def test_every_console_script_is_a_function_of_the_command_line(setup_arguments):
    """What the scripts import exists."""
    for line in setup_arguments('install')['entry_points']['console_scripts']:
        module, _, function = line.split(' = ')[1].partition(':')
        assert module == door.__name__
        assert callable(getattr(door, function))


def test_a_wheel_has_one_command_and_the_programs_as_files(setup_arguments):
    """Nothing but armsim goes to bin; ros2 run finds executable files in lib/armsim_ros."""
    arguments = setup_arguments('bdist_wheel')
    assert arguments['entry_points']['console_scripts'] == ['armsim = armsim_ros.cli.main:main']
    files = dict(arguments['data_files'])['lib/armsim_ros']
    assert [Path(file).name for file in files] == list(PROGRAMS)
    assert all(os.access(file, os.X_OK) for file in files)


def test_shared_files_keep_their_folders(setup_arguments):
    """share/armsim_ros mirrors the source tree, without hidden files."""
    files = dict(setup_arguments('install')['data_files'])
    assert files['share/armsim_ros/config/gantry/deep'] == ['config/gantry/deep/a.yaml']
    assert files['share/armsim_ros/urdf'] == ['urdf/a.urdf']
    assert 'share/armsim_ros/config/gantry' not in files
    assert files['share/ament_index/resource_index/packages'] == ['resource/armsim_ros']
