# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The files of make dist: the same bytes for the same sources, and Pythons that are found."""

import os
from pathlib import Path
import re
import subprocess
import sys
import tarfile

import dist
from environment.interfaces import InterfaceWheel
from environment.machine import ask_interpreter, Interpreter, SetupError
import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture
def umask():
    """Restore the umask."""
    before = os.umask(0o022)
    yield
    os.umask(before)


def test_the_same_sources_give_the_same_bytes(tmp_path, umask):
    """Neither time, folder nor umask is in the files."""
    made = []
    for name, mask in (('a', 0o022), ('b', 0o077)):
        os.umask(mask)
        target = tmp_path / name / 'made'
        target.mkdir(parents=True)
        dist.build_pure('helpers', dist.PURE['helpers'], tmp_path / name / 'work', target)
        made.append({path.name: path.read_bytes() for path in target.iterdir()})
    assert made[0] == made[1]
    assert sorted(name.rpartition('.')[2] for name in made[0]) == ['gz', 'whl']


def test_an_archive_lists_its_files_in_order_and_without_owners(tmp_path, umask):
    """What differs between machines is removed."""
    for name in ('b', 'a'):
        (tmp_path / name).write_text(name)
    with tarfile.open(tmp_path / 'x.tar.gz', 'w:gz') as stream:
        stream.add(tmp_path / 'b', 'b')
        stream.add(tmp_path / 'a', 'a')
    dist.repack(tmp_path / 'x.tar.gz', tmp_path / 'y.tar.gz')
    with tarfile.open(tmp_path / 'y.tar.gz') as stream:
        members = stream.getmembers()
        assert [member.name for member in members] == ['a', 'b']
        assert {(m.uid, m.gid, m.uname, m.mtime) for m in members} == {(0, 0, '', 315532800)}
        assert stream.extractfile('b').read() == b'b'


def test_pythons_are_found_in_pyenv(tmp_path, monkeypatch):
    """A version that is not active on PATH counts, without headers it does not."""
    for version in ('3.12.1', '3.13.0'):
        python = tmp_path / 'versions' / version / 'bin' / 'python'
        python.parent.mkdir(parents=True)
        python.touch()
    (tmp_path / '3.12.1').mkdir()
    (tmp_path / '3.12.1/Python.h').touch()

    def ask(python):
        version = python.parent.parent.name
        include = str(tmp_path / version)
        return Interpreter(version, version, include, 'cc', 'c++') if version[:2] == '3.' else None

    monkeypatch.setenv('PYENV_ROOT', str(tmp_path))
    monkeypatch.setattr(dist, 'ask_interpreter', ask)
    found = list(dist.find_pythons(['3.12', '3.13']))
    assert [(version, python.parts[-3]) for version, python, _ in found] == [('3.12', '3.12.1')]
    with pytest.raises(SetupError, match=r'no Python with headers among 3\.13'):
        list(dist.find_pythons(['3.13']))


def test_a_wheel_for_this_machine_alone_is_refused(tmp_path, monkeypatch):
    """A library with symbols that are too new stays out of dist/."""
    wheel = tmp_path / 'armsim_ros_interfaces-0.1.0-cp312-cp312-linux_x86_64.whl'
    monkeypatch.setattr(InterfaceWheel, 'existing', lambda _: wheel)
    with pytest.raises(SetupError, match=r'needs newer symbols than manylinux_2_28_'):
        dist.build_interfaces('3.12', Path(sys.executable), ask_interpreter(Path(sys.executable)))


def test_the_extra_and_the_interfaces_want_the_same_versions():
    """The interface packages are built, installed and used with the same message packages."""
    pattern = r"^\s*'?(?:\w+': ')?(ros-jazzy-(?:common|lifecycle|action)[\w-]+[<>=\d.,]+)"
    wanted = [re.findall(pattern, (ROOT / name).read_text(), re.MULTILINE)
              for name in ('interfaces/setup.py', 'interfaces/pyproject.toml', 'setup.cfg')]
    wanted = [sorted(line.rstrip(',') for line in lines) for lines in wanted]
    assert len(wanted[0]) == 3
    assert wanted[0] == wanted[1] == wanted[2]


def test_an_unknown_python_is_refused():
    """The message lists the supported versions."""
    done = subprocess.run([sys.executable, ROOT / 'scripts/dist.py', '--python', '3.9'],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert '3.10' in done.stderr
