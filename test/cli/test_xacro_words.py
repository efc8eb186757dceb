# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Words for the robot's xacro on the command line of bringup."""

import pytest

from armsim_ros.cli.arguments import parse_arguments, UsageError
from armsim_ros.cli.main import start_program
from armsim_ros.cli.settings import cell_of

REACH = ('<xacro:arg name="reach" default="0.2"/>'
         '<xacro:include filename="$(find small_description)/urdf/arm.urdf"/>'
         '<link name="tip_$(arg reach)"/><joint name="tip" type="fixed"><parent link="lower"/>'
         '<child link="tip_$(arg reach)"/></joint>')


@pytest.fixture
def reaching(small_package):
    """Return the package with a xacro that declares an argument."""
    small_package.write('config/small.urdf.xacro', small_package.XACRO.format(REACH))
    return small_package


def cell(package, *words):
    """Read a robot as bringup does."""
    return cell_of(parse_arguments([f'robot:={package.folder}', *words], xacro=True))[0]


def test_a_declared_word_reaches_the_xacro(reaching):
    """It is no argument of bringup, so it is the robot's."""
    assert 'tip_0.7' in cell(reaching, 'reach:=0.7').model.links
    assert 'tip_0.2' in cell(reaching).model.links


MODE = '<xacro:arg name="mode" default="mock"/><link name="tip_$(arg mode)"/>' + (
    '<joint name="tip" type="fixed"><parent link="lower"/><child link="tip_$(arg mode)"/></joint>')


def test_an_argument_that_is_called_as_one_of_bringups(small_package):
    """With ``xacro:`` before its name it is the xacro's, and the program's keeps its meaning."""
    small_package.write('config/small.urdf.xacro', small_package.XACRO.format(
        '<xacro:include filename="$(find small_description)/urdf/arm.urdf"/>' + MODE))
    words = [f'robot:={small_package.folder}', 'xacro:mode:=real']
    arguments = parse_arguments(words, xacro=True)
    assert arguments.mode == 'realtime'
    assert parse_arguments(arguments.to_argv(), xacro=True) == arguments
    assert 'tip_real' in cell_of(arguments)[0].model.links


def test_a_shadowed_argument_is_told(small_package):
    """Where both have an argument, a warning names the form that sets the xacro's."""
    small_package.write('config/small.urdf.xacro', small_package.XACRO.format(
        '<xacro:include filename="$(find small_description)/urdf/arm.urdf"/>' + MODE))
    words = [f'robot:={small_package.folder}', 'mode:=lockstep']
    warnings = cell_of(parse_arguments(words, xacro=True))[1]
    assert any('set by xacro:mode:=VALUE' in line for line in warnings)
    with pytest.raises(UsageError, match='xacro:mode:=mock'):
        cell(small_package, 'mode:=mock')


def test_the_words_go_on_to_the_programs(reaching):
    """Simulation and move_group read the same robot as bringup."""
    words = [f'robot:={reaching.folder}', 'reach:=0.7', 'packages_path:=/a']
    arguments = parse_arguments(words, xacro=True)
    assert parse_arguments(arguments.to_argv(), xacro=True) == arguments


def test_an_undeclared_word_is_answered_with_those_declared(reaching):
    """A usage error, as for any wrong argument."""
    with pytest.raises(UsageError, match=r"'rech:=1'; did you mean 'reach'"):
        cell(reaching, 'rech:=1')
    with pytest.raises(UsageError, match=r"the robot's xacro declares: reach"):
        cell(reaching, 'qqq:=1')


def test_help_lists_the_words_of_a_robot(reaching, capsys):
    """With their defaults, after those of the program."""
    assert start_program('bringup', [f'robot:={reaching.folder}', '--help']) == 0
    assert "reach:=  (default: '0.2')" in capsys.readouterr().out


def test_help_of_a_robot_that_is_not_there(capsys, tmp_path):
    """The mistake is told after the help."""
    assert start_program('bringup', [f'robot:={tmp_path / "lost"}', '--help']) == 2
    assert 'no such path or package' in capsys.readouterr().err
