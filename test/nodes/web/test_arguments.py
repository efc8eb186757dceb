# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page's command line."""

from pathlib import Path

import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.web.main import parse_web_arguments


def test_alone_it_listens_to_this_machine():
    """Nothing has to be said."""
    arguments = parse_web_arguments([])
    assert (arguments.host, arguments.port, arguments.token) == ('127.0.0.1', 8080, '')


def test_all_spellings_say_the_same():
    """As for every program of the package."""
    wanted = parse_web_arguments(['port:=9000', 'near:=/a/b.urdf:/c'])
    assert wanted.near == (Path('/a/b.urdf'), Path('/c'))
    assert parse_web_arguments(['--port', '9000', '--near=/a/b.urdf:/c']) == wanted


@pytest.mark.parametrize(('words', 'text'), [
    (['prot:=1'], "did you mean 'port'?"),
    (['port:=many'], 'a number from 1 to 65535'),
    (['port:=0'], 'a number from 1 to 65535'),
    (['token:='], "'token' needs a value"),
    (['--host'], "'host' needs a value"),
])
def test_a_wrong_word_is_answered_with_the_right_one(words, text):
    """One sentence, no traceback."""
    with pytest.raises(UsageError) as error:
        parse_web_arguments(words)
    assert text in str(error.value)
