# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What waits for a client, and what a slow client loses."""

import asyncio
from base64 import b64decode
import json

import cbor2
import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import String, UInt8MultiArray

from armsim_ros.nodes.bridge.client import Client, Outbox, Sample
from armsim_ros.nodes.bridge.topics import Listener, Options


class Echo:
    """A listener whose frames are the raw messages."""

    def frames(self, sample):
        """Return the message."""
        return [sample.raw]


def sample(raw):
    """Return a sample."""
    return Sample(String, raw, (0, 0))


def drained(outbox):
    """Return all that waits."""
    async def run():
        found = []
        while frames := await outbox.take():
            found += frames
        return found

    return asyncio.run(run())


def test_answers_come_before_samples_and_samples_in_their_order():
    """Those of several topics mixed as they arrived."""
    outbox, first, second = Outbox(1000), Echo(), Echo()
    outbox.add_sample(first, sample(b'1'))
    outbox.add_sample(second, sample(b'2'))
    outbox.add_sample(first, sample(b'3'))
    outbox.add_answer([b'answer'])
    assert drained(outbox) == [b'answer', b'1', b'2', b'3']


def test_the_newest_samples_stay():
    """Two pictures, a hundred others, or as many as requested."""
    outbox, pictures, states, few = Outbox(1 << 24), Echo(), Echo(), Echo()
    for index in range(200):
        outbox.add_sample(pictures, sample(index.to_bytes(1, 'big') * 200_000))
        outbox.add_sample(states, sample(b's%d' % index))
        outbox.add_sample(few, sample(b'f%d' % index), 3)
    found = drained(outbox)
    assert [frame[0] for frame in found if len(frame) > 100] == [198, 199]
    assert [frame for frame in found if frame[:1] == b's'] == [
        b's%d' % index for index in range(100, 200)]
    assert [frame for frame in found if frame[:1] == b'f'] == [b'f197', b'f198', b'f199']


def test_the_whole_queue_has_a_limit_and_the_newest_sample_stays():
    """Even where it alone is larger."""
    outbox, first, second = Outbox(1000), Echo(), Echo()
    for _ in range(20):
        outbox.add_sample(first, sample(b'x' * 90))
    outbox.add_sample(second, sample(b'y' * 2000))
    assert [len(frame) for frame in drained(outbox)] == [2000]


def test_answers_that_are_not_read_end_the_connection():
    """A single large answer does not."""
    ended = []
    client = Client('', 1000, 30.0, lambda: ended.append(True))
    client.send({'values': 'x' * 5000})
    assert not ended
    client.send({'values': 'x'})
    assert ended


@pytest.mark.parametrize('size', [10, 1 << 20])
def test_a_large_answer_is_encoded_beside_other_work(size):
    """A small one at once."""
    client, turns = Client('', 1 << 30, 30.0, list), []

    async def run():
        asyncio.get_running_loop().call_soon(turns.append, 'other')
        await client.answer({'id': 5}, {'op': 'service_response'},
                                 UInt8MultiArray(data=bytes(size)))
        return list(turns), b''.join(await client.outbox.take())

    others, frame = asyncio.run(run())
    found = json.loads(frame[frame.index(b'{'):])
    assert (found['op'], found['id']) == ('service_response', 5)
    assert b64decode(found['values']['data']) == bytes(size)
    assert others == ['other'] * (size > 10)


def test_a_forgotten_listener_leaves_nothing():
    """Samples of others stay."""
    outbox, first, second = Outbox(1000), Echo(), Echo()
    for listener in (first, second, first):
        outbox.add_sample(listener, sample(b'x'))
    outbox.forget(first)
    assert drained(outbox) == [b'x']


def test_ids_of_a_client_share_the_strongest_encoding_which_is_made_once():
    """Of two clients, too (rosbridge_suite encodes JSON for each)."""
    listeners = [Listener(Client('', 1 << 20, 30.0, list), '/topic') for _ in range(2)]
    for listener in listeners:
        for key, compression in enumerate(('none', 'cbor', 'png')):
            listener.change(key, Options(compression=compression))
    message = sample(serialize_message(String(data='text')))
    frames = [listener.frames(message) for listener in listeners]
    assert frames[0] is frames[1]
    assert cbor2.loads(frames[0][0][2:]) == {
        'op': 'publish', 'topic': '/topic', 'msg': {'data': 'text'}}
    listeners[0].change(1, None)
    assert b'"op":"png"' in listeners[0].frames(message)[0]


def offered(options, times):
    """Return which of the samples offered at these times wait at once."""
    async def run():
        client = Client('', 1 << 20, 30.0, list)
        listener = Listener(client, '/topic')
        for key, each in enumerate(options):
            listener.change(key, each)
        queued = []
        client.outbox.add_sample = lambda _, found, most: queued.append(found.raw)
        for index, time in enumerate(times):
            listener.offer(sample(b'%d' % index), time)
        listener.close()
        return queued

    return asyncio.run(run())


def test_throttling_drops_between():
    """The first comes at once."""
    times = [10.0, 10.1, 10.5, 10.9, 11.0]
    assert offered([Options(throttle=0.5)], times) == [b'0', b'2', b'4']
    assert offered([Options(throttle=0.5), Options(throttle=0.1)], times) == [
        b'0', b'1', b'2', b'3', b'4']
    assert offered([Options(throttle=0.5, queue_length=1)], times) == [b'0']
