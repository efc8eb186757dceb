# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Publishers that the ids of a client share, without a middleware."""

import asyncio
from types import SimpleNamespace

import pytest
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.publishers import Publishers

TOPIC = {'topic': '/map', 'type': 'std_msgs/String'}


class Link:
    """The part of a link that publishers use, and what they have published."""

    def __init__(self):
        self.node, self.made = self, []

    def now(self):
        """Return a time."""
        return 1, 2

    def expand(self, name):
        """Return a full name."""
        return name

    def topic_types(self):
        """Return an empty graph."""
        return {}

    async def topic_type(self, name):
        """Return the type of these tests."""
        return 'std_msgs/msg/String'

    async def load(self, name, group):
        """Return the class of these tests."""
        return String

    async def run(self, work):
        """Do it now."""
        return work()

    def in_thread(self, work):
        """Do it now."""
        work()

    def create_publisher(self, kind, name, profile):
        """Make a publisher that keeps what it publishes."""
        texts = []
        made = SimpleNamespace(
            texts=texts, is_latched=not profile.lifespan.nanoseconds, is_destroyed=False,
            publish=lambda raw: texts.append(deserialize_message(raw, kind).data))
        self.made.append(made)
        return made

    def destroy_publisher(self, publisher):
        """Note it."""
        publisher.is_destroyed = True


def served(*operations):
    """Return the publishers after operations of a client and the time to end some of them."""
    async def run():
        link, client = Link(), Client('', 1 << 20, 30.0, list)
        publishers = Publishers(link, 0.0)
        for op, fields in operations:
            await getattr(publishers, op)(client, {**TOPIC, **fields})
        for _ in range(2):
            await asyncio.sleep(0)
        return link.made

    return asyncio.run(run())


def test_a_latched_publisher_stays_when_it_is_advertised_again():
    """
    Its last message with it.

    Re-enacts rosbridge_suite's publishers.py, PublisherManager.register.
    """
    made, = served(('advertise', {'id': 'A', 'latch': True}), ('publish', {'msg': {'data': 'x'}}),
                   ('advertise', {'id': 'B'}), ('unadvertise', {'id': 'A'}),
                   ('publish', {'msg': {'data': 'y'}}))
    assert made.is_latched
    assert (made.texts, made.is_destroyed) == (['x', 'y'], False)


def test_ids_from_before_a_topic_was_latched_can_be_unadvertised():
    """The publisher goes with the last of them."""
    ids = ('advertise', {'id': 'A'}), ('advertise', {'id': 'B', 'latch': True}), (
        'unadvertise', {'id': 'A'})
    plain, latched = served(*ids)
    assert (plain.is_destroyed, latched.is_destroyed) == (True, False)
    assert served(*ids, ('unadvertise', {'id': 'B'}))[1].is_destroyed
    with pytest.raises(RefusalError, match='not advertised'):
        served(*ids, ('unadvertise', {'id': 'A'}))


@pytest.mark.parametrize('latch', [True, False])
def test_a_publication_alone_may_be_latched(latch):
    """Where nothing was advertised (rosbridge_suite's publish.py, Publish.publish)."""
    made, = served(('publish', {'msg': {'data': 'x'}, 'latch': latch}))
    assert (made.texts, made.is_latched) == (['x'], latch)
