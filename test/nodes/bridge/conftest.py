# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A bridge in its own process, a node to talk to through it, and clients with raw frames."""

import contextlib
import json

import cbor2
import pytest
from websockets.sync.client import connect

from armsim_ros.clients.node import SpinningNode
from armsim_ros.testing.program import start_program

#: For what comes after a while [s].
PATIENCE = 15.0
#: For the farewell of a bridge, which does not reach a client that reads nothing [s].
FAREWELL = 1.0


class Talker:
    """A client that sends objects and waits for those that it expects."""

    def __init__(self, url, **options):
        self.connection = connect(
            url, max_size=None, compression=None, close_timeout=FAREWELL, **options)
        self.received = []

    def send(self, op=None, **fields):
        """Send an operation, or, without one, any fields."""
        message = {'op': op, **fields} if op else fields
        self.connection.send(json.dumps(message))

    def receive(self, patience=PATIENCE):
        """Return the next message."""
        frame = self.connection.recv(timeout=patience)
        return cbor2.loads(frame) if isinstance(frame, bytes) else json.loads(frame)

    def until(self, op, patience=PATIENCE, **fields):
        """Return the next message of an operation with these fields."""
        while True:
            message = self.receive(patience)
            if message.get('op') == op and fields.items() <= message.items():
                return message

    def call(self, service, args=None, **fields):
        """Call a service and return the response."""
        self.send('call_service', service=service, args=args or {}, **fields)
        return self.until('service_response')

    def ask_status(self, op=None, **fields):
        """Send what is wrong and return the text of the status."""
        self.send(op, **fields)
        return self.until('status')['msg']

    def settle(self):
        """Wait until all that was sent before is done."""
        assert self.call('/rosapi/get_time')['result'] is True

    def close(self):
        """Leave."""
        self.connection.close()


@pytest.fixture(scope='module')
def arguments():
    """Return the arguments of the module's bridge."""
    return []


@pytest.fixture(scope='module')
def bridge(ros_domain_id, arguments):
    """Start a bridge and return its program; its ``url`` is where it serves."""
    with start_program('bridge', ros_domain_id, 'port:=0', *arguments) as program:
        line = program.wait_for_line('rosbridge: ws', 30)
        program.url = line.partition('rosbridge: ')[2].strip()
        yield program


@pytest.fixture
def talk(bridge):
    """Return a function that connects a client; it leaves with the test."""
    with contextlib.ExitStack() as clients:
        def talk(url=None, **options):
            client = Talker(url or bridge.url, **options)
            clients.callback(client.close)
            return client

        yield talk


@pytest.fixture(scope='module')
def peer():
    """Return a node whose callbacks run in a thread."""
    peer = SpinningNode('peer')
    yield peer.node
    peer.close()
