# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 doctor``."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterator, Sequence
from importlib import metadata
import os
from pathlib import Path
import platform
import shutil
import socket
import sys

from armsim_ros2.errors import CliError
from armsim_ros2.parsing import node_options, Parser
from armsim_ros2.session import Session

_GROUP = ('239.255.0.1', 47231)
_WHEELS = ('ros-jazzy-rclpy', 'ros-jazzy-rmw-fastrtps-cpp', 'armsim-ros', 'armsim-ros2',
           'armsim-ros-interfaces')
#: Least free shared memory with which Fast DDS works [B].
_SHARED_MEMORY = 16 << 20


def run(argv: Sequence[str]) -> int:
    """
    Print facts and problems.

    :returns: 1 if there is a problem.
    """
    parser = Parser(prog='ros2 doctor', description='check installation, middleware and graph')
    parser.add_argument('--report', '-r', action='store_true', help='for compatibility')
    node_options(parser)
    options = parser.parse_args(argv)
    for name, value in _facts():
        print(f'{name:20} {value}')
    problems = [*_machine_problems(), *_graph_problems(options)]
    for problem, cure in problems:
        print(f'\nproblem: {problem}\n   cure: {cure}')
    if not problems:
        print('\nNo problems found')
    return 1 if problems else 0


def _facts() -> Iterator[tuple[str, str]]:
    yield 'Python', f'{platform.python_version()} ({sys.executable})'
    for name in _WHEELS:
        try:
            yield name, metadata.version(name)
        except metadata.PackageNotFoundError:
            yield name, 'not installed'
    environment = os.environ
    yield 'middleware', environment.get('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp')
    yield 'domain', environment.get('ROS_DOMAIN_ID', '0')
    yield 'discovery range', environment.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    yield 'static peers', environment.get('ROS_STATIC_PEERS', 'none')
    for identifier, command in _programs():
        yield 'program', f'{command} (process {identifier})'


def _programs() -> Iterator[tuple[int, str]]:
    """Return the programs of armsim_ros that run: process and command line."""
    for file in Path('/proc').glob('[0-9]*/cmdline'):
        try:
            words = file.read_bytes().decode(errors='replace').rstrip('\0').split('\0')
        except OSError:
            continue
        if any(Path(word).name in ('armsim', 'armsim_ros') for word in words[:3]):
            yield int(file.parent.name), ' '.join(words[1:])[:120]


def _machine_problems() -> Iterator[tuple[str, str]]:
    if not _multicast_works():
        yield ('multicast on the loopback interface does not work: nodes do not find each other',
               'sudo ip link set lo multicast on, or set ROS_STATIC_PEERS=127.0.0.1')
    folder = Path('/dev/shm')
    if folder.is_dir() and shutil.disk_usage(folder).free < _SHARED_MEMORY:
        yield ('/dev/shm is almost full: messages are lost',
               'delete its fastrtps_* files while no node runs; docker run --shm-size=256m')
    domain = os.environ.get('ROS_DOMAIN_ID', '0')
    if not domain.isdecimal() or int(domain) > 232:
        yield f"ROS_DOMAIN_ID is '{domain}'", 'set it to a number from 0 to 101'


def _multicast_works() -> bool:
    """Return whether a datagram to a group arrives over the loopback interface."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        loopback = socket.inet_aton('127.0.0.1')
        try:
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            receiver.bind(_GROUP)
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                                socket.inet_aton(_GROUP[0]) + loopback)
            receiver.settimeout(0.5)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
            sender.sendto(b'ros2 doctor', _GROUP)
            return receiver.recv(64) == b'ros2 doctor'
        except OSError:
            return False


def _graph_problems(options: Namespace) -> Iterator[tuple[str, str]]:
    try:
        session = Session(options)
    except (CliError, ImportError) as error:
        yield f'rclpy does not start: {error}', "pip install 'armsim_ros[ros]'"
        return
    from rclpy.qos import qos_check_compatible, QoSCompatibility

    with session:
        session.settle()
        names = session.nodes()
        topics = session.names('topic')
        print(f'{"graph":20} {len(names)} nodes, {len(topics)} topics')
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield (f'{names.count(name)} nodes have the name {name}',
                   'stop one of them, or start it with --ros-args -r __node:=another_name')
        for topic in topics:
            for publisher in session.node.get_publishers_info_by_topic(topic):
                for subscription in session.node.get_subscriptions_info_by_topic(topic):
                    compatible, reason = qos_check_compatible(
                        publisher.qos_profile, subscription.qos_profile)
                    if compatible == QoSCompatibility.ERROR:
                        yield (f'{subscription.node_name} receives nothing of '
                               f'{publisher.node_name} on {topic}: {reason}',
                               "use a QoS profile that fits the publisher's")


