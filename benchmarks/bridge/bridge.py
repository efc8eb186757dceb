# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time of the bridge beside a bare subscriber, delays, and what passes without loss.

The clients read frames and drop them; they share a process of their own thread, so that what
they need is not the bridge's.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import json
import os
from pathlib import Path
import sys
import threading
import time

from websockets.asyncio.client import connect

from armsim_ros.testing.program import private_domain, Program, ros_environment
from benchmarks.bridge.streams import STREAMS
from benchmarks.options import Options
from benchmarks.stack import DOMAINS, median, peer, percentile, processor_seconds, resident_mib
from benchmarks.tables import machine_load, publish, Table

#: Folder with a checkout of rosbridge_suite, whose server is measured, too.
SUITE = 'ARMSIM_BENCH_ROSBRIDGE'
STREAM_ROWS = (
    ('joints', 'none', 1), ('joints', 'none', 10), ('joints', 'cbor-raw', 1),
    ('joints', 'cbor', 1), ('joints', 'cbor', 10), ('picture', 'none', 1),
    ('picture', 'cbor', 1), ('fast', 'none', 10))
#: A service of another process, and how many publications are sent.
_SERVICE, _COMMANDS = '/bench_publish/list_parameters', 8000
#: What is not measured at the start of each phase [s].
_SETTLED = 2.0
#: Until the bridge has returned memory after its last client [s].
_RETURNED = 4.0


def main(options: Options) -> None:
    """Print all tables."""
    suite = os.environ.get(SUITE, '')
    with private_domain(DOMAINS) as domain:
        with running_bridge(domain) as (bridge, url):
            streams = stream_rows(domain, bridge, url, options)
            calls = command_rows(domain, bridge, url, '/rosapi/get_time')
            calls |= cloud_rows(domain, url)
            time.sleep(_RETURNED)
            end = f'Memory of the bridge at the end: {resident_mib(bridge.process.pid):.0f} MiB.'
        peer_streams, peer_calls = {}, {}
        if suite:
            with running_suite(domain, Path(suite)) as (server, url):
                peer_streams = stream_rows(domain, server, url, options)
                peer_calls = command_rows(domain, server, url, '')
        bare = {f'bare rclpy subscriber, {words}': bare_row(domain, options, words)
                for words in ('joints', 'joints raw', 'picture raw')}
    publish(options.report, 'bridge', Table(
        'The bridge: processor time [% of a core], messages per second and client, delay '
        '(median, p99) [ms]; behind them the same of rosbridge_server',
        ('', '%', '1/s', 'lost', 'ms', '%', '1/s', 'lost', 'ms'),
        [(name, *row, *peer_streams.get(name, ('',) * 4))
         for name, row in {**streams, **bare}.items()]))
    publish(options.report, 'bridge calls', Table(
        'Commands and calls', ('', 'bridge', 'rosbridge_server'),
        [(name, figure, peer_calls.get(name, '')) for name, figure in calls.items()]), end,
        machine_load())


@contextmanager
def running_bridge(domain: int, *arguments: str) -> Iterator[tuple[Program, str]]:
    """Start a bridge; yields its program and where it serves."""
    program = Program.module('armsim_ros', 'bridge', 'port:=0', *arguments,
                             environment=ros_environment(domain))
    with program:
        line = program.wait_for_line('rosbridge: ws', 30.0)
        yield program, line.partition('rosbridge: ')[2].strip()


@contextmanager
def running_suite(domain: int, suite: Path) -> Iterator[tuple[Program, str]]:
    """
    Start the server of rosbridge_suite, without rosapi.

    :param suite: a checkout of it; tornado, pymongo and pillow are installed.
    """
    environment = ros_environment(domain)
    sources = [str(suite / package / 'src')
               for package in ('rosbridge_server', 'rosbridge_library')]
    environment['PYTHONPATH'] = os.pathsep.join(
        [*sources, os.environ.get('PYTHONPATH', '')]).rstrip(os.pathsep)
    script = suite / 'rosbridge_server/scripts/rosbridge_websocket.py'
    program = Program([sys.executable, str(script), '--port', '0', '--address', '127.0.0.1'],
                      environment=environment)
    with program:
        line = program.wait_for_line('server started on port', 30.0)
        yield program, f'ws://127.0.0.1:{line.rpartition(" ")[2].strip()}'


@contextmanager
def publishing(domain: int, kind: str) -> Iterator[None]:
    """Publish a stream from a process of its own."""
    with peer('bridge.streams', 'publish', kind, domain=domain, settled='ready'):
        yield


def percent(program: Program, seconds: float) -> str:
    """Return the share of a core that a program takes, watched for so long."""
    before, start = processor_seconds(program.process.pid), time.monotonic()
    time.sleep(seconds)
    used = processor_seconds(program.process.pid) - before
    return f'{100.0 * used / (time.monotonic() - start):.1f}'


Row = tuple[str, str, str, str]


