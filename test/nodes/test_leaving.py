# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs that the middleware does not let go of."""

import subprocess
import sys

LEAVES = """
import ctypes
import time
from armsim_ros.nodes.leaving import leaving_graph

with leaving_graph({limit}):
    ctypes.PyDLL(None).{what}
print('left')
time.sleep({afterwards})
"""


def leave(limit: float, what: str, afterwards: float = 0.0) -> subprocess.CompletedProcess[str]:
    """Run a process that calls a C function with Python's lock while it leaves."""
    return subprocess.run(
        [sys.executable, '-c', LEAVES.format(limit=limit, what=what, afterwards=afterwards)],
        capture_output=True, text=True, timeout=60.0, check=False)


def test_a_process_that_the_middleware_holds_ends() -> None:
    """A call that never returns, and keeps Python's lock, ends the process with a reason."""
    ended = leave(0.5, 'pause()')
    assert ended.returncode == 1
    assert not ended.stdout
    assert 'in <module>' in ended.stderr


def test_a_process_that_leaves_in_time_goes_on() -> None:
    """What comes after the nodes may take longer."""
    ended = leave(0.5, 'getpid()', 0.7)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, 'left\n', '')
