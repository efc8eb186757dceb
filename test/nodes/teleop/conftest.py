# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A terminal whose keys the test presses."""

from contextlib import suppress
import os
import pty

import pytest


@pytest.fixture
def keyboard(monkeypatch):
    """Give the user's end of a terminal that is standard input."""
    user, program = pty.openpty()
    with os.fdopen(program) as stream:
        monkeypatch.setattr('sys.stdin', stream)
        yield user
    with suppress(OSError):  # a test may have hung up
        os.close(user)
