# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Foxglove's protocol, with raw frames of a client."""

import http.client
import itertools
import json
import signal
import statistics
import struct
import threading
import time

import pytest

pytest.importorskip('foxglove')

from builtin_interfaces.msg import Time
from mcap.reader import make_reader
from rclpy.parameter import Parameter
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import SetBool
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from armsim_ros.testing.program import start_program

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
PATIENCE = 15.0


class Viewer:
    """A client that keeps what the server offers."""

    def __init__(self, url):
        self.url = url
        self.connection = connect(url, subprotocols=['foxglove.sdk.v1'], max_size=None)
        self.offered = {}

    def send(self, op, **fields):
        """Send an operation."""
        self.connection.send(json.dumps({'op': op, **fields}))

    def receive(self):
        """Return the next message: an object, or bytes."""
        frame = self.connection.recv(timeout=PATIENCE)
        if isinstance(frame, bytes):
            return frame
        message = json.loads(frame)
        for kind in ('channels', 'services'):
            for entry in message.get(kind, ()):
                self.offered[entry.get('topic') or entry['name']] = entry
        return message

    def wait_for(self, condition):
        """Return the next message for which a condition holds."""
        deadline = time.monotonic() + PATIENCE
        while not condition(message := self.receive()):
            assert time.monotonic() < deadline
        return message

    def find(self, name):
        """Return what is offered under a name."""
        while name not in self.offered:
            self.receive()
        return self.offered[name]


@pytest.fixture(scope='module')
def arguments():
    """Let clients of Foxglove do all."""
    return ['foxglove:=control', 'foxglove_port:=0']


@pytest.fixture
def viewer(bridge):
    """Connect a client."""
    line = bridge.wait_for_line('foxglove: ws', 30)
    found = Viewer(line.partition('foxglove: ')[2].strip())
    yield found
    found.connection.close()


def test_a_latched_topic_is_sent_to_each_subscriber(viewer, peer):
    """Serialized, with the full text of its type; the topic is subscribed to while it is seen."""
    publisher = peer.create_publisher(String, '/shown', LATCHED)
    publisher.publish(String(data='text'))
    channel = viewer.find('/shown')
    assert (channel['encoding'], channel['schemaName'], channel['schemaEncoding']) == (
        'cdr', 'std_msgs/msg/String', 'ros2msg')
    assert channel['schema'].strip() == 'string data'
    for number in (1, 2):
        viewer.send('subscribe', subscriptions=[{'id': number, 'channelId': channel['id']}])
        frame = viewer.wait_for(lambda message: isinstance(message, bytes))
        assert frame[0] == 1
        assert deserialize_message(frame[13:], String) == String(data='text')
        viewer.send('unsubscribe', subscriptionIds=[number])
    deadline = time.monotonic() + PATIENCE
    while peer.count_subscribers('/shown'):
        assert time.monotonic() < deadline
        threading.Event().wait(0.05)
    peer.destroy_publisher(publisher)
    viewer.wait_for(lambda message: isinstance(message, dict) and message['op'] == 'unadvertise')


def test_a_later_subscriber_gets_the_latched_message_of_each_publisher(viewer, peer):
    """However many another has published since, as with /tf_static."""
    first, second = (peer.create_publisher(String, '/frames', LATCHED) for _ in range(2))
    later = Viewer(viewer.url)

    def subscribe(client):
        channel = client.find('/frames')
        client.send('subscribe', subscriptions=[{'id': 1, 'channelId': channel['id']}])

    def text(client):
        frame = client.wait_for(lambda message: isinstance(message, bytes))
        return deserialize_message(frame[13:], String).data

    subscribe(viewer)
    for publisher, word in ((first, 'robot'), (second, 'camera 1'), (second, 'camera 2')):
        publisher.publish(String(data=word))
        while text(viewer) != word:
            pass
    subscribe(later)
    assert {text(later) for _ in range(2)} == {'robot', 'camera 2'}
    later.connection.close()
    for publisher in (first, second):
        peer.destroy_publisher(publisher)


