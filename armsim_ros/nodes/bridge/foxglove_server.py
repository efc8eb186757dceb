# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The server of Foxglove: a channel for each topic, serialized messages in and out."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
import secrets
import traceback
from typing import Any
from urllib.parse import unquote, urlsplit

import foxglove
from foxglove.websocket import Capability, ServerListener
from rclpy.qos import QoSDurabilityPolicy, QoSReliabilityPolicy

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.access import Gate
from armsim_ros.nodes.bridge.foxglove_commands import (
    Commands,
    ENCODING,
    ENCODINGS,
    SharedParameters,
)
from armsim_ros.nodes.bridge.foxglove_rules import (
    ASSETS,
    CLIENT_PUBLISH,
    CONNECTION_GRAPH,
    FoxgloveRules,
    PARAMETERS,
    PARAMETERS_SUBSCRIBE,
    SERVICES,
)
from armsim_ros.nodes.bridge.graph_view import GraphView
from armsim_ros.nodes.bridge.interfaces import load
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.package_files import PackageFiles
from armsim_ros.nodes.bridge.parameters import Parameters
from armsim_ros.nodes.bridge.publications import Publications
from armsim_ros.nodes.bridge.server import bridge_rules, bridge_url, tls
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.bridge.topic_reader import Batch, TopicReader
from armsim_ros.nodes.ports import ServingError
from armsim_ros.recording.message_definitions import message_definition

#: How often changes of the graph are noticed [s].
_RENEWAL = 0.5
#: How often simulated time is sent while it moves and a client is connected [s].
_TICK = 1 / 60
#: How long the SDK's threads wait for an answer of the graph [s].
_PATIENCE = 3.0
#: Foxglove's own pages, and its program for desktops, whose origin is that of any local file.
_APP, _DESKTOP = ('https://app.foxglove.dev', 'https://studio.foxglove.dev'), 'file://'
#: Capabilities of the SDK, and those of foxglove_bridge that need them.
_CAPABILITIES = (
    (Capability.ClientPublish, {CLIENT_PUBLISH}), (Capability.Services, {SERVICES}),
    (Capability.ConnectionGraph, {CONNECTION_GRAPH}),
    (Capability.Parameters, {PARAMETERS, PARAMETERS_SUBSCRIBE}))
#: The reader of topics that are recorded in any case.
_RECORDING = 'mcap'


@dataclass
class Topic:
    """A channel, and the clients and the recording that read it."""

    type_name: str
    channel: Any
    readers: set[Any] = field(default_factory=set)
    is_latched: bool = False
    publications: Publications[bytes] = field(default_factory=Publications)


