# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fields of operations, permissions, arguments."""

import asyncio
import json
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.bridge.calls import Goals
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.main import main
from armsim_ros.nodes.bridge.parameters import Parameters
from armsim_ros.nodes.bridge.permissions import NamePatterns, Permissions
from armsim_ros.nodes.bridge.protocol import check_fields, Protocol
from armsim_ros.nodes.bridge.settings import (
    BridgeSettings,
    help_text,
    parse_bridge_arguments,
    read_settings,
)


@pytest.mark.parametrize(('message', 'text'), [
    ({}, 'op must be one of advertise, '), ({'op': 3}, 'op must be one of '),
    ({'op': 'suscribe'}, "did you mean 'subscribe'"),
    ({'op': 'subscribe'}, 'topic is missing: string'),
    ({'op': 'subscribe', 'topic': 5}, 'topic must be: string; it is a JSON number'),
    ({'op': 'subscribe', 'topic': None}, 'topic is null'),
    ({'op': 'subscribe', 'topic': 'a', 'throttle_rate': 'x'}, 'throttle_rate must be: number'),
    ({'op': 'subscribe', 'topic': 'a', 'queue_length': True}, 'queue_length must be: integer'),
    ({'op': 'subscribe', 'topic': 'a', 'fragment_size': 10}, 'the smallest is 64'),
    ({'op': 'publish', 'topic': 'a', 'msg': []}, 'msg must be: object; it is a JSON list'),
    ({'op': 'call_service', 'service': 'a', 'id': []}, 'id must be: string or integer'),
])
def test_a_wrong_field_is_named(message, text):
    """With what it must be."""
    with pytest.raises(RefusalError, match=text):
        check_fields(message)


def test_optional_fields_may_be_null():
    """Clients send them so."""
    assert check_fields({'op': 'subscribe', 'topic': 'a', 'type': None, 'id': None}) == 'subscribe'


def test_patterns_limit_what_may_be_used():
    """What matches none is refused."""
    permissions = Permissions.of(BridgeSettings(topics_glob=('/sunday/*', '/tf')))
    permissions.check('subscribe', 'topic', '/sunday/joint_states')
    with pytest.raises(RefusalError, match='topics_glob is \\[/sunday/\\*, /tf\\]'):
        permissions.check('subscribe', 'topic', '/other')


@pytest.mark.parametrize(('message', 'answer', 'text'), [
    ({'op': 'subscribe', 'topic': '/b'}, 'status', 'subscribe /b: not allowed here: topics_glob'),
    ({'op': 'publish', 'topic': '/a'}, 'status', 'publish /a: not allowed here: read_only'),
    ({'op': 'advertise_service', 'service': '/b', 'type': 'a/B'}, 'status', 'services_glob'),
    ({'op': 'call_service', 'service': '/b'}, 'service_response', '/b: not allowed here: serv'),
    ({'op': 'call_service', 'service': '/a'}, 'service_response', '/a: not allowed here: read'),
    ({'op': 'call_service'}, 'service_response', 'service is missing: string'),
    ({'op': 'send_action_goal', 'action': '/b', 'action_type': 'a/B'}, 'action_result',
     '/b: not allowed here: actions_glob is [/a]'),
    ({'op': 'send_action_goal', 'action': '/a'}, 'action_result', 'action_type is missing'),
    ({'op': 'send_action_goal', 'action': '/a', 'action_type': 'a/B', 'fragment_size': 'x'},
     'action_result', 'fragment_size must be: integer'),
])
def test_a_refusal_is_the_answer_that_the_client_waits_for(message, answer, text):
    """A call and a goal have their result, everything else a status; each once, with its id."""
    async def run():
        link = SimpleNamespace(expand=lambda name, service=False: name)
        client = Client('', 1 << 20, 30.0, list)
        protocol = Protocol(link, Permissions.of(BridgeSettings(
            topics_glob=('/a',), services_glob=('/a',), actions_glob=('/a',), read_only=True)),
                            *(Mock() for _ in range(4)), Goals(link, False), Mock())
        await protocol.receive(client, json.dumps({**message, 'id': 5}))
        await asyncio.wait_for(client.outbox.wait(), 10.0)
        frame, = await client.outbox.take()
        assert await client.outbox.take() == []
        return json.loads(frame[frame.index(b'{"'):])

    found = asyncio.run(run())
    assert (found['op'], found['id']) == (answer, 5)
    assert text in found['msg' if answer == 'status' else 'values']
    assert answer == 'status' or found['result'] is False


