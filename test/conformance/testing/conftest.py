# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs small test files as a stranger's folder has them."""

from pathlib import Path

import pytest

ROOT = str(Path(__file__).parents[3])


def pytest_configure(config):
    """Register the mark that names a statement."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@pytest.fixture
def run_tests(pytester, monkeypatch):
    """Return a function that runs the text of a test file in a process and folder of its own."""
    monkeypatch.setenv('PYTHONPATH', ROOT)

    def run(text, *options):
        pytester.makepyfile(text)
        return pytester.runpytest_subprocess('-p', 'no:cacheprovider', *options)

    return run


@pytest.fixture
def new_arm():
    """Return a function that gives the default robot at its start, stepped by the test."""
    from armsim_ros.testing.arms.built_cell import built_cell
    from armsim_ros.testing.arms.in_process import InProcessArm

    return lambda **options: InProcessArm(built_cell('sunday', None, {}), **options)
