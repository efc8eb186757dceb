# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics in both directions, over a real connection."""

import os
from pathlib import Path
import threading
import time

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from sensor_msgs.msg import CompressedImage, JointState
from std_msgs.msg import Float64MultiArray, String

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def joint_states(peer):
    """Publish a joint state at 50 Hz."""
    publisher = peer.create_publisher(JointState, '/arm/joint_states', 10)
    message = JointState(name=['a', 'b'], position=[1.0, float('nan')])
    timer = peer.create_timer(0.02, lambda: publisher.publish(message))
    yield message
    peer.destroy_timer(timer)


@pytest.mark.parametrize('compression', ['none', 'png', 'cbor', 'cbor-raw'])
def test_a_topic_arrives_in_each_encoding(talk, joint_states, compression):
    """Its type is that of the graph where the client names none."""
    client = talk()
    client.send('subscribe', topic='/arm/joint_states', compression=compression)
    message = client.receive()
    if compression == 'png':
        assert message['op'] == 'png'
        return
    assert (message['op'], message['topic']) == ('publish', '/arm/joint_states')
    if compression == 'cbor-raw':
        assert bytes(message['msg']['bytes'])[:4] == b'\x00\x01\x00\x00'
    elif compression == 'cbor':
        assert message['msg']['position'].tag == 86
    else:
        assert message['msg']['position'] == [1.0, None]


def test_a_subscription_may_ask_for_fragments(talk, joint_states):
    """They bind this subscription alone, and join to its message."""
    client = talk()
    client.send('subscribe', topic='/arm/joint_states', fragment_size=64)
    parts = [client.receive() for _ in range(4)]
    client.send('unsubscribe', topic='/arm/joint_states')
    assert {part['op'] for part in parts} == {'fragment'}
    assert max(len(part['data']) for part in parts) == 64
    assert ''.join(part['data'] for part in parts[:parts[0]['total']]).startswith(
        '{"op":"publish","topic":"/arm/joint_states"')
    assert client.call('/rosapi/nodes')['result'] is True


def test_a_latched_topic_reaches_each_new_subscriber_at_once(talk, peer):
    """Also the second client, whose subscription in ROS was there before."""
    publisher = peer.create_publisher(String, '/description', LATCHED)
    publisher.publish(String(data='<robot/>'))
    for _ in range(2):
        client = talk()
        client.send('subscribe', topic='description', type='std_msgs/String')
        assert client.receive()['msg'] == {'data': '<robot/>'}


def test_a_second_subscription_of_a_client_gets_a_latched_message_again(talk, peer):
    """
    A client's objects for one topic each have an id, and each waits for the message.

    Re-enacts rosbridge_suite's subscribe.py, Subscription.subscribe.
    """
    publisher = peer.create_publisher(String, '/twice', LATCHED)
    publisher.publish(String(data='<robot/>'))
    client = talk()
    for key in ('subscribe:/twice:1', 'subscribe:/twice:2'):
        client.send('subscribe', topic='/twice', type='std_msgs/String', id=key)
        assert client.receive()['msg'] == {'data': '<robot/>'}


def test_a_late_client_gets_the_latched_message_of_each_publisher(talk, peer):
    """Also where another has published since."""
    first, second = (peer.create_publisher(String, '/several', LATCHED) for _ in range(2))
    early, late = talk(), talk()
    early.send('subscribe', topic='/several', type='std_msgs/String')
    for publisher, word in ((first, 'robot'), (second, 'camera 1'), (second, 'camera 2')):
        publisher.publish(String(data=word))
        while early.receive()['msg']['data'] != word:
            pass
    late.send('subscribe', topic='/several', type='std_msgs/String')
    assert {late.receive()['msg']['data'] for _ in range(2)} == {'robot', 'camera 2'}


