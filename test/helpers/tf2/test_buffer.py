# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Waiting for transforms and transforming of messages, without a ROS graph (tf2_ros buffer.py)."""

import threading
from types import SimpleNamespace

from geometry_msgs.msg import PointStamped
import pytest
from rclpy.duration import Duration
from stamped_transforms import at, stamped
import tf2_ros

SENT = stamped('base', 'tool', 1.0, (1, 2, 3))


@pytest.fixture
def buffer():
    """Return an empty buffer without a node."""
    return tf2_ros.Buffer(Duration(seconds=10))


def test_a_wait_ends_when_the_transform_comes(buffer):
    """The transform comes from another thread, long before the timeout."""
    threading.Timer(0.05, lambda: buffer.set_transform(SENT, 'test')).start()
    assert buffer.lookup_transform('base', 'tool', at(1.0), Duration(seconds=60)) == SENT


def test_a_wait_for_two_times_ends_when_the_transform_comes(buffer):
    """The same with a fixed frame."""
    threading.Timer(0.05, lambda: buffer.set_transform(SENT, 'test')).start()
    arguments = ('base', at(1.0), 'tool', at(1.0), 'base', Duration(seconds=60))
    assert buffer.can_transform_full(*arguments, return_debug_tuple=True) == (True, '')
    assert buffer.lookup_transform_full(*arguments) == SENT


def test_a_wait_in_vain_gives_the_reason(buffer):
    """After the timeout the exception is that of a look-up without waiting."""
    short = Duration(nanoseconds=1_000_000)
    assert buffer.can_transform('base', 'tool', at(1.0), short) is False
    assert 'does not exist' in buffer.can_transform(
        'base', 'tool', at(1.0), short, return_debug_tuple=True)[1]
    with pytest.raises(tf2_ros.LookupException):
        buffer.lookup_transform('base', 'tool', at(1.0), short)


def _step(coroutine):
    """Continue a coroutine; return its result, None where it waits."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        return end.value
    return None


def test_a_coroutine_gets_the_transform_as_soon_as_it_comes(buffer):
    """Both forms of look-up; at once where it is there already."""
    waiting = [buffer.lookup_transform_async('base', 'tool', at(1.0)),
               buffer.lookup_transform_full_async('base', at(1.0), 'tool', at(1.0), 'base')]
    assert [_step(each) for each in waiting] == [None, None]
    buffer.set_transform(stamped('base', 'other', 1.0), 'test')
    assert [_step(each) for each in waiting] == [None, None]
    buffer.set_transform(SENT, 'test')
    assert [_step(each) for each in waiting] == [SENT, SENT]
    assert _step(buffer.lookup_transform_async('base', 'tool', at(1.0))) == SENT


def test_a_future_may_be_cancelled_and_may_ask_for_the_next(buffer):
    """A cancelled future is left alone; what callbacks ask for is not lost."""
    cancelled = buffer.wait_for_transform_async('base', 'tool', at(1.0))
    cancelled.cancel()
    first = buffer.wait_for_transform_async('base', 'tool', at(1.0))
    following = []
    first.add_done_callback(lambda _: following.append(
        buffer.wait_for_transform_async('base', 'late', at(1.0))))
    buffer.set_transform(SENT, 'test')
    assert cancelled.cancelled()
    assert cancelled.result() is None
    assert first.result() == SENT
    buffer.set_transform_static(stamped('base', 'late'), 'test')
    assert following[0].done()


def test_a_jump_back_in_time_empties_the_buffer(buffer):
    """Otherwise new data would be older than all that is there."""
    buffer.set_transform(SENT, 'test')
    buffer.time_jump_callback(SimpleNamespace())
    assert not buffer.can_transform('base', 'tool', at(1.0))


def test_messages_are_transformed_by_the_function_of_their_type(buffer, monkeypatch):
    """The header names frame and time; the type of the result may be chosen."""
    class Mine(PointStamped):
        pass

    monkeypatch.setattr(tf2_ros.TransformRegistration, '_functions', {})
    monkeypatch.setattr(tf2_ros.ConvertRegistration, '_convert', {})
    message = Mine()
    message.header.frame_id = 'tool'
    message.header.stamp = at(1.0).to_msg()
    with pytest.raises(tf2_ros.TypeException, match='Mine'):
        buffer.transform(message, 'base')
    buffer.registration.add(Mine, lambda point, transform: (point, transform))
    buffer.set_transform(SENT, 'test')
    assert buffer.transform(message, 'base') == (message, SENT)
    assert buffer.transform_full(message, 'base', at(1.0), 'base', Duration(seconds=1)) == (
        message, SENT)
    tf2_ros.ConvertRegistration().add_convert((tuple, list), list)
    assert buffer.transform(message, 'base', new_type=list) == [message, SENT]


def test_conversion_goes_through_messages(monkeypatch):
    """Where two types have no function of their own; an object's own type is a copy."""
    registration = tf2_ros.ConvertRegistration()
    for name in ('_to_msg', '_from_msg'):
        monkeypatch.setattr(tf2_ros.ConvertRegistration, name, {})
    registration.add_to_msg(int, str)
    registration.add_from_msg(list, list)
    assert tf2_ros.convert(42, list) == ['4', '2']
    original = [[1]]
    assert tf2_ros.convert(original, list) == original
    assert tf2_ros.convert(original, list)[0] is not original[0]
    with pytest.raises(tf2_ros.TypeException):
        tf2_ros.convert(1.5, list)


def test_an_incomplete_buffer_says_so():
    """BufferInterface itself cannot look anything up."""
    with pytest.raises(tf2_ros.NotImplementedException, match='not implemented'):
        tf2_ros.BufferInterface().can_transform('a', 'b', at(0))


def test_names_that_programs_import_from_tf2_ros():
    """Upstream's modules export what they import themselves; clients rely on some of it."""
    from tf2_ros.buffer import Buffer
    from tf2_ros.buffer_interface import BufferInterface
    from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster
    from tf2_ros.transform_broadcaster import TransformBroadcaster
    from tf2_ros.transform_listener import TransformListener
    names = {}
    exec('from tf2_ros import *', names)
    assert {Buffer, BufferInterface, StaticTransformBroadcaster, TransformBroadcaster,
            TransformListener} <= {value for value in names.values() if isinstance(value, type)}
    assert 'TransformStamped' in names
    assert issubclass(names['LookupException'], names['TransformException'])
