# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A path that only an installation has is found without a build."""

from pathlib import Path

import pytest

from armsim_ros.errors import ResourceError
from armsim_ros.model.description.xacro_text import read_description
from armsim_ros.packages import Packages

CMAKE = 'cmake_minimum_required(VERSION 3.8)\nproject(arm_description)\n'
TO_SHARE = 'DESTINATION share/${PROJECT_NAME}'
XACRO = ('<robot name="arm" xmlns:xacro="http://wiki.ros.org/xacro"><xacro:arg name="n" '
         'default="one"/><link name="$(arg n)"/></robot>')


@pytest.mark.parametrize('rules', [
    f'install(DIRECTORY launch urdf {TO_SHARE})',
    f'install(DIRECTORY urdf/ {TO_SHARE}/urdf)\ninstall(FILES package.xml {TO_SHARE})',
    f'install(DIRECTORY absent/ {TO_SHARE}/urdf)',
    'install(TARGETS node DESTINATION lib/${PROJECT_NAME})',
    'find_package(ament_cmake REQUIRED', ''])
def test_rules_that_move_nothing_leave_the_sources(package, share, rules, tmp_path):
    """The share folder of most packages is that of their sources, and nothing is written."""
    folder = package(**{'CMakeLists.txt': CMAKE + rules, 'urdf/arm.urdf': 'a', 'launch/a.py': ''})
    assert share() == folder
    assert not (tmp_path / 'cache').exists()


@pytest.mark.parametrize(('rules', 'path'), [
    (f'install(DIRECTORY robots/ {TO_SHARE}/urdf)', 'urdf/arm.urdf'),
    (f'install(DIRECTORY robots/ {TO_SHARE})', 'arm.urdf'),
    (f'install(FILES robots/arm.urdf {TO_SHARE}/urdf/ RENAME robot.urdf)', 'urdf/robot.urdf'),
    (f'install(PROGRAMS robots/arm.urdf {TO_SHARE})', 'arm.urdf'),
    ('set(place share/${PROJECT_NAME}/config)\nforeach(each arm other)\n'
     '  install(FILES "robots/${each}.urdf" DESTINATION ${place}) # of each\nendforeach()',
     'config/arm.urdf'),
    (f'file(GLOB all robots/*.urdf)\nforeach(one IN LISTS all)\n  get_filename_component(n '
     f'${{one}} NAME_WE)\n  install(FILES ${{one}} {TO_SHARE} RENAME ${{n}}_robot.urdf)\n'
     'endforeach()', 'arm_robot.urdf'),
    (f'function(put name)\n  install(FILES ${{ARGN}} {TO_SHARE}/${{name}})\nendfunction()\n'
     'put(models robots/arm.urdf)', 'models/arm.urdf'),
    (f'if(NOT EXISTS ${{CMAKE_CURRENT_SOURCE_DIR}}/x)\n  set(d one)\nelse()\n  set(d two)\n'
     f'endif()\ninstall(DIRECTORY robots {TO_SHARE}/${{d}})', 'one/robots/arm.urdf'),
    (f'install(DIRECTORY ../shared/robots {TO_SHARE}/urdf\n  PATTERN "*.urdf")',
     'urdf/robots/second.urdf'),
    (f'if(EXISTS ${{CMAKE_CURRENT_SOURCE_DIR}}/robots)\n  set(d one)\nelse()\n  set(d two)\n'
     f'endif()\ninstall(DIRECTORY robots {TO_SHARE}/${{d}})', 'one/robots/arm.urdf'),
    (f'if(IS_DIRECTORY ${{CMAKE_CURRENT_SOURCE_DIR}}/x OR NOT DEFINED PROJECT_NAME)\n'
     f'  set(d one)\nelse()\n  set(d two)\nendif()\ninstall(DIRECTORY robots {TO_SHARE}/${{d}})',
     'two/robots/arm.urdf'),
    (f'string(REPLACE _ - name a_b_c)\ninstall(DIRECTORY robots/ {TO_SHARE}/${{name}})',
     'a-b-c/arm.urdf'),
    ('string(REGEX MATCH "[0-9]+" name arm12b)\n'
     f'install(DIRECTORY robots/ {TO_SHARE}/${{name}})', '12/arm.urdf'),
    ('string(REGEX REPLACE "([a-z]+)[0-9]" "\\\\1" name arm1)\n'
     f'install(DIRECTORY robots/ {TO_SHARE}/${{name}})', 'arm/arm.urdf'),
    ('string(TOUPPER arm name)\nstring(TOLOWER ${name} small)\n'
     f'install(DIRECTORY robots/ {TO_SHARE}/${{name}}/${{small}})', 'ARM/arm/arm.urdf'),
    ('install(FILES robots/arm.urdf DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/a)',
     'a/arm.urdf'),
    (f'install(DIRECTORY robots/ urdf_more/ {TO_SHARE}/both)', 'both/more.urdf'),
])
def test_cmake_rules(package, share, tmp_path, rules, path):
    """What install(DIRECTORY) and install(FILES RENAME) move is found at its new path."""
    folder = package(**{'CMakeLists.txt': CMAKE + rules, 'robots/arm.urdf': 'the arm',
                        'urdf_more/more.urdf': 'the arm', 'launch/a.launch.py': ''})
    shared = tmp_path / 'ws/src/shared/robots'
    shared.mkdir(parents=True)
    (shared / 'second.urdf').write_text('the arm')
    assert (share() / path).read_text() == 'the arm'
    assert (share() / 'launch/a.launch.py').samefile(folder / 'launch/a.launch.py')
    assert not (folder / path).exists()


