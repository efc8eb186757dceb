# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of foxglove_bridge, as rules."""

import pytest

from armsim_ros.cli.arguments import UsageError
from armsim_ros.nodes.bridge.configuration import BRIDGE, FOXGLOVE_BRIDGE
from armsim_ros.nodes.bridge.foxglove_rules import FoxgloveRules
from armsim_ros.nodes.bridge.settings import BridgeSettings

READING = {'connectionGraph', 'parametersSubscribe', 'parameters', 'assets'}


def configured(*words, interface=FOXGLOVE_BRIDGE, **parameters):
    """Return what a program reads from its command line and from parameters of a launch file."""
    given, _ = interface.parse(words)
    return interface.read(given, lambda name, value: parameters.get(name, value))


def test_foxglove_bridge_serves_foxglove_alone_and_lets_clients_do_all():
    """Re-enacts param_utils.cpp, declareParameters: all capabilities, all names."""
    found = configured()
    assert (found.rosbridge, found.unused, found.settings.foxglove_port) == (False, [], 8765)
    assert found.foxglove.capabilities == READING | {'clientPublish', 'services'}
    assert found.foxglove.sets_parameters
    for kind in ('topic', 'client_topic', 'service'):
        found.foxglove.permissions.check('publish', kind, '/any')


def test_the_port_is_that_of_foxglove():
    """Of the command line, and of a launch file."""
    assert configured('port:=0').settings.foxglove_port == 0
    assert configured(port=8766).settings.foxglove_port == 8766


def test_capabilities_limit_what_clients_do():
    """Re-enacts ros2_foxglove_bridge.cpp: without them, nobody publishes, calls or sets."""
    rules = configured(capabilities=['connectionGraph', 'assets']).foxglove
    assert rules.capabilities == {'connectionGraph', 'assets'}
    assert not rules.controls
    assert configured(capabilities=['parameters']).foxglove.sets_parameters
    assert configured('capabilities:=[]').foxglove.capabilities == set()


@pytest.mark.parametrize(('argument', 'kind'), [
    ('topic_whitelist', 'topic'), ('service_whitelist', 'service'),
    ('client_topic_whitelist', 'client_topic')])
def test_a_whitelist_limits_names_of_its_kind_alone(argument, kind):
    """Re-enacts regex_utils.hpp, isWhitelisted: the whole name, upper or lower case."""
    permissions = configured(**{argument: ['/Arm/.{1,3}', '/tf']}).foxglove.permissions
    matching = {name for name in ('/arm/x', '/arm/long', '/tf', '/tf_static')
                if permissions.matches(kind, name)}
    assert matching == {'/arm/x', '/tf'}
    others = {'topic', 'service', 'client_topic'} - {kind}
    assert all(permissions.matches(other, '/tf_static') for other in others)


def test_parameters_are_whitelisted_with_their_node():
    """Re-enacts parameter_interface.cpp, getNodeParameters: the name is /node.parameter."""
    patterns = configured(param_whitelist=[r'/arm\.max.*']).foxglove.permissions.parameters
    assert patterns.allows_parameter('/arm', 'max_speed')
    assert not patterns.allows_parameter('/arm', 'name')
    assert not patterns.allows_parameter('/base', 'max_speed')


def test_a_list_of_the_command_line_is_yaml():
    """Its expressions may have commas; a text is an expression by itself."""
    permissions = configured("topic_whitelist:=['/a{1,2}', /b]", 'service_whitelist:=/[cd]'
                             ).foxglove.permissions
    assert permissions.topics.texts == ('/a{1,2}', '/b')
    assert permissions.services.texts == ('/[cd]',)


def test_an_expression_that_is_not_one_is_an_error():
    """It would otherwise be unclear what clients may use."""
    with pytest.raises(UsageError, match=r"topic_whitelist: '\(' is not a regular expression"):
        configured(topic_whitelist=['('])


def test_a_certificate_counts_with_tls_alone():
    """Re-enacts ros2_foxglove_bridge.cpp: the server options useTls, certfile, keyfile."""
    files = {'certfile': 'a.pem', 'keyfile': 'b.pem'}
    assert configured(**files).settings.certfile == ''
    assert configured(**files, tls=True).settings.certfile == 'a.pem'
    with pytest.raises(UsageError, match='tls:=true needs certfile'):
        configured('tls:=true')


def test_what_has_no_effect_is_named():
    """Where it is not what upstream has anyway."""
    found = configured('capabilities:=[services, playbackControl]', send_buffer_limit=10_000_000,
                       max_qos_depth=5)
    assert found.unused == ['max_qos_depth', 'capabilities playbackControl']


def test_the_bridge_lets_clients_of_foxglove_read_or_control():
    """By its argument foxglove, within its own patterns."""
    assert configured(interface=BRIDGE).foxglove is None
    reading = configured('foxglove:=read', 'topics_glob:=[/a*]', interface=BRIDGE).foxglove
    assert (reading.capabilities, reading.controls) == (READING, False)
    assert not reading.permissions.matches('topic', '/b')
    assert FoxgloveRules.of(BridgeSettings(foxglove='control')).controls


def test_help_has_the_parameters_of_foxglove_bridge():
    """And its port."""
    text = FOXGLOVE_BRIDGE.help_text()
    assert 'topic_whitelist:=VALUE' in text
    assert '(default: 8765)' in text
    assert 'topics_glob' not in text
