# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim teleop`` in a pseudo terminal."""

from __future__ import annotations

from contextlib import suppress
import os
import pty
import signal
import subprocess
import time

from armsim_ros.cli.environment import program_command
from armsim_ros.testing.program import ros_environment

#: Within this time a program that is to end has ended, however busy the machine is [s].
PATIENCE = 120.0


class Teleop:
    """
    The program in a terminal: what it prints, and the keys.

    :param domain: ROS domain id.
    :param arguments: those of the program.
    """

    def __init__(self, domain: int, *arguments: str) -> None:
        self.user, screen = pty.openpty()
        self._program = subprocess.Popen(
            program_command('teleop', arguments),
            env={**ros_environment(domain), 'PYTHONFAULTHANDLER': '1'}, stdin=screen,
            stdout=screen, stderr=screen)
        os.close(screen)
        os.set_blocking(self.user, False)
        self._text = b''

    @property
    def text(self) -> str:
        """What is printed so far."""
        with suppress(BlockingIOError, OSError):
            while found := os.read(self.user, 1 << 16):
                self._text += found
        return self._text.decode()

    def press(self, key: str) -> None:
        """Press a key as a terminal repeats it."""
        os.write(self.user, key.encode())
        time.sleep(0.05)

    def end(self, number: int = signal.SIGINT) -> int:
        """Send a signal and return the exit status."""
        self._program.send_signal(number)
        return self.wait()

    def wait(self) -> int:
        """Return the exit status; a program that hangs prints the stacks of its threads."""
        with suppress(subprocess.TimeoutExpired):
            return self._program.wait(PATIENCE)
        self._program.send_signal(signal.SIGABRT)
        with suppress(subprocess.TimeoutExpired):
            self._program.wait(5.0)
        raise AssertionError(f'teleop does not end: {self.text}')

    def close(self) -> None:
        """Be gone."""
        if self._program.poll() is None:
            self._program.kill()
            self._program.wait()
        os.close(self.user)