def test_moved_files_join_a_folder_of_the_sources(package, share):
    """A folder holds what the sources have in it, and beside it what rules put there."""
    package(**{
        'CMakeLists.txt': f'{CMAKE}install(DIRECTORY urdf robots/urdf {TO_SHARE})',
        'urdf/arm.urdf': 'a', 'urdf/both.urdf': 'of urdf', 'robots/urdf/both.urdf': 'of robots',
        'robots/urdf/deep/other.urdf': 'o'})
    assert sorted(one.name for one in (share() / 'urdf').iterdir()) == [
        'arm.urdf', 'both.urdf', 'deep']
    assert (share() / 'urdf/both.urdf').read_text() == 'of urdf'
    assert (share() / 'urdf/deep/other.urdf').read_text() == 'o'


BINARY = '${CMAKE_CURRENT_BINARY_DIR}/arm.urdf'
SOURCE = '${CMAKE_CURRENT_SOURCE_DIR}/robots/arm.urdf.xacro'


@pytest.mark.parametrize(('rules', 'path', 'link'), [
    ('xacro_add_files(robots/arm.urdf.xacro INSTALL DESTINATION urdf)', 'urdf/arm.urdf', 'one'),
    ('set(all a b)\nforeach(m IN LISTS all)\n  xacro_add_files(TARGET ${m} robots/arm.urdf.xacro '
     'REMAP n:=${m} OUTPUT ${m}.urdf INSTALL DESTINATION urdf)\nendforeach()', 'urdf/b.urdf',
     'b'),
    ('xacro_add_xacro_file(robots/arm.urdf.xacro made.urdf REMAP n:=two)\n'
     'xacro_install(all ${XACRO_OUTPUT_FILE} DESTINATION models)', 'models/made.urdf', 'two'),
    (f'add_custom_command(OUTPUT {BINARY} COMMAND xacro {SOURCE} -o {BINARY} n:=two\n'
     f'  DEPENDS {SOURCE})\ninstall(FILES {BINARY} {TO_SHARE}/urdf)', 'urdf/arm.urdf', 'two'),
    (f'add_custom_command(OUTPUT {BINARY}\n  COMMAND ${{PYTHON_EXECUTABLE}} "/opt/bin/xacro" '
     f'"{SOURCE}" ">" "{BINARY}")\ninstall(FILES {BINARY} {TO_SHARE} RENAME x.urdf)', 'x.urdf',
     'one'),
    ('execute_process(COMMAND xacro arm.urdf.xacro OUTPUT_FILE made/arm.urdf WORKING_DIRECTORY '
     f'${{PROJECT_SOURCE_DIR}}/robots)\ninstall(DIRECTORY robots/made {TO_SHARE})',
     'made/arm.urdf', 'one'),
    (f'add_custom_target(all_urdf ALL COMMAND ros2 run xacro xacro {SOURCE} '
     f'-o ${{CMAKE_CURRENT_SOURCE_DIR}}/urdf/arm.urdf)\ninstall(DIRECTORY urdf {TO_SHARE})',
     'urdf/arm.urdf', 'one'),
])
def test_files_that_the_build_makes_with_xacro(package, share, rules, path, link):
    """A URDF that only a build has is made, with the arguments of the rule."""
    package(**{'CMakeLists.txt': CMAKE + rules, 'robots/arm.urdf.xacro': XACRO,
               'urdf/other.urdf': ''})
    assert f'<link name="{link}"/>' in (share() / path).read_text()


