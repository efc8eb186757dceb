# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The overlay for a ROS installation."""

import os
import subprocess

import pytest

from armsim_ros.launch import overlay


@pytest.fixture
def installation(tmp_path, monkeypatch):
    """Return a prefix with an original controller_manager, sourced."""
    prefix = tmp_path / 'ros'
    markers = prefix / 'share/ament_index/resource_index/packages'
    markers.mkdir(parents=True)
    (markers / 'controller_manager').touch()
    (prefix / 'share/controller_manager').mkdir()
    (prefix / 'share/controller_manager/package.xml').write_text('original')
    (prefix / 'lib/controller_manager').mkdir(parents=True)
    for name in ('spawner', 'other_program'):
        (prefix / 'lib/controller_manager' / name).write_text('original')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    return prefix


def test_it_has_our_programs_and_the_originals_files(installation, capsys):
    """P43: programs are ours, share and all other programs are the original's."""
    assert overlay.main([]) == 0
    folder = overlay.overlay_folder()
    assert capsys.readouterr().out.strip() == str(folder / 'setup.sh')
    package = folder / 'lib' / 'controller_manager'
    assert 'armsim_ros original spawner' in (package / 'spawner').read_text()
    assert (package / 'other_program').read_text() == 'original'
    share = folder / 'share' / 'controller_manager' / 'package.xml'
    assert share.read_text() == 'original'
    assert (folder / 'share/moveit_ros_move_group/package.xml').is_file()


def test_sourcing_puts_it_first(installation):
    """P43: the overlay comes before the installation; nothing else of the shell changes."""
    folder = overlay.write_overlay(overlay.overlay_folder())
    done = subprocess.run(['sh', '-c', f'. {folder}/setup.sh; echo $AMENT_PREFIX_PATH'],
                          capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f'{folder}{os.pathsep}{installation}'


def test_its_programs_start(installation):
    """A program of the overlay is ours, with this environment's Python."""
    folder = overlay.write_overlay(overlay.overlay_folder())
    done = subprocess.run([folder / 'lib/controller_manager/spawner', '--help'],
                          capture_output=True, text=True, check=False)
    assert 'usage: spawner' in done.stdout, done.stderr


def test_check_says_whose_each_program_is(installation, write, capsys):
    """P43: --check tells for each program of a launch file where it comes from."""
    path = write('<launch><node pkg="controller_manager" exec="spawner" args="a"/>'
                 '<node pkg="mine" exec="one"/><node pkg="no_one" exec="x"/></launch>',
                 'it.launch.xml')
    assert overlay.main(['--check', str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == 'controller_manager/spawner: ours'
    assert lines[1].endswith('scripts/one')
    assert lines[2] == 'no_one/x: not installed'
