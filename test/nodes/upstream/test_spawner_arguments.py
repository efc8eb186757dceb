# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The forms of the spawner's command line, by controller_manager's spawner.py."""

import pytest

from armsim_ros.nodes.upstream.spawner_arguments import ControllerRequest, parse_spawner_arguments


def test_names_share_their_options():
    """Without --controller, the options hold for all names (parse_native_args)."""
    request = parse_spawner_arguments(
        ['a', 'b', '-p', 'x.yaml', '--param-file', 'y.yaml', '--inactive', '-c', 'manager',
         '--controller-ros-args', '-r x:=y', '--controller-ros-args', '-p z:=1'])
    common = {'files': ('x.yaml', 'y.yaml'), 'inactive': True,
              'ros_args': ('-r x:=y', '-p z:=1')}
    assert request.controllers == tuple(ControllerRequest(name, **common) for name in 'ab')
    assert request.options.controller_manager == 'manager'
    assert request.options.switch_asap
    assert not request.options.unload_on_kill


def test_blocks_have_options_of_their_own():
    """After --controller NAME, options are those of that controller (parse_args_advanced)."""
    request = parse_spawner_arguments(
        ['-c', 'manager', '--controller', 'a', '-p', 'x.yaml', '-p', 'y.yaml', '--load-only',
         '--controller', 'b', '--inactive', '--controller-ros-args', '-r x:=y',
         '--controller', 'c', '-u', '--switch-timeout', '2', '--activate-as-group'])
    assert request.controllers == (
        ControllerRequest('a', ('x.yaml', 'y.yaml'), load_only=True),
        ControllerRequest('b', inactive=True, ros_args=('-r x:=y',)),
        ControllerRequest('c'))
    options = request.options
    assert (options.controller_manager, options.switch_timeout) == ('manager', 2.0)
    assert options.unload_on_kill
    assert options.activate_as_group
    assert not options.switch_asap


def test_words_of_no_block_are_ignored():
    """Options of a controller before the first block are ignored with a warning."""
    request = parse_spawner_arguments(['-p', 'x.yaml', '--controller', 'a', '--typo'])
    assert request.controllers == (ControllerRequest('a'),)
    assert request.ignored == ('-p', 'x.yaml', '--typo')


@pytest.mark.parametrize('words', [
    [], ['a', '-t', 'kind'], ['--controller'], ['--controller', 'a', '--controller'],
    ['a', '--switch-timeout', 'soon'],
    ['a', '--controller-ros-args', '-r', 'x:=y']])
def test_wrong_words(words, capsys):
    """Without a controller, or with an option that does not exist, the status is 2."""
    with pytest.raises(SystemExit) as ended:
        parse_spawner_arguments(words)
    assert ended.value.code == 2
    assert 'usage: spawner NAME' in capsys.readouterr().err


def test_help_has_both_forms(capsys):
    """--help explains both forms."""
    for words in (['-h'], ['--controller', '-h']):
        with pytest.raises(SystemExit) as ended:
            parse_spawner_arguments(words)
        assert ended.value.code == 0
        text = capsys.readouterr().out
        assert '--controller NAME' in text
        assert '--controller-ros-args' in text
