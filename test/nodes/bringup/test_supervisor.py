# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several programs as one: real processes under a real supervisor."""

import json
import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest

from armsim_ros.cli.environment import child_environment, program_command
from armsim_ros.nodes.bringup.supervisor import SIGKILL_AFTER

SUPERVISOR = """
import json, sys
from armsim_ros.nodes.bringup.supervisor import Supervisor
sys.exit(Supervisor(json.loads(sys.argv[1]), spare=('spare',)).run())
"""
PATIENT = "print('ready'); import signal; signal.pause()"
HEAR = 'import signal, sys; signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})'
POLITE = HEAR + """
signal.signal(signal.SIGINT, lambda *_: sys.exit('goodbye'))
print('ready')
signal.pause()
"""
DEAF = """
import signal
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
print('ready')
while True:
    signal.pause()
"""


@pytest.fixture
def supervise():
    """Return a function that starts a supervisor over Python texts; kill it in the end."""
    started = []

    def start(**texts):
        commands = {name: [sys.executable, '-c', text] for name, text in texts.items()}
        process = subprocess.Popen(
            [sys.executable, '-c', SUPERVISOR, json.dumps(commands)], text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def wait_until_ready(process, *names):
    """Read until each program has said that it is ready."""
    missing = {f'[{name}] ready\n' for name in names}
    while missing:
        line = process.stdout.readline()
        assert line, process.stderr.read()
        missing.discard(line)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_all_and_is_a_good_end(number, supervise):
    """Ctrl-C, kill and a closed terminal stop every program; the status is 0."""
    process = supervise(one=POLITE, two=POLITE)
    wait_until_ready(process, 'one', 'two')
    process.send_signal(number)
    _, errors = process.communicate()
    assert process.returncode == 0
    assert sorted(errors.splitlines()) == ['[one] goodbye', '[two] goodbye']


def test_a_program_that_will_not_end_is_killed(supervise):
    """SIGINT and SIGTERM ignored, SIGKILL is not; still a good end."""
    process = supervise(one=DEAF, two=PATIENT)
    wait_until_ready(process, 'one', 'two')
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 0


def test_the_stop_schedule_leaves_nothing_after_two_seconds():
    """The last word is SIGKILL and comes well before the promised 2 s."""
    assert SIGKILL_AFTER <= 1.5


def test_a_killed_program_is_named_and_the_rest_stopped(supervise):
    """The message has name, pid, signal and the last lines; the status is 1."""
    text = "import os; print('hold on'); os.kill(os.getpid(), 9)"
    process = supervise(one=POLITE, two=text)
    _, errors = process.communicate()
    assert process.returncode == 1
    assert 'was killed by signal 9 (SIGKILL); stopping one; its last lines:\n  hold on' in errors
    assert '[bringup] two (pid ' in errors


def test_a_program_that_ends_by_itself_is_a_loss_too(supervise):
    """Exit status 0 of one program is no reason to run half a stack."""
    process = supervise(one='', two=PATIENT)
    _, errors = process.communicate()
    assert process.returncode == 1
    assert 'ended with exit status 0; stopping two; it had printed nothing' in errors


def test_a_spare_program_takes_nobody_along(supervise):
    """Its end is told; the others go on until they are stopped."""
    process = supervise(spare='raise SystemExit(3)', one=PATIENT)
    told = process.stderr.readline()
    assert told.startswith('[bringup] spare (pid ')
    assert told.endswith('ended with exit status 3; the rest goes on\n')
    wait_until_ready(process, 'one')
    process.send_signal(signal.SIGINT)
    assert process.wait(10) == 0


def test_a_refused_configuration_keeps_its_one_message(supervise):
    """A program that exits 2 has explained itself; the supervisor adds nothing and exits 2."""
    process = supervise(one="import sys; print('x.yaml:3: no', file=sys.stderr); sys.exit(2)",
                        two=PATIENT)
    _, errors = process.communicate()
    assert process.returncode == 2
    assert errors == '[one] x.yaml:3: no\n'


def test_what_all_programs_refuse_is_said_once(supervise):
    """Each program reads the same files and finds the same mistake; a user reads it once."""
    text = """
import os, sys
from armsim_ros.cli.environment import refuse
refuse('x.yaml:3: no\\nx.yaml:4: no')
sys.exit(2)
"""
    process = supervise(one=text, two=text)
    _, errors = process.communicate()
    assert process.returncode == 2
    assert errors == 'bringup: x.yaml:3: no\nx.yaml:4: no\n'


def test_output_that_nobody_reads_holds_no_program_up(supervise, tmp_path):
    """Not a pager, not Ctrl-S: the program goes on, and what was lost is counted."""
    fifo = tmp_path / 'done'
    os.mkfifo(fifo)
    process = supervise(one=f"""
import signal
for number in range(40_000):
    print(f'line {{number:050}}')
with open({str(fifo)!r}, 'w') as done:
    done.write('all is said')
signal.pause()
""")
    with open(fifo) as done:
        assert done.read() == 'all is said'
    for line in process.stdout:
        if 'were dropped here: output not read' in line:
            break
    else:
        raise AssertionError('nothing was dropped')
    assert int(line.split()[1]) > 1000
    process.send_signal(signal.SIGINT)
    process.communicate()


def test_every_line_bears_its_programs_name(supervise):
    """Lines are passed on whole, on the stream they came from, the unfinished last one too."""
    process = supervise(one="print('a\\nb'); print('c', end='')")
    output, _ = process.communicate()
    assert output.splitlines() == ['[one] a', '[one] b', '[one] c']


def test_no_program_outlives_a_killed_supervisor(supervise, tmp_path):
    """SIGKILL of the supervisor, which it cannot handle, is the end of its programs."""
    fifo = tmp_path / 'alive'
    os.mkfifo(fifo)
    process = supervise(one=f'alive = open({str(fifo)!r}, "w")\n' + DEAF)
    with open(fifo) as alive:
        wait_until_ready(process, 'one')
        process.kill()
        assert alive.read() == ''


def test_what_a_program_started_ends_with_it(supervise, tmp_path):
    """The process group of a lost program is cleared."""
    fifo = tmp_path / 'alive'
    os.mkfifo(fifo)
    helper = f'alive = open({str(fifo)!r}, "w")\n' + DEAF
    text = f"""
import subprocess, sys
child = subprocess.Popen([sys.executable, '-c', {helper!r}], stdout=subprocess.PIPE, text=True)
child.stdout.readline()
sys.exit(3)
"""
    process = supervise(one=text)
    with open(fifo) as alive:
        process.communicate()
        assert alive.read() == ''
    assert process.returncode == 1


def test_a_background_jobs_programs_hear_sigint(supervise):
    """A shell makes background jobs ignore SIGINT; the programs must not inherit that."""
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = supervise(one=HEAR + """
print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)
print('ready')
signal.pause()
""")
    finally:
        signal.signal(signal.SIGINT, usual)
    assert process.stdout.readline() == '[one] True\n'
    wait_until_ready(process, 'one')
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 0


def test_a_reader_that_went_away_is_a_good_end(supervise):
    """``bringup | head`` stops the stack and shows no traceback."""
    process = supervise(one='print("ready")\nwhile True: print("x" * 1000)')
    wait_until_ready(process, 'one')
    process.stdout.close()
    errors = process.stderr.read()
    assert process.wait() == 0
    assert 'Traceback' not in errors


def test_a_program_imports_the_same_package():
    """A child started from any folder runs this package's code."""
    done = subprocess.run(program_command('bringup', ['--help']), env=child_environment(),
                          cwd=Path('/'), capture_output=True, text=True, check=True)
    assert done.stdout.startswith('usage: armsim bringup')
