# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Start and end of the program: ports, tokens, arguments."""

import asyncio
import shutil
import signal
import socket
import ssl
import subprocess

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import String
from websockets.asyncio.client import connect as asyncio_connect
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.nodes.bringup.main import bridge_command
from armsim_ros.testing.program import start_program

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def arguments():
    """Ask for a token, and let nothing move."""
    return ['token:=secret', 'read_only:=true', 'max_clients:=4']


def test_a_client_needs_the_token(bridge, talk):
    """In the URL or as a bearer; a wrong one is refused."""
    assert bridge.url.endswith('/?token=secret')
    bare = bridge.url.partition('?')[0]
    for url in (bare, f'{bare}?token=wrong'):
        with pytest.raises(InvalidStatus) as refusal:
            talk(url)
        assert refusal.value.response.status_code == 401
        assert b'a token is needed' in refusal.value.response.body
    talk().settle()
    talk(bare, additional_headers={'Authorization': 'Bearer secret'}).settle()
    assert bridge.text.count('secret') == 1


def test_what_exceeds_the_number_of_clients_is_refused(talk):
    """As text, before a connection is made."""
    def more_than_there_may_be():
        for _ in range(5):
            talk().settle()

    with pytest.raises(InvalidStatus) as refusal:
        more_than_there_may_be()
    assert refusal.value.response.status_code == 503
    assert b'4 clients are connected (max_clients)' in refusal.value.response.body


def test_reading_only_refuses_what_moves(talk):
    """Each in the answer that the client waits for."""
    client = talk()
    client.settle()
    assert client.call('/switch')['values'] == '/switch: not allowed here: read_only'
    client.send('send_action_goal', action='/move', action_type='a/B')
    assert 'read_only' in client.until('action_result')['values']
    assert 'read_only' in client.ask_status('publish', topic='/a', msg={})


def test_a_taken_port_is_an_error_with_its_cure(ros_domain_id):
    """Status 2, and no other port in silence."""
    with socket.create_server(('127.0.0.1', 0)) as taken:
        port = taken.getsockname()[1]
        with start_program('bridge', ros_domain_id, f'port:={port}') as program:
            assert program.process.wait(20) == 2
            assert f'port {port} cannot be opened at 127.0.0.1' in program.text
            assert 'port:=0 takes any free port' in program.text


def test_another_address_needs_a_token(ros_domain_id):
    """It is made, and printed with the URL."""
    with start_program('bridge', ros_domain_id, 'port:=0', 'address:=0.0.0.0') as program:
        url = program.wait_for_line('rosbridge: ws', 30).partition('rosbridge: ')[2].strip()
        assert len(url.partition('/?token=')[2]) >= 32
        port = url.partition('/?')[0].rpartition(':')[2]
        with pytest.raises(InvalidStatus, match='401'):
            connect(f'ws://127.0.0.1:{port}')


@pytest.mark.skipif(shutil.which('openssl') is None, reason='needs the program openssl')
def test_a_certificate_makes_wss_and_the_path_is_free(ros_domain_id, tmp_path):
    """
    Another path has no websocket.

    The client has one thread: websockets.sync reads and writes a TLS connection in two, and loses
    one in a thousand.
    """
    files = [tmp_path / 'cert.pem', tmp_path / 'key.pem']
    subprocess.run(['openssl', 'req', '-x509', '-newkey', 'ec', '-pkeyopt',
                    'ec_paramgen_curve:prime256v1', '-nodes', '-days', '1', '-subj',
                    '/CN=localhost', '-out', files[0], '-keyout', files[1]], check=True,
                   capture_output=True)
    context = ssl.create_default_context(cafile=files[0])
    context.check_hostname = False
    with start_program('bridge', ros_domain_id, 'port:=0', 'url_path:=/ros',
                       f'certfile:={files[0]}', f'keyfile:={files[1]}') as program:
        url = program.wait_for_line('rosbridge: wss://127.0.0.1:', 30).partition(': ')[2].strip()
        assert url.endswith('/ros')

        async def visit():
            async with asyncio_connect(url, ssl=context) as connection:
                await connection.send('{}')
                assert 'op must be one of' in await connection.recv()
            with pytest.raises(InvalidStatus, match='404'):
                await asyncio_connect(url.removesuffix('/ros'), ssl=context)

        asyncio.run(visit())


def test_parameters_of_launch_files_count(ros_domain_id):
    """What changes nothing here is named once; SIGINT ends with status 0."""
    with start_program('bridge', ros_domain_id, '--ros-args', '-p', 'port:=0', '-p',
                       'use_compression:=true') as program:
        program.wait_for_line('not used here: use_compression', 30)
        program.wait_for_line('rosbridge: ws://127.0.0.1:', 30)
        program.process.send_signal(signal.SIGINT)
        assert program.process.wait(5) == 0


def test_only_meshes_of_the_robot_are_served(ros_domain_id, peer, tmp_path):
    """Of packages that a description names; no other file, and nothing outside."""
    from urllib.error import HTTPError
    from urllib.request import urlopen

    for name in ('arm', 'other'):
        folder = tmp_path / name
        (folder / 'meshes').mkdir(parents=True)
        (folder / 'package.xml').write_text(f'<package><name>{name}</name></package>')
        (folder / 'meshes/link.stl').write_text(name)
        (folder / 'secret.txt').write_text(name)
    (tmp_path / 'arm/meshes/far.stl').symlink_to('/etc/hostname')
    publisher = peer.create_publisher(String, '/robot_description', LATCHED)
    publisher.publish(String(data='<mesh filename="package://arm/meshes/link.stl"/>'))
    with start_program('bridge', ros_domain_id, 'port:=0', f'packages_path:={tmp_path}'
                       ) as program:
        url = program.wait_for_line('rosbridge: ws', 30).partition('rosbridge: ws')[2].strip()

        def get(path):
            try:
                return urlopen(f'http{url}/package/{path}').read()
            except HTTPError as error:
                return error.code

        assert get('arm/meshes/link.stl') == b'arm'
        for path in ('other/meshes/link.stl', 'arm/secret.txt', 'arm/meshes/../secret.txt',
                     'arm/meshes/far.stl', 'arm/meshes/none.stl',
                     'arm/%2e%2e/other/meshes/link.stl'):
            assert get(path) == 404, path


def test_bringup_starts_the_bridge_with_its_time_and_the_robots_packages():
    """ROS arguments of bringup reach it, too."""
    arguments = parse_arguments(['bridge:=true', '--ros-args', '-p', 'port:=9191'])
    words = bridge_command(arguments)['bridge']
    assert 'use_sim_time:=true' in words
    assert words[-4:] == ['--ros-args', '-p', 'port:=9191', '--']
    assert any(word.startswith('near:=') for word in words)


def test_a_client_that_has_gone_without_a_word_is_noticed(ros_domain_id):
    """It answers no ping, and is closed."""
    with start_program('bridge', ros_domain_id, 'port:=0', 'websocket_ping_interval:=0.5',
                       'websocket_ping_timeout:=0.5') as program:
        port = int(program.wait_for_line('rosbridge: ws', 30).rpartition(':')[2])
        with socket.create_connection(('127.0.0.1', port), timeout=10) as silent:
            silent.sendall(b'GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n'
                           b'Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n'
                           b'Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n')
            received = b''
            while part := silent.recv(1000):
                received += part
    assert b'101 Switching Protocols' in received
