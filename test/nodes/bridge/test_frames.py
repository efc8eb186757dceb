# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames, fragments and what JSON may hold."""

import asyncio
import json
import threading

import pytest
from std_msgs.msg import Header
from websockets.frames import Frame, Opcode

from armsim_ros.nodes.bridge.frames import Fragments, MOST_BYTES, parse, text_frames, to_frame
from armsim_ros.nodes.bridge.incoming import aside, LARGE, message_of
from armsim_ros.nodes.bridge.interfaces import RefusalError


@pytest.mark.parametrize('size', [0, 125, 126, 65535, 65536])
@pytest.mark.parametrize('binary', [False, True])
def test_a_frame_is_that_of_websockets(size, binary):
    """Byte for byte, for each form of the length."""
    opcode = Opcode.BINARY if binary else Opcode.TEXT
    payload = b'x' * size
    assert b''.join(to_frame(payload, binary=binary)) == Frame(opcode, payload).serialize(
        mask=False, extensions=[])


def test_fragments_join_to_what_they_were():
    """In any order, those of two messages mixed."""
    first = {'op': 'publish', 'topic': '/a', 'msg': {'data': 'x' * 300}}
    frames = [json.loads(frame[frame.index(b'{'):])
              for frame in text_frames(first, 64)]
    assert [part['num'] for part in frames] == list(range(frames[0]['total']))
    joined = Fragments(30.0)
    joined.add('other', 'x', 0, 2, 0.0)
    for part in reversed(frames):
        text = joined.add(part['id'], part['data'], part['num'], part['total'], 0.0)
    assert json.loads(text) == first


def test_fragments_that_never_end_are_dropped():
    """By number, by size and by time."""
    joined = Fragments(30.0)
    for key in range(8):
        joined.add(key, 'x', 0, 2, 0.0)
    with pytest.raises(RefusalError, match='dropped'):
        joined.add(8, 'x', 0, 2, 0.0)
    assert joined.add(8, 'x', 0, 2, 31.0) is None
    with pytest.raises(RefusalError, match='dropped'):
        joined.add(9, 'x' * MOST_BYTES, 0, 2, 31.0)
    with pytest.raises(RefusalError, match='num is 0 to total - 1'):
        joined.add(10, 'x', 2, 2, 31.0)


@pytest.mark.parametrize(('frame', 'text'), [
    ('17', 'a message is a JSON object with "op", not int'), ('[]', 'not list'),
    ('{', 'not JSON: Expecting property name enclosed in double quotes at character 1'),
    ('', 'not JSON'), (b'\xff', 'not UTF-8 at byte 0'), ('9' * 5000, 'not JSON'),
    ('{' * 4000 + '}' * 4000, 'not JSON'), ('{"a":' * 101 + '1' + '}' * 101, 'nested too deeply'),
    ('[' * 100000, 'nested too deeply|not JSON'),
    ('{"a":' + '[' * 4000 + ']' * 4000 + '}', 'nested too deeply')])
def test_what_is_no_object_is_named(frame, text):
    """A position, or what it is instead; nothing takes long."""
    with pytest.raises(RefusalError, match=text.replace('"', '.')):
        parse(frame)


def test_an_object_with_many_short_lists_is_read():
    """Depth counts, not number; a binary frame may hold JSON, too."""
    message = {'op': 'publish', 'msg': {'points': [{'positions': [[1]]}] * 500}}
    assert parse(json.dumps(message)) == message
    assert parse(json.dumps(message).encode()) == message


def test_a_large_frame_is_read_as_others_are_but_beside_their_requests():
    """Its text by a decoder that lets others run, its message in a thread."""
    long = json.dumps({'op': 'publish', 'msg': {'data': [
        0.5, -3, 'a\n', None, {}, {'x': 1, 'y': '}]'}, {'z': [{'"': 'x' * 2000}]}] * 1000,
        'points': [{'x': -1e-3, 'y': 2, 'z': 'a'}] * 20_000}})
    assert len(long) > 2_000_000
    threads = set()

    def stamp():
        threads.add(threading.get_ident())
        return 1, 2

    async def run():
        message = await aside(len(long), parse, long)
        assert message == json.loads(long)
        await message_of(Header, {}, stamp)
        assert threads == {threading.get_ident()}  # the time is that of the sockets' thread
        inside = await aside(LARGE, threading.get_ident)
        assert inside not in threads
        assert await aside(LARGE - 1, threading.get_ident) in threads

    asyncio.run(run())
    with pytest.raises(RefusalError, match='not JSON'):
        parse(long[:-1])
