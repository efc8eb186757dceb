# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robots that are found."""

from armsim_ros.resources import robot_names
from armsim_ros.tools.robots import list_robots


def test_ours_and_those_of_the_workspace(small_package, capsys, monkeypatch):
    """Each with the word that starts it; packages without an SRDF are no robots."""
    monkeypatch.chdir(small_package.src)
    assert list_robots([]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = [line.split()[0] for line in lines]
    assert set(robot_names()) < set(names)
    assert 'small_description' not in names
    assert [line.split()[1] for line in lines if line.startswith('small_moveit_config')] == [
        str(small_package.folder)]


def test_a_folder_may_be_named(small_package, capsys):
    """Packages of a folder that is no workspace are listed, too."""
    assert list_robots([f'packages_path:={small_package.src}']) == 0
    assert 'small_moveit_config' in capsys.readouterr().out
