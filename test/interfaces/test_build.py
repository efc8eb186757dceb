# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the build takes, in which order, and what it says where something is missing."""

import os
from pathlib import Path
import sys

from build_support import build, compiler
from build_support.errors import BuildError
from build_support.packages import IMPLICIT_DEPENDENCIES, providing_prefix, read_packages, select
import pytest

PYTHON = f'python{sys.version_info.major}.{sys.version_info.minor}'


@pytest.fixture
def packages(source):
    """Return the packages of the source tree."""
    return read_packages(source)


@pytest.fixture
def make_prefix(tmp_path):
    """Return a function that makes what looks like a ROS installation with some packages."""

    def make(*names, python=PYTHON):
        for name in names:
            marker = tmp_path / 'share/ament_index/resource_index/packages' / name
            module = tmp_path / 'lib' / python / 'site-packages' / name / '__init__.py'
            for path in (marker, module):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
        return tmp_path, {'AMENT_PREFIX_PATH': os.pathsep.join(['', '/nowhere', str(tmp_path)])}

    return make


def names_of(packages):
    """Return the names of packages."""
    return [package.name for package in packages]


def test_order(packages):
    """A package comes after those that its definitions use."""
    names = names_of(packages)
    assert len(names) == 16
    assert names.index('moveit_task_constructor_msgs') > names.index('moveit_msgs')
    assert names.index('moveit_msgs') > names.index('octomap_msgs')
    assert names.index('moveit_msgs') > names.index('object_recognition_msgs')


@pytest.fixture
def write_package(tmp_path):
    """Return a function that writes a package with one message."""

    def write(name, message, manifest='<package/>'):
        (tmp_path / name / 'msg').mkdir(parents=True)
        (tmp_path / name / 'package.xml').write_text(manifest)
        (tmp_path / name / 'msg' / 'One.msg').write_text(message)
        return tmp_path

    return write


@pytest.mark.parametrize('manifest', [
    '<package><build_depend>b_msgs</build_depend><exec_depend>b_msgs</exec_depend></package>',
    '<package><!-- <depend>c_msgs</depend> --></package>'])
def test_dependencies_are_what_definitions_name(write_package, manifest):
    """
    Whatever tags a manifest has, and in comments; neither comments nor constants are types.

    Upstream: rosidl_cmake/cmake/rosidl_generate_interfaces.cmake, which takes DEPENDENCIES.
    """
    write_package('a_msgs', '# c_msgs/One of old\nb_msgs/One[<=3] ones  # d_msgs/One\n'
                  'string NAME="x"\n  std_msgs/Header header\na_msgs/One[] more\n', manifest)
    top = write_package('b_msgs', 'float64 x\n')
    b_msgs, a_msgs = read_packages(top)
    assert names_of([b_msgs, a_msgs]) == ['b_msgs', 'a_msgs']
    assert set(a_msgs.dependencies) - set(b_msgs.dependencies) == {'b_msgs', 'std_msgs'}


def test_an_unknown_package_is_named_with_the_file(write_package, tmp_path):
    """The author sees which definition needs it, not a generator's traceback."""
    (package,) = read_packages(write_package('a_msgs', 'c_msgs/One one\n'))
    for name in IMPLICIT_DEPENDENCIES:
        (tmp_path / 'prefix' / 'share' / name).mkdir(parents=True)
    with pytest.raises(BuildError, match=r'a_msgs needs c_msgs \(msg/One\.msg\), neither'):
        build.generate(package, [package], tmp_path / 'prefix', {}, tmp_path / 'work', [])


def test_everything_without_ros(packages):
    """Without a ROS installation all packages are built."""
    assert select(packages, {}) == (packages, {})


def test_ros_is_not_shadowed(packages, make_prefix):
    """A package that a sourced ROS provides is left out."""
    prefix, environ = make_prefix('control_msgs', 'tf2_msgs')
    chosen, provided = select(packages, environ)
    assert provided == {'control_msgs': prefix, 'tf2_msgs': prefix}
    assert len(chosen) == len(packages) - 2
    assert not {'control_msgs', 'tf2_msgs'} & set(names_of(chosen))


def test_ros_of_another_python(make_prefix):
    """A ROS installation that this Python cannot import from does not count."""
    _, environ = make_prefix('control_msgs', python='python3.1')
    assert providing_prefix('control_msgs', environ) is None


def test_own_installation_is_no_ros(make_prefix):
    """A prefix into which our own wheel was installed does not count."""
    prefix, environ = make_prefix('control_msgs')
    (prefix / 'lib' / PYTHON / 'site-packages/armsim_ros_interfaces-1.dist-info').mkdir()
    assert providing_prefix('control_msgs', environ) is None


def test_names_given(packages, make_prefix):
    """ARMSIM_INTERFACES names what is built, whatever ROS provides."""
    prefix, environ = make_prefix('control_msgs', 'octomap_msgs')
    chosen, provided = select(
        packages, {**environ, 'ARMSIM_INTERFACES': 'tf2_msgs, control_msgs'})
    assert sorted(names_of(chosen)) == ['control_msgs', 'tf2_msgs']
    assert provided == {'octomap_msgs': prefix}


def test_all_given(packages, make_prefix):
    """ARMSIM_INTERFACES=all builds everything, whatever ROS provides."""
    _, environ = make_prefix('control_msgs')
    assert select(packages, {**environ, 'ARMSIM_INTERFACES': 'all'}) == (packages, {})


def test_unknown_name(packages):
    """A name that is no package is refused, with those that are."""
    with pytest.raises(BuildError, match=r'controlmsgs: no such package.*control_msgs'):
        select(packages, {'ARMSIM_INTERFACES': 'controlmsgs'})


@pytest.mark.parametrize(('variable', 'language'), [('CC', 'C'), ('CXX', r'C\+\+')])
def test_no_compiler(tmp_path, variable, language):
    """A missing compiler is named before anything else is done."""
    environ = {variable: '/nowhere/compiler'}
    with pytest.raises(BuildError, match=f'no {language} compiler .*/nowhere/compiler.*apt'):
        compiler.find_toolchain(tmp_path, tmp_path, {}, environ)


def test_no_python_headers(tmp_path, monkeypatch):
    """Missing Python headers are named, with the package that has them."""
    monkeypatch.setattr(compiler.sysconfig, 'get_path', lambda name: str(tmp_path / name))
    with pytest.raises(BuildError, match=r'Python\.h is not in .*python3\.\d+-dev'):
        compiler.find_toolchain(tmp_path, tmp_path, {}, {'CC': sys.executable,
                                                         'CXX': sys.executable})


def test_failing_tool(tmp_path):
    """What a tool wrote before it failed becomes part of the message."""
    script = tmp_path / 'tool.py'
    script.write_text('import sys; sys.exit("no luck")')
    with pytest.raises(BuildError, match=r'working failed \(status 1\):\nno luck'):
        compiler.run('working', [sys.executable, str(script)])


def test_siblings_are_linked_by_relative_path(packages):
    """A package's library finds those that it depends on beside it, wherever it is installed."""
    moveit = next(package for package in packages if package.name == 'moveit_msgs')
    inputs = compiler.link_inputs(moveit, {'octomap_msgs': Path('/build/octomap.so')})
    assert '/build/octomap.so' in inputs
    assert '-lgeometry_msgs__rosidl_generator_py' in inputs
    assert inputs[-1] == '-Wl,-rpath,$ORIGIN/../../..:$ORIGIN/../octomap_msgs'
