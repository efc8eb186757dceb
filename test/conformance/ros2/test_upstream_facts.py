# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Every verb beside the default robot prints what upstream's does.

upstream.yaml has what ros2cli 0.32 and ros2controlcli 4.46 printed on the same wheels. With a ROS
installation's ros2 on PATH its output is compared, too.
"""

import os
from pathlib import Path
import re
import shlex
import signal
import subprocess
import threading

import pytest
import yaml

from armsim_ros.testing.program import ros_environment
from armsim_ros2.handover import environment_for_real_ros2, find_real_ros2

FACTS = yaml.safe_load(Path(__file__).with_name('upstream.yaml').read_text())
PLACES = {
    '<n>': r'-?(?:\d+(?:\.\d*)?(?:e[+-]\d+)?|nan)',  # a number
    '<hash>': 'RIHS01_[0-9a-f]{64}',
    '<any>': '.*',  # the rest of a line, or a part of it
}
PATIENCE = 60.0  # [s]
LISTS = 3  # how often the graph is listed until it is complete


def pattern(line):
    """Return the expression of a line."""
    parts = re.split('(' + '|'.join(PLACES) + ')', line)
    return ''.join(PLACES.get(part) or re.escape(part) for part in parts)


@pytest.fixture
def upstream(robot, tmp_path):
    """Give a function that runs the ros2 of a ROS installation, and stop its daemon at the end."""
    real = find_real_ros2(os.environ['PATH'])
    if real is None:
        pytest.skip('no ROS installation with a ros2 command on PATH')
    environment = {**environment_for_real_ros2(), **ros_environment(robot),
                   'PYTHONUNBUFFERED': '1'}

    def begin(*words):
        return subprocess.Popen([real, *words], env=environment, text=True, cwd=tmp_path,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    yield begin
    begin('daemon', 'stop').communicate()


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Go to a folder with the files that the command lines name."""
    monkeypatch.chdir(tmp_path)
    for name, text in FACTS['files'].items():
        (tmp_path / name).write_text(text)


def finished(process, lines):
    """Return status, output and errors; a command that runs for ever is stopped after lines."""
    watchdog = threading.Timer(PATIENCE, process.kill)
    watchdog.start()
    try:
        head = ''.join(process.stdout.readline() for _ in range(lines))
        if lines:
            process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    finally:
        watchdog.cancel()
    return process.returncode, head if lines else out, err


def check(fact, status, out, err):
    """Assert that status, output and telling words are those of upstream."""
    seen = (fact['run'], status, out, err)
    assert status == fact.get('status', 0), seen
    assert fact.get('err', '') in err, seen
    lines = iter(out.splitlines())
    for wanted in fact.get('some', '').splitlines():
        assert any(re.fullmatch(pattern(wanted), line) for line in lines), (wanted, *seen)
    if 'some' not in fact:
        wanted = fact.get('out', '').splitlines()
        assert re.fullmatch('\n'.join(map(pattern, wanted)), '\n'.join(out.splitlines())), seen


def answer(fact, ros2, words):
    """Run a command and check it; a list is requested again, as discovery has no known end."""
    for attempt in range(LISTS if words[1] == 'list' else 1):
        done = ros2(*words)
        try:
            check(fact, done.status, done.out, done.err)
        except AssertionError:
            if words[1] != 'list' or attempt == LISTS - 1:
                raise
        else:
            return


@pytest.mark.parametrize('command', FACTS['commands'])
def test_a_command_prints_what_upstream_prints(command, ros2, start, files):
    """Form, status and telling words of every verb."""
    for fact in FACTS['commands'][command]:
        words = shlex.split(fact['run'])
        if 'lines' in fact:
            check(fact, *finished(start(*words), fact['lines']))
        else:
            answer(fact, ros2, words)


@pytest.mark.parametrize('command', FACTS['commands'])
def test_upstream_still_prints_it(command, upstream, files):
    """The stored facts are those of the installed ros2."""
    for fact in FACTS['commands'][command]:
        check(fact, *finished(upstream(*shlex.split(fact['run'])), fact.get('lines', 0)))
