# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients that send what they should not: they hear of it, and nobody else does."""

import http.client
import os
from pathlib import Path
import subprocess
import sys
import threading
import time

import pytest
from sensor_msgs.msg import JointState
from websockets.exceptions import ConnectionClosed

from benchmarks.bridge.bridge import publishing
from benchmarks.bridge.crowd import half_open


@pytest.fixture(scope='module')
def arguments():
    """Limit what may be used, and how many may come."""
    return ['topics_glob:=[/joint_states, /seen, /picture]', 'max_message_size:=100000',
            'max_clients:=250']


@pytest.fixture(scope='module')
def joint_states(peer):
    """Publish the time at 50 Hz, and return what is published to /seen."""
    publisher = peer.create_publisher(JointState, '/joint_states', 10)
    timer = peer.create_timer(
        0.02, lambda: publisher.publish(JointState(position=[time.monotonic()])))
    moved = []
    peer.create_subscription(JointState, '/seen', moved.append, 10)
    yield moved
    peer.destroy_timer(timer)


@pytest.fixture
def delays(talk, joint_states):
    """Return the longest delay of a joint state on its way to another client, so far [s]."""
    client = talk()
    client.send('subscribe', topic='/joint_states')
    client.receive()
    longest, ended = [0.0], threading.Event()

    def watch():
        while not ended.is_set():
            sent = client.receive()['msg']['position'][0]
            longest[0] = max(longest[0], time.monotonic() - sent)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    yield longest
    ended.set()
    thread.join(5.0)


@pytest.mark.parametrize(('frame', 'text'), [
    ('not json', 'not JSON: Expecting value at character 0'),
    ('17', 'a message is a JSON object with "op", not int'),
    ('{"a": 1}', 'op must be one of advertise, unadvertise, publish, '),
    ('{"op": "advertize"}', "did you mean 'advertise'?"),
    ('{"op": "publish"}', 'publish: topic is missing: string'),
    ('{"op": "subscribe", "topic": "/seen", "type": "sensor_msgs/JointStat"}',
     "no message type sensor_msgs/msg/JointStat; did you mean 'sensor_msgs/msg/JointState'?"),
    ('{"op": "subscribe", "topic": "/seen", "type": "os/path"}', 'installed packages: '),
    ('{"op": "advertise", "topic": "/seen", "type": ""}', 'installed packages: '),
    ('{"op": "publish", "topic": "/seen", "msg": {"position": ["a"]}}',
     'publish /seen: position[0]: expected a number, got "a"; JointState has header'),
    ('{"op": "subscribe", "topic": "/other"}',
     'subscribe /other: not allowed here: topics_glob is [/joint_states, /seen, /picture]'),
    ('{"op": "publish", "topic": "a b"}', 'is not a name of ROS'),
    ('{"op": "fragment", "id": 1, "data": "x", "num": 3, "total": 2}', 'num is 0 to total - 1'),
    ('{"op": "set_level", "level": "loud"}', 'allowed: none, error, warning, info'),
])
def test_what_is_wrong_is_reported(talk, joint_states, frame, text):
    """The connection goes on."""
    client = talk()
    client.connection.send(frame)
    answer = client.receive()
    assert (answer['op'], answer['level']) == ('status', 'error')
    assert text in answer['msg']
    client.settle()


@pytest.mark.parametrize('fields', [
    {'op': 'unsubscribe', 'topic': '/seen'}, {'op': 'unadvertise', 'topic': '/seen'},
    {'op': 'cancel_action_goal', 'action': '/a', 'id': 'x'},
    {'op': 'unadvertise_service', 'service': '/a'}, {'op': 'unadvertise_action', 'action': '/a'},
    {'op': 'service_response', 'id': 'x'}, {'op': 'action_feedback', 'id': 'x'},
    {'op': 'action_result', 'id': 'x'}])
def test_to_end_what_is_not_there_is_a_warning(talk, fields):
    """Only clients that want warnings get them."""
    client = talk()
    client.send(**fields)
    client.settle()
    client.send('set_level', level='warning')
    client.send(**fields)
    assert client.receive()['level'] == 'warning'


def let_crowd(bridge, clients, frames, idle):
    """Have clients in a process of their own share random frames; some only begin a handshake."""
    words = [bridge.url, *map(str, (clients, frames, idle))]
    subprocess.run([sys.executable, '-m', 'benchmarks.bridge.crowd', *words], check=True,
                   cwd=Path(__file__).parents[3], timeout=60)


