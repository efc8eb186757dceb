# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The real bringup with the real programs."""

import os
from pathlib import Path
import re
import shutil
import signal
import threading

import pytest

from armsim_ros.resources import find_robot
from armsim_ros.testing.program import private_domain, start_program

READY = 'You can start planning now!'


@pytest.fixture
def domain():
    """Lease a ROS domain."""
    with private_domain() as number:
        yield number


def children_of(program):
    """Return name -> pid of the programs that bringup has started."""
    pid = program.process.pid
    found = {}
    for child in Path(f'/proc/{pid}/task/{pid}/children').read_text().split():
        words = Path(f'/proc/{child}/cmdline').read_text().split('\0')
        if 'armsim_ros' in words:  # else it is not yet what it will be
            found[words[words.index('armsim_ros') + 1]] = int(child)
    return found


def runs(pid):
    """Return whether a process exists."""
    return Path(f'/proc/{pid}').exists()


def test_a_stack_comes_up_alone_in_its_domain_and_goes_down_without_a_trace(domain):
    """A second stack is refused meanwhile; Ctrl-C leaves no process after 2 s, status 0."""
    with start_program('bringup', domain) as first:
        first.wait_for_line(READY, 60)
        children = children_of(first)
        assert set(children) == {'simulation', 'move_group'}
        with start_program('bringup', domain) as second:
            assert second.wait(10) == 2
            (message,) = second.output
            assert f'another bringup (pid {first.process.pid})' in message
            assert f'ROS_DOMAIN_ID {domain}' in message
        first.signal(signal.SIGINT)
        assert first.wait(2) == 0
        assert not any(runs(pid) for pid in children.values())
        assert 'Traceback' not in first.text
        assert 'WARN' not in first.text  # the default robot has nothing to warn of


@pytest.mark.parametrize(('victim', 'other'), [
    ('simulation', 'move_group'), ('move_group', 'simulation')])
def test_the_loss_of_a_program_is_named_and_ends_the_stack(victim, other, domain):
    """Half a stack does not go on."""
    with start_program('bringup', domain) as program:
        program.wait_for_line(r'^\[simulation\]', 60)
        children = children_of(program)
        os.kill(children[victim], signal.SIGKILL)
        assert program.wait(10) == 1
        said = f'[bringup] {victim} (pid {children[victim]}) was killed by signal 9 (SIGKILL); ' \
               f'stopping {other}'
        assert said in program.text
        assert not any(runs(pid) for pid in children.values())


def assert_nobody_else_spoke(program):
    """Fail where a child printed a line, other than that this machine is slow."""
    others = [line for line in program.output
              if not line.startswith('[bringup] ') and 'this machine is overloaded' not in line]
    assert not others, program.text


def test_an_interrupt_while_everything_is_being_imported_shows_no_traceback(domain):
    """Ctrl-C right after the start is a good end too, within 2 s."""
    with start_program('bringup', domain) as program:
        while not children_of(program):
            assert program.process.poll() is None, program.text
        program.signal(signal.SIGINT)
        assert program.wait(2) == 0
        assert_nobody_else_spoke(program)


@pytest.mark.alone
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_the_files_are_read_ends_at_once(number, domain, tmp_path):
    """Within 2 s, and nothing is printed about a file that was read by half."""
    os.mkfifo(tmp_path / 'endless.xacro')
    file = tmp_path / 'arm.urdf.xacro'
    file.write_text('<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
                    '<xacro:include filename="endless.xacro"/></robot>')
    with start_program('bringup', domain, f'urdf:={file}') as program:
        pause = threading.Event()
        while (writer := open_read_pipe(tmp_path / 'endless.xacro')) is None:
            assert program.process.poll() is None, program.text
            pause.wait(0.01)
        program.signal(number)
        # A signal just before the read begins does not end it; the end of the file does.
        os.close(writer)
        assert program.wait(2) == 0
        assert_nobody_else_spoke(program)


def told(program):
    """Return what was printed beside what is loaded, and how busy the machine is."""
    usual = re.compile(r'^\[bringup\] loading |this machine is overloaded')
    return [line for line in program.output if not usual.search(line)]


def open_read_pipe(path):
    """Return a file descriptor to write to a pipe that somebody reads, None where nobody does."""
    try:
        return os.open(path, os.O_WRONLY | os.O_NONBLOCK)
    except OSError:
        return None


@pytest.mark.parametrize(('words', 'said'), [
    (['robot:=no_such_robot'], 'no_such_robot'),
    (['urdf:=/no/such.urdf'], '/no/such.urdf'),
])
def test_what_is_not_there_is_one_message(words, said, domain):
    """A wrong name or path is told once, without a traceback, with status 2."""
    with start_program('bringup', domain, *words) as program:
        assert program.wait(30) == 2
        (message,) = told(program)
        assert said in message


def test_a_broken_file_is_one_message_with_its_place(domain, tmp_path):
    """Both programs read the file; the user hears of it once, with file and line."""
    robot = tmp_path / 'mine'
    shutil.copytree(find_robot('sunday'), robot)
    file = robot / 'trajectory_control.yaml'
    lines = file.read_text().splitlines()
    file.write_text('\n'.join([*lines, '\tbroken: [']))
    with start_program('bringup', domain, f'config:={robot}') as program:
        assert program.wait(30) == 2
        (message,) = told(program)
        assert f'{file}:{len(lines) + 1}' in message