def test_parameters_are_read_and_set(viewer, peer):
    """By their names node.name; what is requested as node:name has that name."""
    peer.declare_parameter('speed', 1.5)
    deadline, found = time.monotonic() + PATIENCE, []
    while not found:
        assert time.monotonic() < deadline
        viewer.send('getParameters', parameterNames=['/peer.speed'], id='read')
        found = viewer.wait_for(lambda message: isinstance(message, dict)
                                and message.get('id') == 'read')['parameters']
    assert found[0]['value'] == 1.5
    viewer.send('setParameters', parameters=[{'name': '/peer.speed', 'value': 2.5}], id='set')
    answer = viewer.wait_for(lambda message: isinstance(message, dict)
                             and message.get('id') == 'set')
    assert answer['parameters'][0]['value'] == 2.5
    assert peer.get_parameter('speed').value == 2.5
    viewer.send('subscribeParameterUpdates', parameterNames=['/peer.speed'])
    deadline, speed, seen = time.monotonic() + PATIENCE, 3.0, []
    while not seen:  # the bridge's subscription has to be found first
        assert time.monotonic() < deadline
        peer.set_parameters([Parameter('speed', value=speed)])
        speed += 1.0
        viewer.send('getParameters', parameterNames=['/peer:speed'], id='next')
        answer = viewer.wait_for(lambda message: isinstance(message, dict)
                                 and message['op'] == 'parameterValues')
        seen = [] if answer.get('id') == 'next' else answer['parameters']
    assert seen[0]['name'] == '/peer.speed'
    assert seen[0]['value'] >= 3.0
    viewer.send('getParameters', parameterNames=[], id='all')
    answer = viewer.wait_for(lambda message: isinstance(message, dict)
                             and message.get('id') == 'all')
    assert {'/peer.speed', '/peer.use_sim_time'} <= {
        parameter['name'] for parameter in answer['parameters']}


def wait_for_publishers(peer, topic, count):
    """Wait until a topic has so many publishers."""
    deadline = time.monotonic() + PATIENCE
    while peer.count_publishers(topic) != count:
        assert time.monotonic() < deadline
        threading.Event().wait(0.05)


def test_a_clients_channel_is_a_publisher_until_it_is_taken_back(viewer, peer):
    """Another of the same client stays."""
    viewer.send('advertise', channels=[
        {'id': number, 'topic': f'/channel_{number}', 'encoding': 'cdr',
         'schemaName': 'std_msgs/msg/String'} for number in (1, 2)])
    wait_for_publishers(peer, '/channel_1', 1)
    wait_for_publishers(peer, '/channel_2', 1)
    viewer.send('unadvertise', channelIds=[1, 3])
    wait_for_publishers(peer, '/channel_1', 0)
    assert peer.count_publishers('/channel_2') == 1


def test_clients_publish_and_call(viewer, peer):
    """Serialized or as JSON."""
    got, arrived = [], threading.Semaphore(0)
    peer.create_subscription(String, '/commanded', lambda message: (
        got.append(message.data), arrived.release()), 10)
    channels = [{'id': number, 'topic': '/commanded', 'encoding': encoding,
                 'schemaName': 'std_msgs/msg/String'}
                for number, encoding in ((1, 'cdr'), (2, 'json'))]
    viewer.send('advertise', channels=channels)
    wait_for_publishers(peer, '/commanded', 2)
    threading.Event().wait(0.3)
    viewer.connection.send(struct.pack('<BI', 1, 1) + serialize_message(String(data='cdr')))
    assert arrived.acquire(timeout=PATIENCE)
    viewer.connection.send(struct.pack('<BI', 1, 2) + b'{"data": "json"}')
    assert arrived.acquire(timeout=PATIENCE)
    assert got == ['cdr', 'json']

    def switch(request, response):
        response.success = request.data
        return response

    peer.create_service(SetBool, '/toggle', switch)
    service = viewer.find('/toggle')
    viewer.connection.send(struct.pack('<BIII', 2, service['id'], 9, 3) + b'cdr'
                           + serialize_message(SetBool.Request(data=True)))
    frame = viewer.wait_for(lambda message: isinstance(message, bytes))
    assert struct.unpack('<BIII', frame[:13]) == (3, service['id'], 9, 3)
    assert deserialize_message(frame[16:], SetBool.Response).success is True


@pytest.mark.parametrize(('encoding', 'kind', 'text'), [
    ('xml', 'std_msgs/msg/String', "unknown encoding 'xml'; allowed: cdr, json"),
    ('cdr', 'none/msg/None', 'none')])
def test_a_channel_that_cannot_be_published_is_reported(viewer, encoding, kind, text):
    """Re-enacts ros2_foxglove_bridge.cpp, clientAdvertise and clientMessage: a status."""
    viewer.send('advertise', channels=[
        {'id': 7, 'topic': '/failing', 'encoding': encoding, 'schemaName': kind}])
    status = viewer.wait_for(lambda message: isinstance(message, dict)
                             and message['op'] == 'status')
    assert status['level'] == 2
    assert status['message'].startswith('/failing is not published: ')
    assert text in status['message']


