# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim run``, to which ``ros2 run`` passes what is not installed."""

from pathlib import Path
import signal
import subprocess
import sys
from textwrap import dedent

import pytest

from armsim_ros.launch.run import main

ARMSIM = [sys.executable, '-m', 'armsim_ros', 'run']


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Return the sources of a package with a console script; the workspace is the folder."""
    folder = tmp_path / 'src' / 'nodes'
    (folder / 'nodes').mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>nodes</name></package>')
    (folder / 'setup.py').write_text(
        "from setuptools import setup\n"
        "setup(name='nodes', packages=['nodes'],\n"
        "      entry_points={'console_scripts': ['count = nodes.count:main']})\n")
    (folder / 'nodes' / '__init__.py').touch()
    (folder / 'nodes' / 'count.py').write_text(dedent("""
        import sys

        from ament_index_python.packages import get_package_share_directory

        def main():
            print(get_package_share_directory('nodes'), *sys.argv[1:], flush=True)
            return len(sys.stdin.read())
        """))
    monkeypatch.chdir(tmp_path)
    return folder


def test_a_program_in_sources_is_run(workspace: Path) -> None:
    """It gets its words and the input, finds its package, and its status is the command's."""
    done = subprocess.run([*ARMSIM, 'nodes', 'count', 'a', '-x'], input='12345', text=True,
                          capture_output=True, check=False)
    assert done.returncode == 5, done.stderr
    assert done.stdout.endswith('share/nodes a -x\n')


def test_a_signal_is_passed_on(workspace: Path) -> None:
    """A program that is ended by SIGTERM leaves the status of a shell, and no file."""
    with subprocess.Popen([*ARMSIM, 'nodes', 'count'], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, text=True) as process:
        share = process.stdout.readline().split()[0]
        assert Path(share).is_dir()
        process.send_signal(signal.SIGTERM)
        assert process.wait(30.0) == 128 + signal.SIGTERM
    assert not Path(share).exists()


def test_ours_is_run_in_place_of_upstreams() -> None:
    """The spawner of controller_manager is ours, with its own help."""
    done = subprocess.run([*ARMSIM, 'controller_manager', 'spawner', '--help'], text=True,
                          capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith('usage: spawner NAME...')


def test_what_the_simulation_does_needs_no_program(capsys: pytest.CaptureFixture[str]) -> None:
    """A bridge to Gazebo's topics is answered in a line."""
    assert main(['ros_gz_bridge', 'parameter_bridge', 'x']) == 0
    assert 'the simulation publishes these topics itself' in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'message'), [
    (['nodes', 'cuont'], "package 'nodes' ({}) has no program 'cuont' (it has: count)"),
    (['--failure=Package not found', 'absent', 'count'], 'Package not found')])
def test_an_unknown_program(workspace: Path, capsys: pytest.CaptureFixture[str],
                            words: list[str], message: str) -> None:
    """Programs of a package in sources are named; else the message is that of ros2 run."""
    assert main(words) == 1
    assert capsys.readouterr().err.rstrip().endswith(message.format(workspace))
