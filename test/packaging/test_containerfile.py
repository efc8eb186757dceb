# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the Containerfile starts exists."""

import json
from pathlib import Path
import re

import pytest

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.nodes.bringup.main import page_command

ROOT = Path(__file__).parent.parent.parent
TEXT = (ROOT / 'Containerfile').read_text()


@pytest.fixture
def command():
    """Return the words of an instruction, given as JSON."""
    return lambda name: json.loads(re.search(rf'^{name} (\[.*\])$', TEXT, re.MULTILINE).group(1))


def test_the_default_command_serves_the_page_to_other_machines(command):
    """Bringup takes the arguments, and its page listens on all addresses."""
    assert command('ENTRYPOINT') == ['armsim']
    program, *words = command('CMD')
    assert program == 'bringup'
    page, = page_command(parse_arguments(words)).values()
    assert 'host:=0.0.0.0' in page


@pytest.mark.parametrize('file', ['README.md', '.ci/dist'])
def test_the_image_installs_what_is_documented_and_tested(file):
    """The same requirement, found in dist/ (run in an empty environment by .ci/dist)."""
    (wanted,) = re.findall(r"pip install .*--find-links /dist ('\S+')", TEXT)
    assert f'--find-links dist {wanted}' in (ROOT / file).read_text()


def test_the_image_has_no_compiler_and_no_root():
    """Only a library comes from the distribution, and the arm runs as a user."""
    assert re.findall(r'--no-install-recommends (.*?) \\', TEXT) == ['libgomp1']
    assert re.search(r'^USER arm$', TEXT, re.MULTILINE)
