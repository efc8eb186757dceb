# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The server of Foxglove in the test's own process, for a graph that the test gives."""

import asyncio
from contextlib import asynccontextmanager
import itertools
import json
import socket

import pytest

pytest.importorskip('foxglove')

from rclpy.parameter import Parameter
from websockets.asyncio.client import connect

from armsim_ros.nodes.bridge.configuration import BRIDGE, FOXGLOVE_BRIDGE
from armsim_ros.nodes.bridge.foxglove_rules import FoxgloveRules
from armsim_ros.nodes.bridge.foxglove_server import FoxgloveServer
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.package_files import PackageFiles
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.ports import ServingError
from armsim_ros.packages import Packages

TOPICS = {'/custom': ['missing_msgs/msg/Custom'], '/twin': ['missing_msgs/msg/Custom'],
          '/known': ['std_msgs/msg/String']}
PATIENCE = 15.0


class Graph(BridgeLink):
    """A link that sees topics of a type that is not installed."""

    def topic_types(self):
        """Return them before the known ones."""
        return TOPICS


class Viewer:
    """A client of the server."""

    def __init__(self, connection):
        self._connection = connection

    async def send(self, op, **fields):
        """Send an operation."""
        await self._connection.send(json.dumps({'op': op, **fields}))

    async def receive(self, op):
        """Return the next message of an operation."""
        while True:
            frame = await asyncio.wait_for(self._connection.recv(), PATIENCE)
            if isinstance(frame, str) and (message := json.loads(frame))['op'] == op:
                return message


@asynccontextmanager
async def viewing(link, settings, interface=BRIDGE):
    """Give a client of a program's server that is up meanwhile."""
    server = FoxgloveServer(link, settings, FoxgloveRules.of(settings), '',
                            PackageFiles(link, Packages()), interface.foxglove_port)
    try:
        await server.open()
        async with connect(server.url, subprotocols=['foxglove.sdk.v1']) as connection:
            yield Viewer(connection)
    finally:
        server.close()


async def offered(settings):
    """Return topic -> its channel as a client gets it."""
    channels = {}
    with Graph('viewer', (), asyncio.get_running_loop()) as link:
        async with viewing(link, settings) as viewer:
            while len(channels) < len(TOPICS):
                message = await viewer.receive('advertise')
                channels.update((channel['topic'], channel) for channel in message['channels'])
    return channels


async def published(settings, followed):
    """Return the names of the first of the bridge's own parameters that a client is sent."""
    with BridgeLink('viewer', (), asyncio.get_running_loop()) as link:
        for name in followed:
            link.node.declare_parameter(name, 0)
        async with viewing(link, settings) as viewer:
            await viewer.send('subscribeParameterUpdates',
                              parameterNames=[f'/viewer.{name}' for name in followed])
            for count in itertools.count(1):
                # Each is an event of its own; the first come before the server listens.
                link.node.set_parameters([Parameter(name, value=count) for name in followed])
                await viewer.send('getParameters', parameterNames=[], id='after')
                message = await viewer.receive('parameterValues')
                if message.get('id') != 'after':
                    return [parameter['name'] for parameter in message['parameters']]


def test_a_type_without_a_definition_hides_no_other_topic(capfd):
    """Re-enacts ros2_foxglove_bridge.cpp, updateAdvertisedTopics: an empty schema, a warning."""
    channels = asyncio.run(offered(BridgeSettings(foxglove='read', foxglove_port=0)))
    assert {name: (channel['schemaName'], channel['schema'].strip())
            for name, channel in channels.items()} == {
        '/custom': ('missing_msgs/msg/Custom', ''), '/twin': ('missing_msgs/msg/Custom', ''),
        '/known': ('std_msgs/msg/String', 'string data')}
    warning = 'topics of missing_msgs/msg/Custom are offered without its definition'
    assert capfd.readouterr().err.count(warning) == 1


def test_changes_of_parameters_that_may_not_be_used_are_not_published():
    """Re-enacts parameter_interface.cpp, subscribeParams: what is whitelisted is followed."""
    settings = BridgeSettings(foxglove='read', foxglove_port=0, params_glob=('shown',))
    assert asyncio.run(published(settings, ('secret', 'shown'))) == ['/viewer.shown']


async def refusal(settings, interface):
    """Return why a program's server cannot be opened."""
    with (BridgeLink('viewer', (), asyncio.get_running_loop()) as link,
          pytest.raises(ServingError) as refused):
        async with viewing(link, settings, interface):
            pass
    return str(refused.value)


@pytest.mark.parametrize('interface', [BRIDGE, FOXGLOVE_BRIDGE], ids=lambda each: each.node)
def test_a_taken_port_is_an_error_with_an_argument_that_the_program_takes(interface):
    """The two programs name the port of Foxglove differently."""
    with socket.create_server(('127.0.0.1', 0)) as taken:
        text = asyncio.run(refusal(
            BridgeSettings(foxglove='read', foxglove_port=taken.getsockname()[1]), interface))
    word, _, _ = text.rpartition('; ')[2].partition(' takes any free port')
    given, _ = interface.parse([word])
    assert interface.read(given, lambda name, value: value).settings.foxglove_port == 0
