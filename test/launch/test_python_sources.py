# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Python of source packages: modules and console scripts, without a build."""

import os
from textwrap import dedent

import pytest

from armsim_ros.launch.lookup import python_sources
from armsim_ros.testing.program import Program

SETUP = """
from setuptools import find_packages, setup
package_name = 'other_name'
setup(name=package_name, version='0.1', packages=find_packages(exclude=['test']),
      data_files=[('share/' + package_name, ['package.xml'])],
      entry_points={'console_scripts': [
          'plain = other_name.program:main',
          f'formatted={package_name}.program:main',
          'added = ' + package_name + '.program:main',
      ]})
"""
CFG = """
[options]
packages = find:
[options.entry_points]
console_scripts =
    plain = other_name.program:main
    added = other_name.program:Class.main
[tool:pytest]
also = not.a:script
"""
TOML = """
[project]
name = "other_name"
[project.scripts]
plain = "other_name.program:main"
"in-quotes" = "other_name.program:main"
[tool.other]
also = "not.a:script"
"""


@pytest.fixture
def package(tmp_path):
    """Return a function that writes a package of sources."""
    def write(name, **files):
        folder = tmp_path / 'src' / name
        folder.mkdir(parents=True)
        (folder / 'package.xml').write_text(f'<package><name>{name}</name></package>')
        for path, text in files.items():
            file = folder / path.replace('__', '/').replace('_dot_', '.')
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return folder

    return write


@pytest.mark.parametrize(('file', 'text', 'expected'), [
    ('setup.py', SETUP, {'plain', 'formatted', 'added'}), ('setup.cfg', CFG, {'plain', 'added'}),
    ('pyproject.toml', TOML, {'plain', 'in-quotes'})])
def test_console_scripts(package, file, text, expected):
    """The programs of setup.py, setup.cfg and pyproject.toml are found, and nothing else."""
    folder = package('nodes')
    (folder / file).write_text(text)
    scripts = python_sources(folder).scripts
    assert set(scripts) == expected
    assert scripts['plain'] == 'other_name.program:main'


def test_modules_of_setup_py(package):
    """Packages beside setup.py and below src are modules, tests are not."""
    folder = package('nodes')
    (folder / 'setup.py').write_text(SETUP)
    for name in ('other_name', 'src/second', 'test', 'config'):
        (folder / name).mkdir(parents=True)
    for name in ('other_name', 'src/second', 'test'):
        (folder / name / '__init__.py').touch()
    assert python_sources(folder).modules == {
        'other_name': folder / 'other_name', 'second': folder / 'src/second'}


def test_modules_of_cmake(package):
    """ament_python_install_package names a module, wherever PACKAGE_DIR puts it."""
    folder = package('nodes')
    (folder / 'CMakeLists.txt').write_text(dedent("""
        project(tools)
        ament_python_install_package(${PROJECT_NAME})
        ament_python_install_package(helpers PACKAGE_DIR ${CMAKE_CURRENT_SOURCE_DIR}/python/help)
        ament_python_install_package(absent)
    """))
    for name in ('tools', 'python/help'):
        (folder / name).mkdir(parents=True)
    assert python_sources(folder).modules == {
        'tools': folder / 'tools', 'helpers': folder / 'python/help'}


LAUNCH = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node
from shared_code import NAME


def generate_launch_description():
    return LaunchDescription([
        Node(package='nodes', executable='plain', name=NAME),
        ExecuteProcess(cmd=['echo distro $ROS_DISTRO $ROS_VERSION; command -v xacro'], shell=True),
    ])
"""
PROGRAM = """
import sys

from shared_code import NAME


def main():
    print(NAME, *(word for word in sys.argv if '__node' in word))
    import absent_module.inner
