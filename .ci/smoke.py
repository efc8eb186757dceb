# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Starts the installed bringup with its page, moves the arm, stops it; run by .ci/dist."""

import re
import signal
import subprocess
import sys
import threading
from urllib.request import urlopen

READY = 'You can start planning now!'
PAGE = re.compile(r'page: (http://\S+)')
PATIENCE = 90.0  # [s]
TOPIC = '/sunday/joint_states'


def main():
    """Return 0 if the stack starts, works and stops as expected."""
    process = subprocess.Popen(['ros2', 'run', 'armsim_ros', 'bringup', 'web:=true'], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    watchdog = threading.Timer(PATIENCE, process.kill)
    watchdog.start()
    printed, errors = [], ['it did not become ready']
    for line in process.stdout:
        printed.append(line)
        text = ''.join(printed)
        if READY in text and PAGE.search(text):
            try:
                errors = list(problems(PAGE.search(text).group(1)))
            finally:
                process.send_signal(signal.SIGINT)
            break
    printed += process.stdout
    status = process.wait()
    watchdog.cancel()
    if status != 0 or any('Traceback' in line for line in printed):
        errors.append(f'it ended with status {status}')
    if errors:
        sys.stdout.writelines(printed)
        print('bringup:', '; '.join(errors))
    return bool(errors)


def problems(page):
    """Yield what does not work."""
    if TOPIC not in output('ros2', 'topic', 'list').split():
        yield f'ros2 topic list lacks {TOPIC}'
    before = positions()
    output('armsim', 'go', 'scan_food')
    moved = max(abs(a - b) for a, b in zip(before, positions(), strict=True))
    if moved < 0.1:
        yield f'a plan moved the arm by {moved} rad only'
    with urlopen(page, timeout=10.0) as answer:
        if answer.status != 200 or b'<html' not in answer.read().lower():
            yield f'{page} does not answer with a page'


def positions():
    """Return the joints' positions [rad]."""
    text = output('ros2', 'topic', 'echo', '--once', '--field', 'position', TOPIC)
    return [float(number) for number in re.findall(r'-?\d+\.\d+(?:e-?\d+)?', text)]


def output(*command):
    """Return what a command prints; an error of it is shown and raised."""
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, timeout=60.0,
                          check=True).stdout


if __name__ == '__main__':
    sys.exit(main())
