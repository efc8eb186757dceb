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
import threading
import time
from typing import Any

from websockets.asyncio.client import connect

from armsim_ros.testing.program import private_domain, Program, ros_environment
from benchmarks.bridge.streams import STREAMS
from benchmarks.options import Options
from benchmarks.stack import (
    DOMAINS,
    median,
    peer,
    percentile,
    processor_seconds,
    resident_mib,
)
from benchmarks.tables import machine_load, publish, Table

#: What is not measured at the start of each phase [s].
_SETTLED = 2.0


def main(options: Options) -> None:
    """Print all tables."""
    with private_domain(DOMAINS) as domain, running_bridge(domain) as (bridge, url):
        rows: list[tuple[str, ...]] = [
            ('idle, nobody connected', percent(bridge, options.seconds), '', '', '')]
        for kind, compression, clients in (
                ('joints', 'none', 1), ('joints', 'none', 10), ('joints', 'cbor-raw', 1),
                ('joints', 'cbor', 1), ('joints', 'cbor', 10), ('picture', 'none', 1),
                ('picture', 'cbor', 1), ('fast', 'none', 10)):
            rows.append(stream_row(domain, bridge, url, options, kind, compression, clients))
        for raw in ([], ['raw']):
            with publishing(domain, 'joints'), peer(
                    'bridge.streams', 'subscribe', 'joints', *raw, domain=domain,
                    settled='ready') as bare:
                time.sleep(_SETTLED)
                rows.append((f'bare rclpy subscriber{" raw" if raw else ""}',
                             percent(bare, options.seconds), '', '', ''))
        publish(options.report, 'bridge', Table(
            'The bridge: processor time [% of a core], messages per second and client, delay '
            '(median, p99) [ms]', ('', '%', '1/s', 'lost', 'ms'), rows))
        publish(options.report, 'bridge calls', Table(
            'Commands and calls', ('', 'figure'), list(command_rows(domain, bridge, url))),
            f'Memory of the bridge at the end: {resident_mib(bridge.process.pid):.0f} MiB.',
            machine_load())


@contextmanager
def running_bridge(domain: int) -> Iterator[tuple[Program, str]]:
    """Start a bridge; yields its program and where it serves."""
    program = Program.module('armsim_ros', 'bridge', 'port:=0',
                             environment=ros_environment(domain))
    with program:
        line = program.wait_for_line('rosbridge: ws', 30.0)
        yield program, line.partition('rosbridge: ')[2].strip()


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


class Readers:
    """Clients of a topic in a thread of their own."""

    def __init__(self, url: str, topic: str, compression: str, clients: int) -> None:
        self.counts = [0] * clients
        self.delays: list[float] = []
        self.numbers: list[int] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._run(url, topic, compression)), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave."""
        self._stop.set()
        self._thread.join(10.0)

    async def _run(self, url: str, topic: str, compression: str) -> None:
        tasks = [asyncio.create_task(self._read(index, url, topic, compression))
                 for index in range(len(self.counts))]
        while not self._stop.is_set():
            await asyncio.sleep(0.1)
        for task in tasks:
            task.cancel()

    async def _read(self, index: int, url: str, topic: str, compression: str) -> None:
        async with connect(url, compression=None, max_size=None) as connection:
            await connection.send(json.dumps(
                {'op': 'subscribe', 'topic': topic, 'compression': compression}))
            while True:
                frame = await connection.recv()
                self.counts[index] += 1
                if index == 0 and isinstance(frame, str) and len(frame) < 10_000:
                    header = json.loads(frame)['msg']['header']
                    stamp = header['stamp']
                    self.numbers.append(int(header['frame_id']))
                    sent = stamp['sec'] * 10**9 + stamp['nanosec']
                    self.delays.append((time.time_ns() - sent) * 1e-6)


def stream_row(domain: int, bridge: Program, url: str, options: Options, kind: str,
               compression: str, clients: int) -> tuple[str, ...]:
    """Return the figures of a topic with so many clients."""
    topic, _, rate = STREAMS[kind]
    with ExitStack() as stack:
        stack.enter_context(publishing(domain, kind))
        readers = Readers(url, topic, compression, clients)
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
    return (f'{kind} at {rate:.0f} Hz, {compression}, {clients} client{"s"[:clients > 1]}', used,
            f'{min(rates):.1f}', lost, delay)


def command_rows(domain: int, bridge: Program, url: str) -> Iterator[tuple[str, str]]:
    """Yield what publishing, calls and a large message take."""
    yield from asyncio.run(_command_rows(bridge, url))


async def _command_rows(bridge: Program, url: str) -> list[tuple[str, str]]:
    async with connect(url, compression=None, max_size=None) as connection:
        async def call(service: str, **fields: Any) -> float:
            start = time.monotonic()
            await connection.send(json.dumps({'op': 'call_service', 'service': service, **fields}))
            await connection.recv()
            return (time.monotonic() - start) * 1e3

        times = [await call('/rosapi/get_time') for _ in range(500)]
        rows = [('/rosapi/get_time, median and p99 [ms]',
                 f'{median(times):.2f}, {percentile(times, 0.99):.2f}')]
        times = [await call('/rosbridge_websocket/list_parameters') for _ in range(100)]
        rows.append(('a service over the middleware, median [ms]', f'{median(times):.2f}'))
        await connection.send(json.dumps(
            {'op': 'advertise', 'topic': '/commands', 'type': 'geometry_msgs/Twist'}))
        await call('/rosapi/get_time')
        before, start = processor_seconds(bridge.process.pid), time.monotonic()
        count = 8000
        for _ in range(count):
            await connection.send(
                '{"op":"publish","topic":"/commands","msg":{"linear":{"x":0.1},"angular":{}}}')
        await call('/rosapi/get_time')
        elapsed, used = time.monotonic() - start, processor_seconds(bridge.process.pid) - before
        rows.append(('small publications taken [1/s]', f'{count / elapsed:.0f}'))
        rows.append(('processor time of each [ms]', f'{1e3 * used / count:.3f}'))
        return rows