"""


def test_nodes_and_launch_files_import_source_packages(package, tmp_path):
    """
    A console script starts, with a launch file and a program that import another package.

    The environment is not active, and no installation of ROS is sourced; what the program lacks is
    named in one line.
    """
    nodes = package('nodes')
    (nodes / 'setup.py').write_text(SETUP)
    (nodes / 'other_name').mkdir()
    (nodes / 'other_name' / '__init__.py').touch()
    (nodes / 'other_name' / 'program.py').write_text(PROGRAM)
    shared = package('shared_package')
    (shared / 'CMakeLists.txt').write_text('ament_python_install_package(shared_code)')
    (shared / 'shared_code').mkdir()
    (shared / 'shared_code' / '__init__.py').write_text("NAME = 'found'\n")
    (nodes / 'launch').mkdir()
    (nodes / 'launch' / 'it.launch.py').write_text(LAUNCH)
    environment = {name: value for name, value in os.environ.items()
                   if not name.startswith('ROS_')} | {'PATH': os.defpath}
    with Program.module('armsim_ros', 'launch', str(nodes / 'launch' / 'it.launch.py'),
                        environment=environment) as program:
        program.wait(60.0)
    lines = program.text.splitlines()
    assert '[plain-1] found __node:=found' in lines
    assert any(line.endswith('distro jazzy 2') for line in lines)
    assert any(line.endswith('/bin/xacro') for line in lines)
    assert any("Python module 'absent_module' is missing" in line for line in lines)


def test_a_console_script_comes_before_the_module_of_its_name(package):
    """
    A program whose module has its name may import relatively, as when it is installed.

    A module that its package has only for another Python is named with that.
    """
    nodes = package('nodes')
    (nodes / 'setup.py').write_text(SETUP.replace('other_name', 'nodes').replace(
        "'plain = nodes.program:main'", "'plain     = nodes.plain:main'"))
    (nodes / 'nodes').mkdir()
    (nodes / 'nodes' / '__init__.py').write_text("NAME = 'relative'\n")
    (nodes / 'nodes' / 'plain.py').write_text(
        'from . import NAME\n\n\ndef main():\n    print("ran", NAME)\n    import nodes.binary\n')
    (nodes / 'nodes' / 'binary.cpython-27.so').touch()
    file = nodes / 'it.launch.xml'
    file.write_text('<launch><node pkg="nodes" exec="plain" output="screen"/></launch>')
    with Program.module('armsim_ros', 'launch', str(file)) as program:
        program.wait(60.0)
    assert 'ran relative' in program.text
    assert (f"Python module 'nodes.binary' is missing in '{nodes / 'nodes'}' itself; it is there "
            'for other systems or versions of Python: binary.cpython-27.so') in program.text


def test_ros2_run_starts_a_program_of_a_source_package(package):
    """ExecuteProcess with ``ros2 run`` starts a console script that is not installed."""
    nodes = package('nodes')
    (nodes / 'setup.py').write_text(SETUP)
    (nodes / 'other_name').mkdir()
    (nodes / 'other_name' / '__init__.py').touch()
    (nodes / 'other_name' / 'program.py').write_text(
        'import sys\n\n\ndef main():\n    print("ran", sys.argv[1])\n')
    file = nodes / 'it.launch.xml'
    file.write_text('<launch><executable cmd="ros2 run nodes plain word" output="screen"/>'
                    '</launch>')
    with Program.module('armsim_ros', 'launch', str(file),
                        environment=os.environ | {'PATH': os.defpath}) as program:
        assert program.wait(60.0) == 0
    assert 'ran word' in program.text


def test_messages_that_are_not_built_are_named_with_the_remedy(package):
    """A program that imports messages of the workspace is answered with how to build them."""
    nodes = package('nodes')
    (nodes / 'scripts').mkdir()
    (nodes / 'scripts' / 'asks.py').write_text('from own_msgs.srv import Ask\n')
    own = package('own_msgs', srv__Ask_dot_srv='---\n')
    file = nodes / 'it.launch.xml'
    file.write_text('<launch><node pkg="nodes" exec="asks.py"/></launch>')
    with Program.module('armsim_ros', 'launch', str(file)) as program:
        program.wait(60.0)
    assert f"the messages of '{own}' are not built; link that folder" in program.text


def test_programs_of_sources_find_packages_in_the_ament_index(package):
    """
    A program finds its package's data as after a build, and so do programs of the launch file.

    What its build installs elsewhere is there, too; the environment names no installation.
    """
    nodes = package('nodes', config__a_dot_yaml='a: 1')
    (nodes / 'setup.py').write_text(SETUP.replace(
        "['package.xml'])]", "['package.xml']), ('share/other_name/settings', ['config/a.yaml'])]"
    ).replace('other_name', 'nodes'))
    (nodes / 'nodes').mkdir()
    (nodes / 'nodes' / '__init__.py').touch()
    (nodes / 'nodes' / 'program.py').write_text(dedent("""
        from pathlib import Path

        from ament_index_python.packages import get_package_share_directory

        def main():
            print(Path(get_package_share_directory('nodes'), 'settings', 'a.yaml').read_text())
            print(Path(get_package_share_directory('std_msgs'), 'package.xml').is_file())
        """))
    (nodes / 'arm.xacro').write_text(
        '<robot xmlns:xacro="http://ros.org/wiki/xacro" name="$(find nodes)"/>')
    file = nodes / 'it.launch.py'
    file.write_text(dedent("""
        import subprocess

        from launch import LaunchDescription
        from launch_ros.actions import Node

        def generate_launch_description():
            print(subprocess.check_output(['xacro', 'arm.xacro'], cwd=__file__.rpartition('/')[0],
                                          text=True))
            return LaunchDescription([Node(package='nodes', executable='plain')])
        """))
    environment = {name: value for name, value in os.environ.items()
                   if name != 'AMENT_PREFIX_PATH'}
    with Program.module('armsim_ros', 'launch', str(file), environment=environment) as program:
        assert program.wait(60.0) == 0
    assert 'share/nodes"/>' in program.text
    assert '[plain-1] a: 1' in program.text
    assert '[plain-1] True' in program.text
