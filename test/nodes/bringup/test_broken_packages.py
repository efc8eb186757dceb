# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A published package that cannot run is answered in a few lines that help."""

import shutil
import subprocess
import sys

import pytest

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.settings import cell_of
from armsim_ros.errors import ArmsimError

MOST_LINES = 5
NO_URDF = 'has no URDF that its files name; name it: urdf:=FILE'


def bringup(package, *words):
    """Return the status of bringup, and what it printed."""
    done = subprocess.run(
        [sys.executable, '-m', 'armsim_ros', 'bringup', f'robot:={package.folder}', *words],
        capture_output=True, text=True, check=False, timeout=120.0)
    return done.returncode, (done.stdout + done.stderr).splitlines()


def urdf(text):
    """Return what puts a text into the place of the robot's xacro."""
    return lambda package: package.write(
        'config/small.urdf.xacro', package.XACRO.format(f'\n{text}\n'))


def remove(*names):
    """Return what removes files."""
    return lambda package: package.remove(*names)


BROKEN = {
    'no description package': (
        lambda package: shutil.rmtree(package.description),
        ["small.urdf.xacro: package 'small_description' is not found; searched: ",
         'clone it into src/']),
    'no URDF': (remove('config/small.urdf.xacro'), [NO_URDF]),
    'no files': (remove('config/small.urdf.xacro', 'config/small.srdf',
                        'config/ros2_controllers.yaml', 'config/moveit_controllers.yaml'),
                 [NO_URDF]),
    'unknown macro': (urdf('<xacro:arm/>'), [
        'small.urdf.xacro:2: xacro: unknown macro name: xacro:arm; ', '<xacro:include> the file']),
    'undefined property': (urdf('<link name="${side}_arm"/>'), [
        "small.urdf.xacro:2: xacro: name 'side' is not defined", '<xacro:property>']),
    'missing argument': (urdf('<link name="$(arg side)_arm"/>'), [
        'small.urdf.xacro:2: xacro: Undefined substitution argument side', 'give side:=VALUE']),
    'no XML': (urdf('<link name="arm">'), ['small.urdf.xacro:', '<link> of line 2 is still open']),
    "another robot's SRDF": (
        lambda package: package.write('config/small.srdf', package.SRDF.replace(
            'joint name="', 'joint name="other_')),
        ['small.srdf:1:1: none of the planning groups arm fits', 'the SRDF of another robot']),
}


#: Those that are shown with the programs; what these print of an error is the same for all.
WITH_PROGRAMS = ('no description package', "another robot's SRDF")


@pytest.mark.parametrize('case', [case for case in BROKEN if case not in WITH_PROGRAMS])
def test_the_message_of_a_package_that_cannot_run_is_one_line(small_package, case):
    """Simulation and move_group, which read the package alike, print what is missing and where."""
    breaks, sentences = BROKEN[case]
    breaks(small_package)
    with pytest.raises(ArmsimError) as refused:
        cell_of(parse_arguments([f'robot:={small_package.folder}'], xacro=True))
    (line,) = str(refused.value).splitlines()
    for sentence in sentences:
        assert sentence in line


@pytest.mark.parametrize('case', WITH_PROGRAMS)
def test_a_package_that_cannot_run_is_answered_in_a_few_lines(small_package, case):
    """The status is 2, and at most five lines say what is missing, where, and what to do."""
    breaks, sentences = BROKEN[case]
    breaks(small_package)
    status, lines = bringup(small_package)
    assert status == 2
    assert len(lines) <= MOST_LINES
    assert 'Traceback' not in ' '.join(lines)
    for sentence in sentences:
        assert sentence in lines[-1]
