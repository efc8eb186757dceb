# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""check_config of a published package says whether bringup starts."""

import pytest

from armsim_ros.tools.check_config.main import main


@pytest.fixture
def package(small_package):
    """Return the package with a key that the original stack does not read."""
    small_package.write('config/kinematics.yaml', 'arm: {kinematics_solver: a/B, drot: 1}\n')
    return small_package


def test_what_the_original_ignores_is_a_warning(package, capsys):
    """With --strict it is a mistake, at the same place."""
    assert main([str(package.folder)]) == 1
    usual = capsys.readouterr().out
    assert main([str(package.folder), '--strict']) == 2
    strict = capsys.readouterr().out
    assert "kinematics.yaml:1:31: kinematics of group 'arm': key 'drot'" in usual
    assert 'result: 1 error' in strict


def test_the_words_are_those_of_bringup(package, capsys):
    """robot:=, urdf:=, controllers:= and arguments of the xacro."""
    urdf = package.description / 'urdf/arm.urdf'
    words = [f'robot:={package.folder}', f'urdf:={urdf}',
             f"controllers:={package.folder / 'config/ros2_controllers.yaml'}"]
    assert main(words) == 1
    assert str(urdf) in capsys.readouterr().out
    assert main([*words, 'reach:=1']) == 2
    assert "no xacro of the robot declares the argument 'reach'" in capsys.readouterr().out


def test_a_package_without_an_srdf_is_told_that_nothing_can_be_planned(small_package, capsys):
    """It starts, and the warning says what to do."""
    small_package.remove('config/small.srdf')
    assert main([str(small_package.folder)]) == 1
    text = capsys.readouterr().out
    assert 'the package has no SRDF: nothing can be planned; name one: srdf:=FILE' in text