def test_a_message_that_is_dropped_is_reported(viewer):
    """Re-enacts ros2_foxglove_bridge.cpp, clientMessage."""
    viewer.send('advertise', channels=[{'id': 8, 'topic': '/dropping', 'encoding': 'json',
                                        'schemaName': 'std_msgs/msg/String'}])
    viewer.connection.send(struct.pack('<BI', 1, 8) + b'{"data": ')
    status = viewer.wait_for(lambda message: isinstance(message, dict)
                             and message['op'] == 'status')
    assert status['message'].startswith('/dropping: a message is dropped: ')


@pytest.mark.parametrize(('headers', 'status'), [
    ({'Origin': 'https://evil.example'}, 403), ({'Host': 'evil.example'}, 403),
    ({'Origin': 'file://'}, 403), ({'Origin': 'https://app.foxglove.dev'}, 101)])
def test_foreign_pages_are_refused(bridge, headers, status):
    """By the rules of the bridge; Foxglove's own page may connect."""
    url = bridge.wait_for_line('foxglove: ws', 30).partition('foxglove: ')[2].strip()
    connection = http.client.HTTPConnection(url.removeprefix('ws://'), timeout=10)
    connection.request('GET', '/', headers={
        'Upgrade': 'websocket', 'Connection': 'Upgrade', 'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Protocol': 'foxglove.sdk.v1', 'Sec-WebSocket-Key': 'A' * 22 + '==',
        **headers})
    assert connection.getresponse().status == status
    connection.close()


def test_assets_have_names_of_any_characters(ros_domain_id, peer, tmp_path):
    """Re-enacts param_utils.cpp, PARAM_ASSET_URI_ALLOWLIST: %20, and endings such as gltf."""
    folder = tmp_path / 'arm'
    (folder / 'meshes').mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>arm</name></package>')
    for name in ('link 1.gltf', 'secret.txt', 'secret.stl.txt'):
        (folder / 'meshes' / name).write_text(name)
    publisher = peer.create_publisher(String, '/robot_description', LATCHED)
    publisher.publish(String(data='<mesh filename="package://arm/meshes/link%201.gltf"/>'))
    with start_program('original', ros_domain_id, 'foxglove_bridge', 'port:=0',
                       f'packages_path:={tmp_path}') as program:
        viewer = Viewer(program.wait_for_line('foxglove: ws', 30).partition(': ')[2].strip())
        found = {}
        for number, name in enumerate(('link%201.gltf', 'secret.txt', '%2e%2e/package.xml')):
            viewer.send('fetchAsset', uri=f'package://arm/meshes/{name}', requestId=number)
            frame = viewer.wait_for(lambda message: isinstance(message, bytes))
            found[name] = frame[10:] if frame[5] == 0 else None
        viewer.connection.close()
    assert found == {'link%201.gltf': b'link 1.gltf', 'secret.txt': None,
                     '%2e%2e/package.xml': None}
    peer.destroy_publisher(publisher)


def test_foxglove_bridge_keeps_to_its_parameters(ros_domain_id, peer, tmp_path):
    """Re-enacts ros2_foxglove_bridge.cpp: the node's name, capabilities and topic_whitelist."""
    publishers = [peer.create_publisher(String, name, LATCHED) for name in ('/shown', '/hid')]
    file = tmp_path / 'viewer.yaml'
    file.write_text("""
foxglove_bridge:
  ros__parameters:
    port: 0
    topic_whitelist: ['/SHO.*']
    capabilities: [connectionGraph, assets]
""")
    with start_program('original', ros_domain_id, 'foxglove_bridge', '--ros-args',
                       '--params-file', str(file)) as program:
        viewer = Viewer(program.wait_for_line('foxglove: ws', 30).partition(': ')[2].strip())
        info = viewer.wait_for(lambda message: message['op'] == 'serverInfo')
        assert set(info['capabilities']) == {'connectionGraph', 'assets'}
        viewer.find('/shown')
        assert list(viewer.offered) == ['/shown']
        assert 'rosbridge' not in program.text
        viewer.connection.close()
    for publisher in publishers:
        peer.destroy_publisher(publisher)