@pytest.mark.alone
def test_random_frames_hold_nobody_up(bridge, talk, delays, joint_states):
    """Ten thousand of them delay no message to another client, and publish nothing."""
    let_crowd(bridge, 1, 10_000, 0)
    talk().settle()
    assert delays[0] < 0.1
    assert joint_states == []


def test_a_frame_that_is_too_large_closes_its_own_connection(talk):
    """With the status for that."""
    client = talk()
    client.connection.send('x' * 100_001)
    with pytest.raises(ConnectionClosed) as closing:
        client.receive()
    assert closing.value.rcvd.code == 1009
    talk().settle()


@pytest.mark.parametrize(('headers', 'status', 'text'), [
    ({'Host': 'evil.example'}, 403, b'origins:=http://NAME'),
    ({'Origin': 'https://evil.example'}, 403,
     b'a page of https://evil.example may not use this bridge'),
    ({'Origin': 'null'}, 403, b'a page of null'),
    ({}, 426, b'this is rosbridge v2'),
])
def test_a_request_is_refused_before_anything_is_read(bridge, headers, status, text):
    """Foreign pages and foreign names, also of the websocket."""
    port = int(bridge.url.rpartition(':')[2])
    for upgrade in ({}, {'Upgrade': 'websocket', 'Connection': 'Upgrade',
                         'Sec-WebSocket-Version': '13', 'Sec-WebSocket-Key': 'A' * 22 + '=='}):
        if upgrade and status == 426:
            continue
        connection = http.client.HTTPConnection('127.0.0.1', port, timeout=10)
        connection.request('GET', '/', headers={**headers, **upgrade})
        answer = connection.getresponse()
        assert (answer.status, text in answer.read()) == (status, True)
        connection.close()


def test_handshakes_that_never_end_keep_nobody_out(bridge, talk):
    """Those that are too many are closed, the others after five seconds."""
    idle = half_open(bridge.url, 60)
    closed = sum(1 for connection in idle if _is_closed(connection))
    assert closed >= 20
    for connection in idle:
        connection.close()
    talk().settle()


def _is_closed(connection):
    connection.settimeout(1.0)
    try:
        return connection.recv(1) == b''
    except TimeoutError:
        return False
    except ConnectionResetError:
        return True


def test_many_connections_leave_nothing(bridge, talk, peer):
    """Memory, threads and endpoints are those of before."""
    def visit():
        client = talk()
        client.send('advertise', topic='/seen', type='sensor_msgs/JointState')
        client.send('subscribe', topic='/joint_states', type='sensor_msgs/JointState')
        client.settle()
        client.close()

    for _ in range(20):
        visit()
    before = used(bridge)
    for _ in range(100):
        visit()
    _, threads, files = before
    after = used(bridge)
    assert after[0] - before[0] < 5 << 20
    # Pools start their eight threads as they need them; each visit would leave one of its own.
    assert after[1] <= threads + 8
    assert after[2] <= files + 2
    wait_until_left(peer)


@pytest.mark.alone
def test_a_crowd_moves_nothing_and_leaves_nothing(
        ros_domain_id, bridge, talk, peer, joint_states):
    """200 clients with nonsense and pictures that nobody reads, and handshakes that never end."""
    def visit():
        let_crowd(bridge, 200, 4000, 60)
        wait_until_left(peer)

    with publishing(ros_domain_id, 'picture'):
        visit()  # the allocator keeps a part of what the first needed
        before = used(bridge)
        visit()
    talk().settle()
    deadline = time.monotonic() + 15.0
    while used(bridge)[0] - before[0] > 5 << 20:
        assert time.monotonic() < deadline, (before, used(bridge))
        threading.Event().wait(0.1)
    assert used(bridge)[1] <= before[1] + 6  # workers, each made when it is first needed
    assert joint_states == []


def used(bridge):
    """Return memory [bytes], threads and open files of a bridge."""
    process = Path(f'/proc/{bridge.process.pid}')
    pages = int((process / 'statm').read_text().split()[1])
    threads, files = (len(os.listdir(process / name)) for name in ('task', 'fd'))
    return pages * os.sysconf('SC_PAGE_SIZE'), threads, files


def wait_until_left(peer):
    """Wait until the bridge publishes for no client any more."""
    deadline = time.monotonic() + 10.0
    while any(info.node_name == 'rosbridge_websocket'
              for info in peer.get_publishers_info_by_topic('/seen')):
        assert time.monotonic() < deadline
        threading.Event().wait(0.05)
