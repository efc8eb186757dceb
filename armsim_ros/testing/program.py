# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A program under test, in a session and on a ROS domain of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
import contextlib
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from types import TracebackType
from typing import IO

import armsim_ros
from armsim_ros.cli.environment import die_with_parent, signal_group

DOMAINS = range(30, 40)
"""Low, so that all ports of a domain lie below the ephemeral ones of Linux."""


def domain_range(text: str) -> range:
    """
    Return the domain ids of a text such as ``30-39``.

    :raises ValueError: it is no such text.
    """
    first, _, last = text.partition('-')
    return range(int(first), int(last or first) + 1)


@contextmanager
def private_domain(domains: range | None = None) -> Iterator[int]:
    """
    Lease a ROS domain id for the time of the context.

    The lease is a lock on a file in the temporary folder; it ends with the process at the latest.

    :param domains: the ids to choose from; where not given, those of the environment's
        ``ARMSIM_TEST_DOMAINS=30-39``, else the usual ones.
    :raises RuntimeError: all are in use.
    """
    limits = os.environ.get('ARMSIM_TEST_DOMAINS')
    if domains is None:
        domains = domain_range(limits) if limits else DOMAINS
    folder = Path(tempfile.gettempdir())
    start = os.getpid() % len(domains)
    for domain in (*domains[start:], *domains[:start]):
        path = folder / f'armsim_ros_domain_{domain}.lock'
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except PermissionError:
            continue  # another user's
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            continue
        try:
            yield domain
        finally:
            os.close(descriptor)
        return
    raise RuntimeError(f'all ROS domains of {domains} are in use by other tests')


def ros_environment(domain: int) -> dict[str, str]:
    """Return this process' environment, changed so that ROS stays on this machine and domain."""
    return {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'PYTHONUNBUFFERED': '1',
    }


class Program:
    """
    A running program whose output is kept line by line.

    :param command: the words of the command.
    :param environment: the whole environment of the process.
    :param name: how messages call it.
    """

    def __init__(
        self, command: Sequence[str], *, environment: Mapping[str, str] | None = None,
        name: str = ''
    ) -> None:
        self.name = name or command[0]
        self.output: list[str] = []
        self._condition = threading.Condition()
        self._closed = False
        self.started = time.monotonic()
        self.process = subprocess.Popen(
            list(command), env=None if environment is None else dict(environment),
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            errors='replace', start_new_session=True,
            preexec_fn=die_with_parent(holds_sigint=False))
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @classmethod
    def module(
        cls, module: str, *arguments: str, environment: Mapping[str, str] | None = None
    ) -> Program:
        """Start ``python -m module arguments`` with this interpreter."""
        command = [sys.executable, '-m', module, *arguments]
        return cls(command, environment=environment, name=module)

    @property
    def text(self) -> str:
        """All output up to now."""
        with self._condition:
            return '\n'.join(self.output)

    def wait_for_line(self, pattern: str, timeout: float = 20.0, *, after: int = 0) -> str:
        """
        Return the first line of output that matches, waiting for it.

        :param pattern: regular expression, searched in the line.
        :param timeout: [s].
        :param after: so many lines from the start are ignored.
        :raises AssertionError: the program ended or the time is over; the text shows the output.
        """
        expression = re.compile(pattern)
        deadline = time.monotonic() + timeout
        seen = after
        with self._condition:
            while True:
                for line in self.output[seen:]:
                    if expression.search(line):
                        return line
                seen = max(seen, len(self.output))
                left = deadline - time.monotonic()
                if self._closed or left <= 0.0:
                    reason = 'ended' if self._closed else f'printed nothing like it in {timeout} s'
                    text = '\n'.join(self.output)
                    raise AssertionError(f'{self.name} {reason}: /{pattern}/\n{text}')
                self._condition.wait(left)

    def signal(self, number: int) -> None:
        """Send a signal to the program alone."""
        if self.process.poll() is None:
            self.process.send_signal(number)

    def wait(self, timeout: float = 10.0) -> int:
        """
        Wait for the end of the program and return its status.

        :param timeout: [s].
        :raises AssertionError: it still runs; the text shows the output.
        """
        try:
            status = self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(
                f'{self.name} still runs after {timeout} s\n{self.text}') from None
        self._reader.join(timeout)
        return status

    def stop(self, timeout: float = 5.0) -> int:
        """Interrupt the program and return its status; kill its whole session if it stays."""
        self.signal(signal.SIGINT)
        try:
            return self.wait(timeout)
        finally:
            self._kill_session()

    def _kill_session(self) -> None:
        signal_group(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def _read(self) -> None:
        stream: IO[str] | None = self.process.stdout
        assert stream is not None
        with stream:
            for line in stream:
                with self._condition:
                    self.output.append(line.rstrip('\n'))
                    self._condition.notify_all()
        with self._condition:
            self._closed = True
            self._condition.notify_all()

    def __enter__(self) -> Program:
        """Return the program."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None
    ) -> None:
        """Stop the program, by force where it does not obey."""
        if self.process.poll() is None:
            self.signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(5.0)
        self._kill_session()
        self._reader.join(5.0)
        if error is not None:
            print(f'--- output of {self.name} ---\n{self.text}')


def start_program(name: str, domain: int, *arguments: str) -> Program:
    """
    Start a program of the package with this interpreter.

    :param name: ``bringup``, ``simulation`` ...
    :param domain: ROS domain id.
    :param arguments: the program's arguments.
    """
    root = str(Path(armsim_ros.__file__).resolve().parent.parent)
    environment = ros_environment(domain)
    known = [entry for entry in environment.get('PYTHONPATH', '').split(os.pathsep) if entry]
    environment['PYTHONPATH'] = os.pathsep.join([root, *known])
    return Program.module('armsim_ros', name, *arguments, environment=environment)
