# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 run``, ``ros2 launch``, and handing over to a real ros2."""

import os
from pathlib import Path
import subprocess
import sys

import pytest

SOURCES = Path(__file__).parent.parent.parent / 'ros2'


def write_program(path, text):
    """Write an executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'#!/bin/sh\n{text}\n')
    path.chmod(0o755)


@pytest.fixture
def prefix(tmp_path):
    """Return an installation with one package and one program."""
    index = tmp_path / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    (index / 'parts').touch()
    write_program(tmp_path / 'lib/parts/count', 'echo "counted $*"; exit 5')
    (tmp_path / 'lib/parts/readme.txt').touch()
    return tmp_path


@pytest.fixture
def ros2(prefix):
    """Return a function that runs the command and gives what it printed and its status."""
    def run(*words, path='/usr/bin:/bin'):
        return subprocess.run(
            [sys.executable, '-m', 'armsim_ros2', *words], capture_output=True, text=True,
            check=False, env={**os.environ, 'AMENT_PREFIX_PATH': str(prefix), 'PATH': path,
                              'PYTHONPATH': str(SOURCES)})

    return run


def test_a_program_is_run_with_its_arguments_and_status(ros2):
    """Ros2 run becomes the program."""
    done = ros2('run', 'parts', 'count', 'a', '--ros-args', '-p', 'b:=c d')
    assert (done.stdout, done.returncode) == ('counted a --ros-args -p b:=c d\n', 5)


def test_the_help_of_a_package_lists_its_programs(ros2):
    """--help after the package is not taken for the name of a program."""
    done = ros2('run', 'parts', '--help')
    assert (done.returncode, done.stderr) == (0, '')
    assert 'ros2 run parts count' in done.stdout


def test_what_is_not_installed_is_passed_to_armsim(ros2):
    """Upstream's programs that armsim_ros has in their place are run, with their words."""
    done = ros2('run', 'controller_manager', 'spawner', '--help')
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith('usage: spawner NAME...')


def test_a_prefix_command_goes_before(ros2):
    """--prefix puts a debugger or nice in front (ros2run/command/run.py)."""
    done = ros2('run', '--prefix', 'env X=1 sh', 'parts', 'count', 'a')
    assert done.stdout == 'counted a\n'


@pytest.mark.parametrize(('words', 'text', 'status'), [
    (['run', 'prats', 'count'], "Package 'prats' not found; did you mean 'parts'?", 1),
    (['run', 'parts', 'cuont'], "No executable found: package 'parts' has no program 'cuont'; "
                                "did you mean 'count'? (it has: count)", 1),
    (['run', 'parts'], 'the following arguments are required: program', 2),
    (['run', '--perfix', 'x', 'parts', 'count'], 'unrecognized arguments: --perfix', 2),
])
def test_what_cannot_be_run_is_explained(words, text, status, ros2):
    """Words and status of ros2run, and the most similar name."""
    done = ros2(*words)
    assert text in done.stderr
    assert done.returncode == status
    assert 'Traceback' not in done.stderr


def test_launch_runs_a_launch_file(ros2, tmp_path):
    """Ros2 launch is armsim launch."""
    file = tmp_path / 'count.launch.xml'
    file.write_text('<launch><arg name="who"/><node pkg="parts" exec="count" name="$(var who)"/>'
                    '</launch>')
    done = ros2('launch', str(file), 'who:=anna', '-n')
    assert done.stdout == 'process: parts/count name=anna ns=/ parameters=\n', done.stderr
    assert done.returncode == 0


def test_the_real_ros2_takes_over(ros2, tmp_path, prefix):
    """A ros2 further down PATH gets every command and finds this environment's packages."""
    write_program(tmp_path / 'real/ros2', 'echo "real $* $AMENT_PREFIX_PATH"')
    done = ros2('topic', 'list', path=f'/usr/bin:/bin:{tmp_path}/real')
    assert done.stdout == f'real topic list {prefix}:{sys.prefix}\n'


def test_another_environments_ros2_is_not_the_real_one(ros2, tmp_path):
    """Two copies never hand over to each other."""
    write_program(tmp_path / 'other/ros2', 'from armsim_ros2.main import main')
    done = ros2('run', 'parts', 'count', path=f'{tmp_path}/other:/usr/bin:/bin')
    assert done.returncode == 5
