# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What make env says and when it does something again."""

from dataclasses import replace
from pathlib import Path
import platform
import sys
from zipfile import ZipFile

import env
from environment import interfaces, machine, stages
from environment.installer import Installer, pip_failure, uv_options
from environment.interfaces import InterfaceWheel
from environment.machine import SetupError
from environment.sources import content_hash, copy_files, requirements
import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture
def interpreter():
    """Return what this interpreter says of itself."""
    return machine.ask_interpreter(Path(sys.executable))


@pytest.fixture
def tree(tmp_path):
    """Return a source tree with a package and two interface packages."""
    for name in ('code/a.py', 'interfaces/control_msgs/package.xml',
                 'interfaces/moveit_msgs/package.xml'):
        file = tmp_path / name
        file.parent.mkdir(parents=True)
        file.write_text(name)
    return tmp_path


def install_ros(prefix, *packages, python=f'python{sys.version_info[0]}.{sys.version_info[1]}'):
    """Make a folder that looks like a ROS installation."""
    index = prefix / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    for package in packages:
        (index / package).touch()
        (prefix / 'lib' / python / 'site-packages' / package).mkdir(parents=True)
    return prefix


@pytest.mark.parametrize('version', [(2, 7, 18), (3, 9, 5), (3, 14, 0)])
def test_a_python_that_does_not_fit_is_named_with_the_range(version, monkeypatch, capsys):
    """The message says what there is, what is needed, and how to name another."""
    monkeypatch.setattr(sys, 'version_info', version)
    assert env.main() == 1
    message = capsys.readouterr().err
    assert f'Python {version[0]}.{version[1]}' in message
    assert '3.10 to 3.13' in message
    assert 'make PYTHON=' in message


def test_the_promised_pythons_are_those_of_the_package():
    """env.py and setup.py name the same oldest version."""
    oldest = '.'.join(map(str, env.OLDEST))
    assert f"python_requires='>={oldest}'" in (ROOT / 'setup.py').read_text()


def test_a_python_without_venv_is_told_the_package(monkeypatch):
    """Debian's python3 lacks ensurepip until python3-venv is there."""
    monkeypatch.setattr(machine.importlib.util, 'find_spec', lambda name: None)
    with pytest.raises(SetupError, match=r'apt install python3\.\d+-venv'):
        machine.check_venv_module()


def test_a_missing_compiler_and_header_are_one_message(interpreter, monkeypatch, tmp_path):
    """Everything that is missing is named at once, with the packages that bring it."""
    monkeypatch.setenv('CC', 'no-such-cc')
    monkeypatch.setenv('CXX', 'no-such-c++ -O1')
    with pytest.raises(SetupError) as caught:
        machine.check_compiler(replace(interpreter, include=str(tmp_path)))
    text = str(caught.value)
    assert 'no-such-cc and the compiler no-such-c++' in text
    assert 'Python.h' in text
    assert 'apt install gcc g++ python3.' in text


@pytest.mark.parametrize(('output', 'said'), [
    ("WARNING: Retrying (Retry(total=1, connect=None)) after connection broken by "
     "'NewConnectionError': /simple/numpy/\n"
     'ERROR: No matching distribution found for numpy', 'index does not answer; check the net'),
    ('ERROR: No matching distribution found for mujoco<5,>=3.3', 'there is no mujoco<5,>=3.3 for'),
    ('OSError: [Errno 28] No space left on device', 'the disk is full'),
    ('noise\nerror: x.msg:3: no\nmore noise', '\n  error: x.msg:3: no'),
])
def test_a_failed_pip_is_explained(output, said):
    """The cause comes first, the log file is named."""
    text = str(pip_failure('install packages', output, Path('/x/pip.log')))
    assert text.startswith('cannot install packages')
    assert said in text
    assert '/x/pip.log' in text


def test_uv_looks_where_pip_looks():
    """Mirrors, folders and certificates of pip's configuration are uv's, the nearest one wins."""
    options, variables = uv_options("""\
:env:.cert='/etc/ca.pem'
:env:.find-links='/wheels'
global.index-url='https://mirror/simple'
global.extra-index-url='https://a/simple\\nhttps://b/simple'
global.find-links='/old'
global.no-index='false'
install.index-url='https://other/simple'
list.format='columns'
""")
    assert options == [
        '--index-strategy', 'unsafe-best-match', '--default-index', 'https://other/simple',
        '--index', 'https://a/simple', '--index', 'https://b/simple', '--find-links', '/wheels']
    assert variables == {'SSL_CERT_FILE': '/etc/ca.pem'}