def test_a_subscription_gets_each_message_of_a_later_publisher_once(talk, peer):
    """
    A client's publisher offers its last second again when the subscription follows it.

    Re-enacts rosbridge_suite's subscribers.py, MultiSubscriber, which subscribes once.
    """
    reader, writer = talk(), talk()
    reader.send('subscribe', topic='/cmd', type='std_msgs/String')
    reader.settle()
    writer.send('advertise', topic='/cmd', type='std_msgs/String')
    for word in ('go', 'stop'):
        writer.send('publish', topic='/cmd', msg={'data': word})
    words = [reader.receive()['msg']['data'] for _ in range(2)]
    deadline = time.monotonic() + 10.0
    while not any(end.qos_profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
                  for end in peer.get_subscriptions_info_by_topic('/cmd')):
        assert time.monotonic() < deadline
        threading.Event().wait(0.02)
    writer.send('publish', topic='/cmd', msg={'data': 'end'})
    while words[-1] != 'end':
        words.append(reader.receive()['msg']['data'])
    assert words == ['go', 'stop', 'end']


def test_a_publication_right_after_advertise_arrives(talk, peer):
    """A subscriber that the bridge knows gets it, though its connection is only being made."""
    got, arrived = [], threading.Event()
    peer.create_subscription(Float64MultiArray, '/in', lambda message: (
        got.append(message), arrived.set()), 10)
    client = talk()
    while not client.call('/rosapi/subscribers', {'topic': '/in'})['values']['subscribers']:
        pass
    client.send('advertise', topic='/in', type='std_msgs/Float64MultiArray')
    client.send('publish', topic='/in', msg={'data': [1, 2.5]})
    assert arrived.wait(10)
    assert got[0].data.tolist() == [1.0, 2.5]


def test_a_latched_publication_waits_for_late_subscribers(talk, peer):
    """The newest one, as long as its client stays."""
    client = talk()
    client.send('advertise', topic='/kept', type='std_msgs/String', latch=True)
    for word in ('old', 'new'):
        client.send('publish', topic='/kept', msg={'data': word})
    client.settle()
    got, arrived = [], threading.Event()
    peer.create_subscription(String, '/kept', lambda message: (
        got.append(message.data), arrived.set()), LATCHED)
    assert arrived.wait(10)
    assert got == ['new']


def test_publishing_needs_no_advertisement_where_the_type_is_known(talk, peer):
    """It is that of the graph; elsewhere the client is informed."""
    got, arrived = [], threading.Event()
    peer.create_subscription(String, '/typed', lambda message: (
        got.append(message.data), arrived.set()), 10)
    client = talk()
    client.send('publish', topic='/typed', msg={'data': 'text'})
    assert arrived.wait(10)
    assert got == ['text']
    assert client.ask_status('publish', topic='/untyped', msg={}).startswith(
        'publish /untyped: no such topic')


def test_a_subscription_follows_its_publishers(talk, peer):
    """
    Made before there was any, it gets what the first has latched.

    rosbridge_suite decides once (subscribers.py, MultiSubscriber).
    """
    client = talk()
    client.send('subscribe', topic='/later', type='std_msgs/String')
    client.settle()
    publisher = peer.create_publisher(String, '/later', LATCHED)
    publisher.publish(String(data='text'))
    assert client.receive()['msg'] == {'data': 'text'}


def test_a_picture_nobody_reads_does_not_hold_others_up(talk, bridge, peer, joint_states):
    """The slow client loses pictures; the other gets its joint states on time."""
    def used():
        pages = int(Path(f'/proc/{bridge.process.pid}/statm').read_text().split()[1])
        return pages * os.sysconf('SC_PAGE_SIZE')

    pictures = peer.create_publisher(CompressedImage, '/camera', 2)
    picture = CompressedImage(data=bytes(900_000))
    timer = peer.create_timer(1 / 30, lambda: pictures.publish(picture))
    slow, quick = talk(max_queue=1), talk()
    slow.send('subscribe', topic='/camera')
    quick.send('subscribe', topic='/arm/joint_states')
    quick.receive()
    start, before = time.monotonic(), used()
    for _ in range(200):
        quick.receive()
    elapsed = time.monotonic() - start
    peer.destroy_timer(timer)
    assert elapsed < 5.0
    assert used() - before < 60 << 20