def test_simulated_time_is_that_of_the_clock(ros_domain_id, peer):
    """Re-enacts ros2_foxglove_bridge.cpp: time follows /clock, and messages are stamped by it."""
    clock = peer.create_publisher(Clock, '/clock', 10)
    publisher = peer.create_publisher(String, '/stamped', LATCHED)
    publisher.publish(String(data='text'))
    ticks = itertools.count(1)

    def tick():
        seconds, number = divmod(next(ticks), 100)
        clock.publish(Clock(clock=Time(sec=100 + seconds, nanosec=number * 10_000_000)))

    timer = peer.create_timer(0.01, tick)
    with start_program('bridge', ros_domain_id, 'port:=0', 'foxglove:=read', 'foxglove_port:=0',
                       '--ros-args', '-p', 'use_sim_time:=true') as program:
        viewer = Viewer(program.wait_for_line('foxglove: ws', 30).partition(': ')[2].strip())

        def next_time():
            frame = viewer.wait_for(lambda message: isinstance(message, bytes)
                                    and message[0] == 2)
            return struct.unpack('<Q', frame[1:])[0]

        while next_time() < 100 * 10**9:
            pass
        times = [next_time() for _ in range(20)]
        assert statistics.median(after - before for before, after in itertools.pairwise(times)
                                 ) < 0.25e9
        channel = viewer.find('/stamped')
        viewer.send('subscribe', subscriptions=[{'id': 1, 'channelId': channel['id']}])
        frame = viewer.wait_for(lambda message: isinstance(message, bytes) and message[0] == 1)
        assert times[0] <= struct.unpack('<Q', frame[5:13])[0] <= 100 * 10**9 + next(ticks) * 10**7
        viewer.connection.close()
    peer.destroy_timer(timer)
    for each in (clock, publisher):
        peer.destroy_publisher(each)


def test_the_graph_is_published(viewer, peer):
    """Which nodes publish a topic, as long as a client wants it."""
    publisher = peer.create_publisher(String, '/linked', 1)
    viewer.send('subscribeConnectionGraph')
    deadline = time.monotonic() + PATIENCE
    while {'name': '/linked', 'publisherIds': ['/peer']} not in viewer.wait_for(
            lambda message: isinstance(message, dict) and message['op'] == 'connectionGraphUpdate'
            )['publishedTopics']:
        assert time.monotonic() < deadline
    viewer.send('unsubscribeConnectionGraph')
    peer.destroy_publisher(publisher)


def test_assets_are_those_of_the_robot(viewer):
    """Anything else is an error: other files, other schemes."""
    for number, uri in enumerate(('file:///etc/hostname', 'package://none/meshes/link.stl')):
        viewer.send('fetchAsset', uri=uri, requestId=number)
        frame = viewer.wait_for(lambda message: isinstance(message, bytes))
        assert struct.unpack('<BIB', frame[:6]) == (4, number, 1)


def test_reading_offers_no_commands(ros_domain_id, peer, tmp_path):
    """What true means; token and patterns are the bridge's, and topics may be recorded."""
    publisher = peer.create_publisher(String, '/recorded', LATCHED)
    publisher.publish(String(data='text'))
    with start_program('bridge', ros_domain_id, 'port:=0', 'foxglove:=true', 'foxglove_port:=0',
                       'token:=word', 'topics_glob:=[/rec*]', 'mcap_topics:=[/recorded]',
                       f'mcap:={tmp_path}/seen.mcap') as program:
        url = program.wait_for_line('foxglove: ws', 30).partition('foxglove: ')[2].strip()
        with pytest.raises(InvalidStatus, match='401'):
            connect(url.partition('/?')[0], subprotocols=['foxglove.sdk.v1'])
        viewer = Viewer(url)
        info = viewer.wait_for(lambda message: message['op'] == 'serverInfo')
        assert not {'clientPublish', 'services'} & set(info['capabilities'])
        assert {'connectionGraph', 'parameters', 'parametersSubscribe', 'assets'} <= set(
            info['capabilities'])
        peer.declare_parameter('fixed', 1)
        deadline, values = time.monotonic() + PATIENCE, []
        while not values:  # the node has to be found first
            assert time.monotonic() < deadline
            viewer.send('setParameters', id='set',
                        parameters=[{'name': '/peer:fixed', 'value': 2}])
            values = viewer.wait_for(lambda message: isinstance(message, dict)
                                     and message.get('id') == 'set')['parameters']
        assert values == [{'name': '/peer:fixed', 'value': 1}]
        channel = viewer.find('/recorded')
        assert list(viewer.offered) == ['/recorded']
        viewer.send('subscribe', subscriptions=[{'id': 1, 'channelId': channel['id']}])
        viewer.wait_for(lambda message: isinstance(message, bytes))
        with pytest.raises((InvalidStatus, OSError)):
            connect(url, subprotocols=['unknown'])
        program.process.send_signal(signal.SIGINT)
        assert program.process.wait(10) == 0
        assert 'Traceback' not in program.text
    with (tmp_path / 'seen.mcap').open('rb') as file:
        recorded = {channel.topic for _, channel, _ in make_reader(file).iter_messages()}
    assert recorded == {'/recorded'}
    peer.destroy_publisher(publisher)