def test_what_uv_does_not_do_pip_explains(tmp_path, monkeypatch):
    """The reason in the message is pip's, with uv or without."""
    monkeypatch.setenv('PIP_NO_INDEX', '1')
    monkeypatch.setenv('PIP_FIND_LINKS', str(tmp_path))
    (tmp_path / 'bin').mkdir()
    (tmp_path / 'bin/python').symlink_to(sys.executable)
    for installed in (True, False):
        if installed:
            (tmp_path / 'bin/uv').write_text('#!/bin/sh\nexit 1\n')
            (tmp_path / 'bin/uv').chmod(0o755)
        else:
            (tmp_path / 'bin/uv').unlink()
        with pytest.raises(SetupError, match='there is no no-such-package>=7 for this Python'):
            Installer(tmp_path).quick('install it', ['no-such-package>=7'])


def test_byte_code_is_made_of_packages_without_their_tests(tmp_path):
    """Code of another Python stops nothing; tests in the path of the environment hide nothing."""
    venv = tmp_path / 'tests' / 'venv'
    site = venv / 'lib' / 'python3' / 'site-packages'
    for name, text in (('alone.py', ''), ('package/module.py', ''), ('package/old.py', 'print 1'),
                       ('package/tests/test_it.py', '')):
        file = site / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    (venv / 'bin').mkdir()
    (venv / 'bin/python').symlink_to(sys.executable)
    Installer(venv).compile()
    assert {path.name.partition('.')[0] for path in site.rglob('*.pyc')} == {'alone', 'module'}


def test_a_place_that_cannot_be_written_is_one_message(tmp_path, capsys, monkeypatch):
    """A read-only folder shows no traceback."""
    (tmp_path / 'file').touch()
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    assert stages.run(['--venv', str(tmp_path / 'file' / '.venv')]) == 1
    captured = capsys.readouterr()
    assert 'cannot write' in captured.err
    assert captured.err.count('\n') == 1


def test_a_folder_of_the_user_is_never_overwritten(tmp_path, capsys, monkeypatch):
    """A folder that is no environment is not taken for one."""
    (tmp_path / 'notes.txt').touch()
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    assert stages.run(['--venv', str(tmp_path)]) == 1
    assert 'holds other files (notes.txt)' in capsys.readouterr().err
    assert (tmp_path / 'notes.txt').exists()


def test_an_environment_of_another_program_is_left_alone(tmp_path, capsys, monkeypatch):
    """An environment without env.py's record is named, and not made anew."""
    (tmp_path / 'pyvenv.cfg').touch()
    (tmp_path / 'lib').mkdir()
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    assert stages.run(['--venv', str(tmp_path)]) == 1
    message = capsys.readouterr().err
    assert f'{tmp_path} holds a Python environment made by another program' in message
    assert 'VENV=DIR' in message
    assert (tmp_path / 'lib').exists()


def test_the_hash_follows_content_names_and_modes(tree):
    """Whatever would be installed differently has another hash, in linked folders too."""
    seen = {content_hash(tree, ['code'])}
    (tree / 'code/a.py').write_text('b')
    seen.add(content_hash(tree, ['code']))
    (tree / 'code/a.py').chmod(0o755)
    seen.add(content_hash(tree, ['code']))
    (tree / 'code/a.py').rename(tree / 'code/c.py')
    seen.add(content_hash(tree, ['code']))
    (tree / 'own').mkdir()
    (tree / 'own' / 'b.py').touch()
    (tree / 'code' / 'linked').symlink_to('../own')
    seen.add(content_hash(tree, ['code']))
    (tree / 'own' / 'b.py').write_text('b')
    seen.add(content_hash(tree, ['code']))
    assert len(seen) == 6


def test_what_builds_leave_behind_does_not_count(tree, tmp_path):
    """Byte code and build folders change neither the hash nor the copy."""
    before = content_hash(tree, ['code'])
    for name in ('code/__pycache__/a.pyc', 'code/build/lib/a.py'):
        (tree / name).parent.mkdir(parents=True)
        (tree / name).touch()
    assert content_hash(tree, ['code']) == before
    copy_files(tree, ['code'], tmp_path / 'copy')
    assert [path.name for path in (tmp_path / 'copy').rglob('*')] == ['code', 'a.py']


def test_the_wheel_belongs_to_sources_and_interpreter(tree, interpreter):
    """Another Python or another definition file needs another wheel, the same one does not."""
    key = InterfaceWheel(tree, interpreter, None).key
    assert InterfaceWheel(tree, interpreter, None).key == key
    assert InterfaceWheel(tree, replace(interpreter, tag='other'), None).key != key
    (tree / 'interfaces/moveit_msgs/package.xml').write_text('changed')
    assert InterfaceWheel(tree, interpreter, None).key != key