class Readers:
    """
    Clients of a topic in a thread of their own.

    :param kind: of ``STREAMS``.
    """

    def __init__(self, url: str, kind: str, compression: str, clients: int) -> None:
        self.counts = [0] * clients
        self.arrivals: list[float] = []
        self.delays: list[float] = []
        self.numbers: list[int] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._run(url, _subscription(kind, compression))),
            daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave."""
        self._stop.set()
        self._thread.join(10.0)

    async def _run(self, url: str, subscription: str) -> None:
        tasks = [asyncio.create_task(self._read(index, url, subscription))
                 for index in range(len(self.counts))]
        while not self._stop.is_set():
            await asyncio.sleep(0.1)
        for task in tasks:
            task.cancel()

    async def _read(self, index: int, url: str, subscription: str) -> None:
        async with connect(url, compression=None, max_size=None) as connection:
            await connection.send(subscription)
            while True:
                frame = await connection.recv()
                self.counts[index] += 1
                self.arrivals.append(time.monotonic())
                if index == 0 and isinstance(frame, str) and len(frame) < 10_000:
                    header = json.loads(frame)['msg']['header']
                    stamp = header['stamp']
                    self.numbers.append(int(header['frame_id']))
                    sent = stamp['sec'] * 10**9 + stamp['nanosec']
                    self.delays.append((time.time_ns() - sent) * 1e-6)


def _subscription(kind: str, compression: str) -> str:
    topic, message_type, _ = STREAMS[kind]
    return json.dumps({'op': 'subscribe', 'topic': topic, 'compression': compression,
                       'type': f'sensor_msgs/msg/{message_type.__name__}'})


def stream_rows(domain: int, bridge: Program, url: str, options: Options) -> dict[str, Row]:
    """Return the figures of a server at rest and with each stream."""
    rows = {'idle, no client': (percent(bridge, options.seconds), '', '', '')}
    for kind, compression, clients in STREAM_ROWS:
        rate = STREAMS[kind][2]
        name = f'{kind} at {rate:.0f} Hz, {compression}, {clients} client{"s"[:clients > 1]}'
        rows[name] = stream_row(domain, bridge, url, options, kind, compression, clients)
    return rows


def bare_row(domain: int, options: Options, words: str) -> Row:
    """Return the processor time of a subscriber without a bridge."""
    with publishing(domain, words.split()[0]), peer(
            'bridge.streams', 'subscribe', *words.split(), domain=domain,
            settled='ready') as bare:
        time.sleep(_SETTLED)
        return percent(bare, options.seconds), '', '', ''


def stream_row(domain: int, bridge: Program, url: str, options: Options, kind: str,
               compression: str, clients: int) -> Row:
    """Return the figures of a topic with so many clients."""
    with ExitStack() as stack:
        stack.enter_context(publishing(domain, kind))
        readers = Readers(url, kind, compression, clients)
        stack.callback(readers.close)
        time.sleep(_SETTLED)
        before, start = list(readers.counts), time.monotonic()
        readers.delays.clear()
        readers.numbers.clear()
        used = percent(bridge, options.seconds)
        elapsed = time.monotonic() - start
        rates = [(count - first) / elapsed
                 for count, first in zip(readers.counts, before, strict=True)]
    delay = (f'{median(readers.delays):.1f}, {percentile(readers.delays, 0.99):.1f}'
             if readers.delays else '')
    numbers = list(readers.numbers)
    lost = str(numbers[-1] - numbers[0] + 1 - len(numbers)) if numbers else ''
    return used, f'{min(rates):.1f}', lost, delay


def cloud_rows(domain: int, url: str) -> dict[str, str]:
    """Return how long a large message takes, and how long it holds another client up."""
    with publishing(domain, 'joints'), publishing(domain, 'cloud'):
        readers = Readers(url, 'joints', 'none', 1)
        with peer('bridge.cloud', url, _subscription('cloud', 'none'), domain=domain) as cloud:
            seconds = float(cloud.wait_for_line('seconds', 120.0).split()[1])
        readers.close()
    return {'50 MB PointCloud2, from its publisher to the client, JSON [s]': f'{seconds:.2f}',
            'longest delay of a message at 50 Hz for another client meanwhile [ms]':
                f'{max(readers.delays):.0f}'}


def command_rows(domain: int, bridge: Program, url: str, local: str) -> dict[str, str]:
    """
    Return what publications and calls take.

    :param local: a service that the server answers itself, '' for none.
    """
    with publishing(domain, 'joints'):
        return asyncio.run(_command_rows(bridge, url, local))


async def _command_rows(bridge: Program, url: str, local: str) -> dict[str, str]:
    rows = {}
    async with connect(url, compression=None, max_size=None) as connection:
        async def call(service: str) -> float:
            start, answer = time.monotonic(), {'result': False}
            while not answer['result']:  # until the server has found the service
                await connection.send(json.dumps({'op': 'call_service', 'service': service,
                                                  'id': 'call'}))
                answer = json.loads(await connection.recv())
            return (time.monotonic() - start) * 1e3

        await call(_SERVICE)
        if local:
            times = [await call(local) for _ in range(500)]
            rows[f'{local}, median and p99 [ms]'] = (
                f'{median(times):.2f}, {percentile(times, 0.99):.2f}')
        times = [await call(_SERVICE) for _ in range(100)]
        rows['a service over the middleware, median [ms]'] = f'{median(times):.2f}'
        await connection.send(json.dumps(
            {'op': 'advertise', 'topic': '/commands', 'type': 'geometry_msgs/Twist'}))
        await call(_SERVICE)
        before, start = processor_seconds(bridge.process.pid), time.monotonic()
        for _ in range(_COMMANDS):
            await connection.send(
                '{"op":"publish","topic":"/commands","msg":{"linear":{"x":0.1},"angular":{}}}')
        await call(_SERVICE)
        elapsed, used = time.monotonic() - start, processor_seconds(bridge.process.pid) - before
        rows['small publications taken [1/s]'] = f'{_COMMANDS / elapsed:.0f}'
        rows['processor time of each [ms]'] = f'{1e3 * used / _COMMANDS:.3f}'
    return rows