@pytest.mark.parametrize(('op', 'kind', 'name', 'allowed'), [
    ('subscribe', 'topic', '/a', True), ('publish', 'topic', '/a', False),
    ('advertise', 'topic', '/a', False), ('send_action_goal', 'action', '/a', False),
    ('call_service', 'service', '/rosapi/topics', True),
    ('call_service', 'service', '/rosapi/set_param', False),
    ('call_service', 'service', '/get_planning_scene', True),
    ('call_service', 'service', '/move_group/list_parameters', True),
    ('call_service', 'service', '/get', False),
    ('call_service', 'service', '/apply_planning_scene', False),
])
def test_read_only_lets_nothing_move(op, kind, name, allowed):
    """Questions are answered, commands are refused."""
    permissions = Permissions.of(BridgeSettings(read_only=True))
    if allowed:
        permissions.check(op, kind, name)
    else:
        with pytest.raises(RefusalError, match='read_only'):
            permissions.check(op, kind, name)


def test_parameters_have_patterns_of_their_own():
    """What matches none is not read (rosapi's params_glob)."""
    link = SimpleNamespace(expand=lambda name: name)
    patterns = NamePatterns.globs('params_glob', ('/arm:*',))
    with pytest.raises(RefusalError, match='params_glob is \\[/arm:\\*\\]'):
        asyncio.run(Parameters(link, patterns).value('/move_group:name'))


@pytest.mark.parametrize('pattern', ['robot_desc*', '/arm:robot_description', '/a*:*'])
def test_a_parameter_matches_with_or_without_its_node(pattern):
    """Re-enacts rosapi's params.py: get_param matches the name, get_param_names both."""
    link = SimpleNamespace(expand=lambda name: name, service_types=dict)
    patterns = NamePatterns.globs('params_glob', ('/other', pattern))
    with pytest.raises(RefusalError, match='no node /arm'):  # allowed, but not there
        asyncio.run(Parameters(link, patterns).value('/arm:robot_description'))


def settings_of(*words):
    """Return the settings of a command line, without a node."""
    given, _ = parse_bridge_arguments(words)
    return read_settings(given, lambda _, value: value)


def test_arguments_become_settings():
    """Lists as rosbridge_server writes them; what changes nothing is named."""
    found, unused = settings_of('port:=0', 'topics_glob:=[/sunday/*, "/tf"]', '--read_only',
                                'true', 'use_compression:=true', 'origins:=https://a.example,null')
    assert found == BridgeSettings(
        port=0, topics_glob=('/sunday/*', '/tf'), read_only=True,
        origins=('https://a.example', 'null'))
    assert unused == ['use_compression']
    assert settings_of() == (BridgeSettings(), [])


@pytest.mark.parametrize(('word', 'text'), [
    ('prot:=1', "did you mean 'port'"), ('port:=x', "port is 'x'; allowed: a number from 0"),
    ('port:=70000', 'from 0 to 65535'), ('read_only:=maybe', 'allowed: true, false'),
    ('foxglove:=on_off', 'allowed: false, read, control'),
    ('bson_only_mode:=true', 'bson_only_mode is not supported'),
    ('certfile:=a.pem', 'certfile and keyfile are given together'),
])
def test_a_wrong_argument_is_named(word, text):
    """With what is allowed."""
    with pytest.raises(UsageError, match=text):
        settings_of(word)


def test_help_has_every_argument(capsys):
    """Each with its default; nothing is started, and all is well."""
    assert main(['--help']) == 0
    assert capsys.readouterr().out.strip() == help_text().strip()
    assert 'max_client_backlog:=VALUE' in help_text()
    assert '(default: 9090)' in help_text()