def test_topics_of_large_messages_are_read_apart(talk, peer):
    """By a hidden node, whose receiving holds no other topic up."""
    client = talk()
    for name in ('/cloud', '/map'):
        clouds = peer.create_publisher(CompressedImage, name, LATCHED)
        clouds.publish(CompressedImage(format=name, data=bytes(2_000_000)))
        client.send('subscribe', topic=name)
        assert client.receive()['msg']['format'] == name
    readers = {end.node_name for end in peer.get_subscriptions_info_by_topic('/map')}
    assert readers == {'_rosbridge_websocket_large'}
    client.send('unsubscribe', topic='/cloud')
    clouds.publish(CompressedImage(format='later'))
    assert client.receive()['msg']['format'] == 'later'
    client.send('unsubscribe', topic='/map')
    deadline = time.monotonic() + 10.0
    while peer.count_subscribers('/map'):
        assert time.monotonic() < deadline
        threading.Event().wait(0.02)


def test_types_that_differ_are_named(talk, joint_states):
    """Subscribing and advertising with another type than the graph's is refused."""
    client = talk()
    text = client.ask_status('subscribe', topic='/arm/joint_states', type='std_msgs/String')
    assert 'sensor_msgs/msg/JointState' in text
    assert 'std_msgs/msg/String' in text
    text = client.ask_status('advertise', topic='/arm/joint_states', type='std_msgs/String')
    assert 'sensor_msgs/msg/JointState' in text


def test_a_missing_topic_is_answered_with_the_nearest(talk, joint_states):
    """A misspelt name leads to the right one."""
    text = talk().ask_status('subscribe', topic='/arm/joint_state')
    assert text == ("subscribe /arm/joint_state: no such topic; did you mean "
                    "'/arm/joint_states'?")


def test_a_throttled_topic_comes_at_its_rate(talk, joint_states):
    """The first message comes at once, the others no quicker than requested."""
    client = talk()
    client.send('subscribe', topic='/arm/joint_states', throttle_rate=200)
    client.receive()
    start = time.monotonic()
    for _ in range(3):
        client.receive()
    assert time.monotonic() - start > 0.55


def test_unsubscribing_from_an_id_leaves_the_other(talk, joint_states):
    """Each message comes once, until the last id is gone."""
    client = talk()
    for key in ('one', 'two'):
        client.send('subscribe', topic='/arm/joint_states', id=key)
    client.send('unsubscribe', topic='/arm/joint_states', id='one')
    client.settle()
    assert client.receive()['op'] == 'publish'
    client.send('unsubscribe', topic='/arm/joint_states', id='two')
    client.settle()
    with pytest.raises(TimeoutError):
        client.receive(patience=0.3)


def test_who_unsubscribes_leaves_the_topic_to_the_others(talk, joint_states):
    """The bridge's subscription is there until the last client has left."""
    staying, leaving = talk(), talk()
    for client in (staying, leaving):
        client.send('subscribe', topic='/arm/joint_states')
        client.receive()
    leaving.send('unsubscribe', topic='/arm/joint_states')
    leaving.settle()
    for _ in range(100):  # more than were on their way
        assert staying.receive()['topic'] == '/arm/joint_states'


def test_what_a_client_has_left_leaves_the_graph(talk, peer, joint_states):
    """Publisher and subscription of a connection that ended are gone soon."""
    client = talk()
    client.send('advertise', topic='/gone', type='std_msgs/String')
    client.send('subscribe', topic='/gone')
    client.settle()
    client.close()
    deadline = time.monotonic() + 5.0
    while peer.count_publishers('/gone') or peer.count_subscribers('/gone'):
        assert time.monotonic() < deadline
        threading.Event().wait(0.05)
