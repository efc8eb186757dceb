# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Words that shells propose."""

import shutil
import subprocess
import sys

import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.tools.completion import candidates, main, SCRIPTS


@pytest.mark.parametrize(('words', 'found'), [
    (['bringu'], ['bringup']),
    (['bringup', 'serv'], ['servo:=']),
    (['bringup', 'robot:=su'], ['robot:=sunday']),
    (['bringup', 'servo:=', 'servo:=t'], ['servo:=true']),
    (['bringup', 'mode:='], ['mode:=realtime', 'mode:=lockstep']),
    (['bringup', 'world:=e'], ['world:=empty']),
    (['copy', 'pan'], ['panda']),
    (['copy', 'panda', 'x'], []),
    (['completion', 'z'], ['zsh']),
])
def test_what_a_word_can_become(words, found):
    """Programs, arguments with their values, robots, worlds."""
    assert candidates(words) == found


def test_folders_are_proposed_for_a_robot(tmp_path, monkeypatch):
    """Where no name of a robot begins like this."""
    (tmp_path / 'mine').mkdir()
    monkeypatch.chdir(tmp_path)
    assert candidates(['bringup', 'robot:=mi']) == ['robot:=mine/']


def test_bash_completes_what_stands_behind_the_sign(tmp_path):
    """The script works in a shell, which takes := for the end of a word."""
    (tmp_path / 'armsim').write_text(f'#!/bin/sh\nexec {sys.executable} -m armsim_ros "$@"\n')
    (tmp_path / 'armsim').chmod(0o755)
    program = SCRIPTS['bash'].replace('compopt -o nospace', 'true') + """
for line in 'armsim bringup robot:=su' 'armsim bringup serv' 'armsim comp'; do
    COMP_LINE=$line COMP_POINT=${#line}; COMPREPLY=(); _armsim; echo "${COMPREPLY[@]}"
done
"""
    done = subprocess.run(['bash', '-c', program], text=True, capture_output=True, check=True,
                          env={'PATH': f'{tmp_path}:/usr/bin:/bin',
                               'PYTHONPATH': ':'.join(sys.path)})
    assert done.stdout.splitlines() == ['sunday', 'servo:=', 'completion']


@pytest.mark.parametrize('shell', [
    shell for shell in SCRIPTS if shutil.which(shell)])
def test_the_scripts_are_read_by_their_shells(shell):
    """Each is valid where its shell is installed."""
    subprocess.run([shell, '-n', '-c', SCRIPTS[shell]], check=True)


def test_another_shell_is_refused(capsys):
    """The message lists those that there are."""
    with pytest.raises(UsageError, match='bash, zsh, fish'):
        main(['tcsh'])
    assert main(['fish']) == 0
    assert 'complete -c armsim' in capsys.readouterr().out