class FoxgloveServer(ServerListener):
    """
    Serves until it is closed; the callbacks come in threads of the SDK.

    The SDK checks no Host, Origin or token. So it listens at a random loopback address, which no
    page can find, and a gate with the rules of the bridge passes connections on to it.

    :param settings: of the port and the recording.
    :param rules: what clients may do.
    :param token: what a client must bring; '' admits all.
    """

    def __init__(self, link: BridgeLink, settings: BridgeSettings, rules: FoxgloveRules,
                 token: str, files: PackageFiles, port_argument: str) -> None:
        self._link, self._settings, self._token, self._files = link, settings, token, files
        self._rules, self._permissions = rules, rules.permissions
        self._graph = GraphView(link, rules.permissions, include_hidden=rules.include_hidden)
        self._port, self._port_argument = settings.foxglove_port, port_argument
        self._gate: Gate | None = None
        self._recording: Any = None
        self._context = foxglove.Context()
        self._topics: dict[str, Topic] = {}
        self._schemas: dict[str, foxglove.Schema] = {}
        self._shows_graph = False
        self._server: Any = None
        self._commands = Commands(link, rules.permissions, self._report)
        self._tasks: list[asyncio.Task[None]] = []
        self._reader = TopicReader(link, self._deliver)
        self._parameters = SharedParameters(
            link, Parameters(link, rules.permissions.parameters,
                             ignores_silent=rules.ignores_silent_nodes),
            lambda values: self._server.publish_parameter_values(values), self._report)

    @property
    def url(self) -> str:
        """What a client connects to."""
        return bridge_url(self._settings, self._token, self._port)

    async def open(self) -> None:
        """
        Open the port.

        :raises ServingError: it is taken, or the recording cannot be written.
        """
        settings = self._settings
        if settings.mcap:
            try:
                self._recording = foxglove.open_mcap(settings.mcap, context=self._context)
            except OSError as error:
                raise ServingError(f'mcap {settings.mcap} cannot be written: {error}') from None
        capabilities = [capability for capability, names in _CAPABILITIES
                        if names & self._rules.capabilities]
        if self._uses_sim_time():
            capabilities.append(Capability.Time)
        host = f'127.{_byte()}.{_byte()}.{_byte()}'
        self._server = foxglove.start_server(
            name='armsim', host=host, port=0,
            capabilities=capabilities, supported_encodings=list(ENCODINGS),
            server_listener=self, asset_handler=self._asset if self._can(ASSETS) else None,
            context=self._context)
        rules = bridge_rules(settings, self._token, self._port,
                             origins=_APP if self._rules.controls else (*_APP, _DESKTOP))
        self._gate = Gate(rules, (host, self._server.port), settings.max_clients)
        try:
            self._port = await self._gate.open(settings.address, self._port, tls(settings))
        except ServingError as error:
            raise ServingError(
                f'{error}; {self._port_argument}:=0 takes any free port') from None
        self._tasks = [self._link.loop.create_task(work)
                       for work in (self._renew(), self._follow_time())]

    def close(self) -> None:
        """Close the port and all subscriptions."""
        if self._gate is not None:
            self._gate.close()
        for task in self._tasks:
            task.cancel()
        self._reader.close()
        self._commands.close()
        if self._server is not None:
            self._server.stop()
        if self._recording is not None:
            self._recording.close()

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """Read a topic for a client."""
        self._link.schedule(partial(self._subscribe, channel.topic, client.id))

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """Read a topic for a client no more."""
        self._link.schedule(partial(self._unsubscribe, channel.topic, client.id))

    def on_get_parameters(self, client: Any, param_names: list[str],
                          request_id: str | None = None) -> list[Any]:
        """Return parameters, all where no names are given."""
        if not self._can(PARAMETERS):
            return []
        return self._wait(self._parameters.read(param_names)) or []

    def on_set_parameters(self, client: Any, parameters: list[Any],
                          request_id: str | None = None) -> list[Any]:
        """Set parameters where that is allowed, and return what they are then."""
        if self._rules.sets_parameters:
            self._wait(self._parameters.write(parameters))
        return self.on_get_parameters(client, [each.name for each in parameters])

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        """Publish these parameters as they change."""
        if self._can(PARAMETERS_SUBSCRIBE):
            self._link.schedule(partial(self._parameters.follow, param_names))

    def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
        """Publish these parameters no more."""
        self._link.schedule(partial(self._parameters.forget, param_names))

    def on_connection_graph_subscribe(self) -> None:
        """Publish the connection graph."""
        self._shows_graph = True

    def on_connection_graph_unsubscribe(self) -> None:
        """Publish the connection graph no more."""
        self._shows_graph = False

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        """Make a publisher."""
        if self._can(CLIENT_PUBLISH):
            self._link.schedule(partial(
                self._commands.advertise, (client.id, channel.id), channel.topic,
                channel.schema_name, channel.encoding))

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        """Take a publisher away."""
        self._link.schedule(partial(
            self._commands.unadvertise, (client.id, client_channel_id)))

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        """Publish."""
        self._link.schedule(partial(self._commands.publish, (client.id, client_channel_id), data))

    def _subscribe(self, name: str, reader: Any) -> None:
        """
        Read a topic, and send the latched message of each publisher again.

        :param reader: the client's id, or what else reads it.
        """
        topic = self._topics.get(name)
        if topic is None:
            return
        if topic.readers:
            topic.readers.add(reader)
            for content in topic.publications.latched():
                topic.channel.log(content, log_time=self._now())
            return
        try:
            kind = load(topic.type_name, 'msg')
        except ArmsimError:
            return
        profile = self._link.matching_profile(name)
        if self._rules.best_effort.allows(name):
            profile.reliability = QoSReliabilityPolicy.BEST_EFFORT
        topic.readers.add(reader)
        topic.is_latched = profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
        self._reader.add(name, kind, name, profile)

    def _unsubscribe(self, name: str, reader: Any) -> None:
        """Read a topic no more, where no reader is left."""
        topic = self._topics.get(name)
        if topic is not None and reader in topic.readers:
            topic.readers.discard(reader)
            if not topic.readers:
                topic.publications.drop_latched()
                self._reader.remove(name)

    def _asset(self, uri: str) -> bytes | None:
        try:
            parts = urlsplit(uri)
        except ValueError:
            return None
        if parts.scheme != 'package' or not self._rules.assets.allows(uri):
            return None
        found: bytes | None = self._wait(self._files.read(
            unquote(parts.netloc), unquote(parts.path.lstrip('/'))))
        return found

    def _wait(self, work: Any) -> Any:
        """Return what a coroutine in the thread of the sockets returns, None if it is late."""
        answer: Future[Any] = asyncio.run_coroutine_threadsafe(work, self._link.loop)
        try:
            return answer.result(_PATIENCE)
        except TimeoutError:
            answer.cancel()
            return None

    async def _renew(self) -> None:
        """Follow the graph as long as the server runs."""
        while True:
            try:
                self._follow_graph()
            except Exception:  # noqa: BLE001 - the graph may be another in a moment
                self._link.node.get_logger().error(
                    f'foxglove did not follow the graph; please report this:\n'
                    f'{traceback.format_exc()}')
            await asyncio.sleep(_RENEWAL)

    def _follow_graph(self) -> None:
        """Let channels come and go with the topics of the graph."""
        present = self._graph.topics()
        for name in [name for name, topic in self._topics.items()
                     if present.get(name) != topic.type_name]:
            topic = self._topics.pop(name)
            self._reader.remove(name)
            topic.channel.close()
        for name, topic in self._topics.items():
            if topic.readers:
                topic.publications.forget_others(self._link.publishers(name))
        for name, type_name in present.items():
            if name not in self._topics:
                self._topics[name] = Topic(type_name, foxglove.Channel(
                    name, message_encoding='cdr', schema=self._schema(type_name),
                    context=self._context))
                if any(fnmatchcase(name, pattern) for pattern in self._settings.mcap_topics):
                    self._subscribe(name, _RECORDING)
        if self._can(SERVICES):
            self._commands.renew(self._server, {
                name: type_name for name, type_name in self._graph.services().items()
                if self._permissions.allows('call_service', 'service', name)})
        if self._shows_graph and self._can(CONNECTION_GRAPH):
            self._server.publish_connection_graph(self._connections())
        if self._uses_sim_time():
            self._server.broadcast_time(self._now())

    def _schema(self, type_name: str) -> foxglove.Schema:
        """Return the schema of a message type; it is empty where no definition is installed."""
        if type_name not in self._schemas:
            try:
                encoding, text = ENCODING, message_definition(type_name)
            except (ArmsimError, OSError, ValueError) as error:
                encoding = text = ''
                self._link.node.get_logger().warning(
                    f'foxglove: topics of {type_name} are offered without its definition: {error}')
            self._schemas[type_name] = foxglove.Schema(
                name=type_name, encoding=encoding, data=text.encode())
        return self._schemas[type_name]

    async def _follow_time(self) -> None:
        """Send simulated time to clients as it moves."""
        sent = 0
        while True:
            await asyncio.sleep(_TICK if self._gate is not None and self._gate.connections
                                else _RENEWAL)
            if self._uses_sim_time() and (now := self._now()) != sent:
                self._server.broadcast_time(now)
                sent = now

    def _connections(self) -> Any:
        """Return the nodes at both ends of each topic, and those that serve each service."""
        graph, serving = foxglove.ConnectionGraph(), dict[str, list[str]]()
        for add, publish in ((graph.set_subscribed_topic, False),
                             (graph.set_published_topic, True)):
            for name in self._topics:
                if nodes := self._graph.ends(name, publish=publish):
                    add(name, nodes)
        for node in self._graph.nodes():
            for name in self._graph.node_details(node)[2]:
                serving.setdefault(name, []).append(node)
        for name, nodes in serving.items():
            graph.set_advertised_service(name, nodes)
        return graph

    def _deliver(self, batch: Batch) -> None:
        now = self._now()
        for name, message in batch:
            topic = self._topics.get(name)
            if topic is not None:
                content = bytes(message.raw)
                if topic.is_latched:
                    topic.publications.latch(message, content)
                topic.channel.log(content, log_time=now)

    def _can(self, capability: str) -> bool:
        return capability in self._rules.capabilities

    def _report(self, text: str) -> None:
        """Log an error, and show it to all clients."""
        self._link.node.get_logger().warning(f'foxglove: {text}')
        self._server.publish_status(text, foxglove.StatusLevel.Error)

    def _now(self) -> int:
        """Return the time of the ROS clock [ns]."""
        seconds, nanoseconds = self._link.now()
        return seconds * 10**9 + nanoseconds

    def _uses_sim_time(self) -> bool:
        return bool(self._link.node.get_parameter('use_sim_time').value)


def _byte() -> int:
    """Return a part of an address that no other program can expect."""
    return 1 + secrets.randbelow(254)
