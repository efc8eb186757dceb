# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shutdown of programs that the middleware blocks."""

import subprocess
import sys

SHUTS_DOWN = """
import ctypes
import time
from armsim_ros.nodes.shutdown import bounded_shutdown

with bounded_shutdown({limit}):
    ctypes.PyDLL(None).{what}
print('done')
time.sleep({afterwards})
"""


def shut_down(
    limit: float, what: str, afterwards: float = 0.0
) -> subprocess.CompletedProcess[str]:
    """Run a process that calls a C function with Python's lock while it shuts down."""
    return subprocess.run(
        [sys.executable, '-c', SHUTS_DOWN.format(limit=limit, what=what, afterwards=afterwards)],
        capture_output=True, text=True, timeout=60.0, check=False)


def test_a_process_that_is_blocked_ends() -> None:
    """A call that never returns, and keeps Python's lock, ends the process with a reason."""
    ended = shut_down(0.5, 'pause()')
    assert ended.returncode == 1
    assert not ended.stdout
    assert 'in <module>' in ended.stderr


def test_a_process_that_shuts_down_in_time_goes_on() -> None:
    """What comes after the nodes may take longer."""
    ended = shut_down(0.5, 'getpid()', 0.7)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, 'done\n', '')
