# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""check_config of a published package says whether bringup starts."""

import pytest

from armsim_ros.cli.arguments import argument_table, UsageError
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


@pytest.mark.parametrize('entry', argument_table(), ids=lambda entry: entry.name)
@pytest.mark.parametrize('form', ['{}:={}', '--{}={}'])
def test_every_argument_of_bringup_is_taken(small_package, capsys, entry, form):
    """A command line of bringup is checked as it is."""
    folder = small_package.folder
    values = {'robot': folder, 'config': folder / 'config', 'srdf': folder / 'config/small.srdf',
              'urdf': small_package.description / 'urdf/arm.urdf',
              'controllers': folder / 'config/ros2_controllers.yaml', 'packages_path': folder,
              'scene_from_world': 'fixed', 'world': 'empty', 'x': '1', 'y': '-1.5', 'z': '0.5',
              'initial_positions': '', 'overrides': '{simulation.gravity: [0, 0, 0]}',
              'mode': 'lockstep', 'seed': '3', 'record': folder / 'run.mcap', 'namespace': 'arm'}
    name = entry.name if ':=' in form else entry.name.replace('_', '-')
    words = [form.format(name, values.get(entry.name, 'false'))]
    if entry.name != 'robot':
        words.append(str(folder))
    assert main(words) < 2, capsys.readouterr().out
    assert 'result: ' in capsys.readouterr().out


def test_arguments_are_checked_as_bringup_checks_them(small_package, capsys):
    """A joint that is not there, a path that is no setting, a flag of another launch file."""
    folder = str(small_package.folder)
    assert main([folder, 'initial_positions:=joint_9=1']) == 2
    assert 'joint_9' in capsys.readouterr().out
    assert main([folder, 'overrides:={simulation.gravty: [0, 0, 0]}']) == 2
    assert 'gravty' in capsys.readouterr().out
    assert main([folder, 'use_rviz:=false']) < 2
    with pytest.raises(UsageError, match="'fast' is not a mode"):
        main([folder, 'mode:=fast'])
    with pytest.raises(UsageError, match="x is 'left'"):
        main([folder, 'x:=left'])


def test_a_urdf_alone_is_told_that_nothing_moves(small_package, tmp_path, capsys):
    """A folder or package with no other file runs; the warning names generate_config."""
    folder = tmp_path / 'alone'
    folder.mkdir()
    (folder / 'arm.urdf').write_text(small_package.XACRO.format(small_package.ARM))
    small_package.remove('config/small.srdf')
    for place in (folder, small_package.description):
        assert main([str(place)]) == 1
        text = capsys.readouterr().out
        assert 'nothing can be planned and nothing moves' in text
        assert 'arm.urdf --to DIR' in text
    (folder / 'arm.srdf').write_text(small_package.SRDF)
    main([str(folder)])
    assert 'nothing moves' not in capsys.readouterr().out