def test_xacro_that_needs_a_made_file_of_another_package(package, tmp_path):
    """Xacro runs for one package while it runs for another."""
    package(**{'CMakeLists.txt': f'{CMAKE}xacro_add_files(part.xacro INSTALL DESTINATION urdf)',
               'part.xacro': '<robot xmlns:xacro="http://wiki.ros.org/xacro">'
                             '<link name="made"/></robot>'})
    robot = package('arm', **{'robot.xacro': (
        '<robot name="arm" xmlns:xacro="http://wiki.ros.org/xacro"><xacro:arg name="n" '
        'default="x"/><xacro:include filename="$(find arm_description)/urdf/part"/>'
        '<xacro:include filename="beside.xacro"/><link name="$(arg n)"/></robot>'),
        'beside.xacro': '<robot><link name="beside"/></robot>'})
    text = read_description(robot / 'robot.xacro', packages=Packages([tmp_path / 'ws']),
                            mappings={'n': 'given'})
    assert [name in text for name in ('"made"', '"beside"', '"given"')] == [True] * 3


def test_xacro_that_fails_leaves_the_rest(package, share, caplog):
    """A file that cannot be made is named once; all others of the package are there."""
    package(**{'CMakeLists.txt': f'{CMAKE}xacro_add_files(a.urdf.xacro INSTALL DESTINATION urdf)\n'
               f'install(DIRECTORY models/ {TO_SHARE}/urdf)',
               'a.urdf.xacro': XACRO.replace('arg n', 'arg absent'), 'models/b.urdf': 'b'})
    assert (share() / 'urdf/b.urdf').read_text() == 'b'
    assert not (share() / 'urdf/a.urdf').exists()
    assert "a.urdf.xacro: the build makes 'a.urdf' of this file, but xacro fails" in caplog.text


SETUP = """
import os
from glob import glob
from setuptools import setup

package_name = 'arm_description'
data_files = [(f'share/{package_name}', ['package.xml']), ('share/' + package_name, unknown())]
data_files.append(('share/' + package_name + '/late', ['robots/arm.urdf']))
setup(
    name=package_name,
    data_files=data_files + [
        (os.path.join('share', package_name, 'urdf'), glob('robots/*.urdf')),
        (os.path.join('share', package_name), glob(os.path.join('launch', '**', '*.launch.py'),
                                                   recursive=True)),
        *listed('config'),
    ],
)
"""


@pytest.mark.parametrize('path', ['urdf/arm.urdf', 'late/arm.urdf', 'a.launch.py'])
def test_data_files_of_setup_py(package, share, path):
    """Files that data_files put elsewhere are found there; setup.py is not run."""
    package(**{'setup.py': SETUP, 'robots/arm.urdf': 'the arm', 'launch/x/a.launch.py': 'the arm'})
    assert (share() / path).read_text() == 'the arm'


def test_a_view_is_kept_and_found_again(package, share, tmp_path):
    """Two runs use one view; new sources give a new view, and its packages are the workspace's."""
    folder = package(**{'CMakeLists.txt': f'{CMAKE}install(DIRECTORY robots/ {TO_SHARE}/urdf)',
                        'robots/arm.urdf': 'a', 'urdf/x': ''})
    other = package('other')
    first = share()
    assert share() == first != folder
    assert Packages(near=[first / 'urdf/arm.urdf']).folder('other').samefile(other)
    assert Packages([first]).folder('arm_description') == first
    (folder / 'robots/second.urdf').write_text('b')
    assert (share() / 'urdf/second.urdf').read_text() == 'b'
    assert not [one for one in (tmp_path / 'cache/armsim_ros/packages').iterdir()
                if one.name.startswith('new-')]


def test_a_cache_that_cannot_be_written_is_named(package, share, tmp_path):
    """The message names the folder and what to do."""
    package(**{'CMakeLists.txt': f'{CMAKE}install(DIRECTORY robots/ {TO_SHARE}/urdf)',
               'robots/arm.urdf': 'a'})
    Path(tmp_path / 'cache').write_text('a file')
    with pytest.raises(ResourceError, match='set XDG_CACHE_HOME'):
        share()


def test_rules_of_a_folder_that_is_added(package, share):
    """Its paths are relative to it, and its variables end with it; an absent folder has none."""
    folder = package(**{
        'CMakeLists.txt': CMAKE + 'set(to share/${PROJECT_NAME})\nadd_subdirectory(examples/a)\n'
        'add_subdirectory(absent)\ninstall(DIRECTORY robots/ DESTINATION ${to}/urdf)',
        'examples/a/CMakeLists.txt': 'set(to nowhere)\n'
        f'install(DIRECTORY config {TO_SHARE})\ninstall(FILES '
        f'${{CMAKE_CURRENT_SOURCE_DIR}}/a.launch.py {TO_SHARE}/launch)',
        'examples/a/config/a.yaml': 'a', 'examples/a/a.launch.py': '', 'robots/arm.urdf': ''})
    found = share()
    assert (found / 'config/a.yaml').samefile(folder / 'examples/a/config/a.yaml')
    assert (found / 'launch/a.launch.py').is_file()
    assert (found / 'urdf/arm.urdf').is_file()
