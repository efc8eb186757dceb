# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Copies of robots."""

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import ArmsimError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.resources import cell_names, robot_names
from armsim_ros.tools.robots import copy


@pytest.mark.parametrize('robot', [*robot_names(), *cell_names()])
def test_a_copy_is_the_same_robot(robot, tmp_path, capsys):
    """Each included robot can be started from its copy, and the copy has its own URDF."""
    target = tmp_path / 'my robot'
    assert copy([robot, str(target)]) == 0
    assert f"armsim bringup 'robot:={target}'" in capsys.readouterr().out
    copied, original = load_cell(str(target)), load_cell(robot)
    assert [each.model.joints.keys() for each in copied.robots] == [
        each.model.joints.keys() for each in original.robots]
    if robot in robot_names():
        assert load_robot_settings(str(target)).urdf_file.parent == target


def test_a_folder_that_exists_is_left_as_it_is(tmp_path):
    """Nothing is overwritten."""
    with pytest.raises(ArmsimError, match='exists and is left as it is'):
        copy(['sunday', str(tmp_path)])
    assert not list(tmp_path.iterdir())


def test_a_package_is_not_copied_in_parts(small_package, tmp_path):
    """Its files refer to each other by the names of packages."""
    with pytest.raises(ArmsimError, match='as a whole into a workspace'):
        copy([str(small_package.folder), str(tmp_path / 'copy')])
