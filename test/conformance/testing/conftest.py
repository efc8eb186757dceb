# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs small test files as a stranger's folder has them."""

from dataclasses import dataclass
import os
from pathlib import Path
import re
import subprocess
import sys
from textwrap import dedent

import pytest

ROOT = str(Path(__file__).parents[3])
#: A stranger's pytest that neither writes a cache nor imports what its tests do not use.
OPTIONS = '-p no:cacheprovider -p no:hypothesispytest'


def pytest_configure(config):
    """Register the mark that names a statement."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@dataclass(frozen=True)
class FileOfTests:
    """
    What came of a file of tests.

    :param folder: where it ran.
    :param text: what pytest printed.
    """

    folder: Path
    text: str

    def outcome(self, test):
        """Return what became of a test: ``passed``, ``failed`` or ``error``."""
        line = re.search(rf'^(PASSED|FAILED|ERROR) \S+::{test}\b', self.text, re.MULTILINE)
        assert line, self.text
        return line[1].lower()

    def told(self, test):
        """Return the report of a test that failed."""
        report = re.search(rf'^_+ (?:ERROR at setup of )?{test} _+$(.*?)^(?:_{{9}}|={{9}})',
                           self.text, re.MULTILINE | re.DOTALL)
        assert report, self.text
        return report[1]


@pytest.fixture(scope='module')
def run_file(tmp_path_factory):
    """Return a function that runs several tests of a file in one process, to look at each."""
    environment = {key: value for key, value in os.environ.items() if 'PYTEST' not in key}
    environment |= {'PYTHONPATH': ROOT, 'PYTEST_ADDOPTS': OPTIONS}

    def run(text, *options):
        folder = tmp_path_factory.mktemp('stranger')
        (folder / 'test_it.py').write_text(dedent(text))
        run = subprocess.run(
            [sys.executable, '-m', 'pytest', '-rA', *options], cwd=folder, env=environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return FileOfTests(folder, run.stdout)

    return run


@pytest.fixture
def strangers_pytest(pytester, monkeypatch):
    """Have every pytest that a test starts find the package, as one that has it installed."""
    monkeypatch.setenv('PYTHONPATH', ROOT)
    monkeypatch.setenv('PYTEST_ADDOPTS', OPTIONS)


@pytest.fixture
def run_tests(pytester, strangers_pytest):
    """Return a function that runs the text of a test file in a process and folder of its own."""
    def run(text, *options):
        pytester.makepyfile(text)
        return pytester.runpytest_subprocess(*options)

    return run


@pytest.fixture
def new_arm():
    """Return a function that gives the default robot at its start, stepped by the test."""
    from armsim_ros.testing.in_process import InProcessArm
    from armsim_ros.testing.stacks import built_cell

    return lambda **options: InProcessArm(built_cell('sunday', None, {}), **options)
