# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What bringup starts, without starting it."""

import io
from types import SimpleNamespace

import pytest

from armsim_ros.errors import ConfigError
from armsim_ros.nodes.bringup import main as bringup


class Screen(io.StringIO):
    """What was printed, on a terminal or into a file."""

    def __init__(self, terminal):
        super().__init__()
        self.terminal = terminal

    def isatty(self):
        """Return what a terminal would."""
        return self.terminal


@pytest.fixture
def started(monkeypatch):
    """Return the names of the programs that a supervisor would start."""
    names = []

    def supervise(commands, spare):
        names.extend(commands)
        return SimpleNamespace(run=lambda: 0)

    monkeypatch.setattr(bringup, 'Supervisor', supervise)
    monkeypatch.setattr(bringup, 'lock_domain', lambda _: SimpleNamespace(release=lambda: None))
    return names


def test_a_robot_that_is_not_there_starts_nothing(started, capsys):
    """The name is checked before a program is announced; a name in other capitals is proposed."""
    with pytest.raises(ConfigError, match="did you mean 'ROBOT'"):
        bringup.main(['robot:=robot'])
    assert 'loading' not in capsys.readouterr().out
    assert not started


@pytest.mark.parametrize(('words', 'terminal', 'served'), [
    ([], True, True), ([], False, False), (['web:=false'], True, False),
    (['--web', 'true'], False, True)])
def test_the_page_is_served_at_a_terminal(words, terminal, served, started, monkeypatch):
    """By default where a person reads the output; the argument decides otherwise."""
    monkeypatch.setattr('sys.stdout', Screen(terminal))
    assert bringup.main(words) == 0
    assert ('web' in started) is served