@pytest.mark.parametrize('fits', [True, False])
def test_a_wheel_in_dist_saves_the_compilation(tree, interpreter, tmp_path, monkeypatch, fits):
    """A wheel of the same sources for this Python is used, another is not."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    python = 'cp' + ''.join(interpreter.version.split('.')[:2])
    wheel = tree / 'dist' / (f'armsim_ros_interfaces-0.1.0-{python}-{python}-manylinux_2_28_'
                             f'{platform.machine()}.whl')
    wheel.parent.mkdir()
    with ZipFile(wheel, 'w') as archive:
        archive.writestr('x.data/data/share/armsim_ros_interfaces/sources',
                         content_hash(tree, ['interfaces']) if fits else 'other')
    assert InterfaceWheel(tree, interpreter, None).existing() == (wheel if fits else None)
    ros = install_ros(tree / 'ros', 'rclpy', 'control_msgs')
    assert InterfaceWheel(tree, interpreter, ros).existing() is None


@pytest.mark.parametrize('uses_ros', [True, False])
def test_the_build_sees_a_sourced_ros_only_where_it_is_used(
        tree, interpreter, tmp_path, monkeypatch, uses_ros):
    """A wheel for machines without ROS names all its requirements, whatever this shell sourced."""
    prefix = install_ros(tree / 'ros', 'rclpy', 'control_msgs')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix))
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    given = []
    monkeypatch.setattr(interfaces, 'check_compiler', lambda _: None)
    monkeypatch.setattr(interfaces.subprocess, 'Popen', lambda _, **words: given.append(words))
    InterfaceWheel(tree, interpreter, prefix if uses_ros else None).start(
        Path('python'), tmp_path / 'log')
    assert given[0]['env'].get('AMENT_PREFIX_PATH') == (str(prefix) if uses_ros else None)


def test_packages_of_a_sourced_installation_are_not_built(tree, interpreter):
    """What the system has is used and not shadowed."""
    some = install_ros(tree / 'some', 'rclpy', 'control_msgs')
    every = install_ros(tree / 'every', 'rclpy', 'control_msgs', 'moveit_msgs')
    assert InterfaceWheel(tree, interpreter, some).selection == ['moveit_msgs']
    assert not InterfaceWheel(tree, interpreter, every).is_needed()


def test_a_sourced_jazzy_is_found(tmp_path, monkeypatch, interpreter):
    """The prefix with rclpy is the installation, an overlay is not."""
    install_ros(tmp_path / 'overlay', 'mine')
    jazzy = install_ros(tmp_path / 'jazzy', 'rclpy')
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{tmp_path}/overlay:{jazzy}')
    monkeypatch.setenv('ROS_DISTRO', 'jazzy')
    assert machine.sourced_ros(interpreter.version) == jazzy


def test_a_sourced_installation_of_another_kind_is_refused(tmp_path, monkeypatch, interpreter):
    """Another distribution, or one for another Python, gives a message and not a broken stack."""
    prefix = install_ros(tmp_path / 'ros', 'rclpy', python='python3.8')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix))
    monkeypatch.setenv('ROS_DISTRO', 'jazzy')
    with pytest.raises(SetupError, match='is for another Python than'):
        machine.sourced_ros(interpreter.version)
    monkeypatch.setenv('ROS_DISTRO', 'humble')
    with pytest.raises(SetupError, match='ROS 2 humble'):
        machine.sourced_ros(interpreter.version)


def test_the_wheels_start_up_hook_is_kept_from_other_interpreters(monkeypatch):
    """Library paths of this environment do not reach another environment's Python."""
    monkeypatch.setenv('LD_LIBRARY_PATH', '/venv/lib')
    monkeypatch.setenv('_ROS_WHEELS_BOOTSTRAP_COMPLETE', '1')
    assert 'LD_LIBRARY_PATH' not in machine.clean_environment()
    monkeypatch.delenv('_ROS_WHEELS_BOOTSTRAP_COMPLETE')
    assert machine.clean_environment()['LD_LIBRARY_PATH'] == '/venv/lib'


def test_requirements_are_read_from_the_one_place():
    """Comments in setup.cfg are no requirements."""
    assert 'numpy>=1.26' in requirements(ROOT)
    assert not any(line.startswith('armsim') for line in requirements(ROOT, 'ros'))
    assert all(line[0].isalpha() for extra in (None, 'ros', 'test', 'lint')
               for line in requirements(ROOT, extra))
