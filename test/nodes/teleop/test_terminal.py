# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Keys as they are pressed, and how the loop ends."""

from contextlib import suppress
import os
import signal
import sys
import termios

import pytest

from armsim_ros.cli.main import main
from armsim_ros.nodes.teleop.devices import Ending, ending_by_signals, paced, terminal


def test_keys_are_read_without_enter_and_the_terminal_is_restored(keyboard):
    """Also after an exception."""
    before = termios.tcgetattr(sys.stdin)
    with suppress(ZeroDivisionError), terminal(Ending(), needs_keys=True) as screen:
        assert not termios.tcgetattr(sys.stdin)[3] & (termios.ICANON | termios.ECHO)
        os.write(keyboard, b'wa')
        assert screen.read(0.5) == 'wa'
        assert screen.read(0.01) == ''
        raise ZeroDivisionError
    assert termios.tcgetattr(sys.stdin) == before


def test_a_terminal_that_is_gone_ends_the_loop(keyboard):
    """As SIGHUP does."""
    with ending_by_signals() as ending, terminal(ending, needs_keys=True) as screen:
        os.close(keyboard)
        assert not list(paced(ending, 0.01, screen))[2:]
    assert ending.status == 128 + signal.SIGHUP


@pytest.mark.parametrize(('number', 'status'), [
    (signal.SIGINT, 0), (signal.SIGTERM, 128 + signal.SIGTERM)])
def test_signals_end_the_loop_in_order(keyboard, number, status):
    """Ctrl-C is the usual end; the handlers of before are back afterwards."""
    before = signal.getsignal(number)
    with ending_by_signals() as ending, terminal(ending, needs_keys=True) as screen:
        for _ in paced(ending, 0.01, screen):
            os.kill(os.getpid(), number)
    assert ending.status == status
    assert signal.getsignal(number) == before


def test_a_status_is_printed_when_it_changes(keyboard, capsys):
    """In place of the last."""
    with terminal(Ending(), needs_keys=True) as screen:
        for text in ('', 'slow', 'slow', ''):
            screen.show(text)
    assert capsys.readouterr().out == '\r\x1b[Kslow\r\x1b[K\n'


@pytest.mark.parametrize(('arguments', 'text'), [
    (['--with', 'keyboard'], 'start teleop in a terminal'),
    (['--with', 'mouse'], "'mouse' is not a device; allowed: keyboard, gamepad"),
    (['--with', 'leader:'], 'leader:TOPIC'),
    (['--with', 'gamepad:/nowhere/js9'], "'/nowhere/js9' cannot be opened"),
    (['--with', 'keyboard', '--speed', '2'], 'allowed: above 0, up to 1'),
    (['--with', 'leader:/a', '--ros-args', '-r', 'a:=b'], 'takes no --ros-args'),
    (['--with', 'leader:/a', '--robot', 'sundya'], "robot 'sundya' is not found"),
    ([], '--with'),
])
def test_a_wrong_start_is_a_single_message(arguments, text, monkeypatch, capsys):
    """With status 2, and without a traceback."""
    with open(os.devnull) as nothing:
        monkeypatch.setattr('sys.stdin', nothing)
        assert main(['teleop', *arguments]) == 2
    error = capsys.readouterr().err
    assert text in error
    assert error.startswith('teleop: ')
    assert error.count('\n') == 1


def test_a_record_that_cannot_begin_is_a_single_message(keyboard, tmp_path, capsys):
    """An unknown task, and a folder with other files; before anything is started."""
    (tmp_path / 'notes.txt').write_text('mine')
    for env_id, text in (('armsim/Raech-v1', "no task 'armsim/Raech-v1'; allowed: armsim/"),
                         ('armsim/Reach-v1', 'is not empty and is not a data set')):
        assert main(['teleop', '--with', 'keyboard', '--record', env_id, str(tmp_path)]) == 2
        error = capsys.readouterr().err
        assert text in error
        assert error.count('\n') == 1


def test_a_second_signal_ends_what_waits():
    """Where the robot does not answer."""
    with ending_by_signals() as ending:
        os.kill(os.getpid(), signal.SIGINT)
        assert ending
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
