# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Ends worker processes of pytest-xdist that say nothing any more, whatever holds them."""

import os
import threading

import pytest

#: Longer than a test may take by itself, see ``timeout`` and ``faulthandler_timeout`` [s].
LONGEST_SILENCE = 600.0


class SilentWorkers:
    """
    A plugin that kills all workers when none has reported for long; pytest-xdist replaces them.

    :param longest: silence that is waited for [s].
    """

    def __init__(self, longest=LONGEST_SILENCE):
        self._longest = longest
        self._workers = []
        self._running = set()
        self._heard = threading.Event()
        self._over = False

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodeready(self, node):
        """Note a worker; the first one begins the watch."""
        if not self._workers:
            threading.Thread(target=self._watch, daemon=True).start()
        self._workers.append(node)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        """Forget a worker that has ended."""
        self._workers.remove(node)

    def pytest_runtest_logstart(self, nodeid):
        """Note a test that begins."""
        self._running.add(nodeid)
        self._heard.set()

    def pytest_runtest_logreport(self, report):
        """Note that somebody is alive."""
        if report.when == 'teardown':
            self._running.discard(report.nodeid)
        self._heard.set()

    def pytest_sessionfinish(self):
        """End the watch."""
        self._over = True
        self._heard.set()

    def _watch(self):
        while not self._over:
            self._heard.clear()
            if self._heard.wait(self._longest):
                continue
            os.write(2, f'no worker has reported for {self._longest:.0f} s; they are killed. '
                        f'Not ended: {sorted(self._running)}\n'.encode())
            for worker in list(self._workers):
                worker.gateway._io.kill()
