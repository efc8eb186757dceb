# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Failures told when they happen: a run that is ended early leaves what it knew."""

import os

import pytest


class FailuresAtOnce:
    """
    A plugin that prints each failure, beside the list that pytest prints at its end.

    :param config: of pytest.
    """

    def __init__(self, config):
        self._plugins = config.pluginmanager

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logreport(self, report):
        """Print the failure, unless another process of this run does."""
        terminal = self._plugins.getplugin('terminalreporter')
        if report.failed and terminal and 'PYTEST_XDIST_WORKER' not in os.environ:
            terminal.write_line(f'\n{report.nodeid} ({report.when})\n{report.longreprtext}')
