# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The server of Foxglove in the test's own process, for a graph that the test gives."""

import asyncio
import json

import pytest

pytest.importorskip('foxglove')

from websockets.asyncio.client import connect

from armsim_ros.nodes.bridge.foxglove_rules import FoxgloveRules
from armsim_ros.nodes.bridge.foxglove_server import FoxgloveServer
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.package_files import PackageFiles
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.packages import Packages

TOPICS = {'/custom': ['missing_msgs/msg/Custom'], '/twin': ['missing_msgs/msg/Custom'],
          '/known': ['std_msgs/msg/String']}
PATIENCE = 15.0


class Graph(BridgeLink):
    """A link that sees topics of a type that is not installed."""

    def topic_types(self):
        """Return them before the known ones."""
        return TOPICS


async def offered(settings):
    """Return topic -> its channel as a client gets it."""
    with Graph('viewer', (), asyncio.get_running_loop()) as link:
        server = FoxgloveServer(link, settings, FoxgloveRules.of(settings), '',
                                PackageFiles(link, Packages()))
        try:
            await server.open()
            channels = {}
            async with connect(server.url, subprotocols=['foxglove.sdk.v1']) as connection:
                while len(channels) < len(TOPICS):
                    message = json.loads(await asyncio.wait_for(connection.recv(), PATIENCE))
                    channels.update((channel['topic'], channel)
                                    for channel in message.get('channels', ()))
            return channels
        finally:
            server.close()


def test_a_type_without_a_definition_hides_no_other_topic(capfd):
    """Re-enacts ros2_foxglove_bridge.cpp, updateAdvertisedTopics: an empty schema, a warning."""
    channels = asyncio.run(offered(BridgeSettings(foxglove='read', foxglove_port=0)))
    assert {name: (channel['schemaName'], channel['schema'].strip())
            for name, channel in channels.items()} == {
        '/custom': ('missing_msgs/msg/Custom', ''), '/twin': ('missing_msgs/msg/Custom', ''),
        '/known': ('std_msgs/msg/String', 'string data')}
    warning = 'topics of missing_msgs/msg/Custom are offered without its definition'
    assert capfd.readouterr().err.count(warning) == 1
