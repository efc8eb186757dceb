# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Connections that come and go each second: what is left of them in the bridge."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
import time

from websockets.asyncio.client import connect

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain
from benchmarks.bridge.bridge import publishing, running_bridge
from benchmarks.options import Options
from benchmarks.stack import DOMAINS, resident_mib
from benchmarks.tables import machine_load, publish, Table

#: Connections before the first figure, and between two figures.
_WARM, _STEP = 30, 300
_ACTION = 'control_msgs/FollowJointTrajectory'
#: Until endpoints that have no client any more are gone [s].
_SETTLED = 3.0


def main(options: Options) -> None:
    """Print memory, threads and files of the bridge as the connections go on."""
    rows = []
    with private_domain(DOMAINS) as domain, running_bridge(domain) as (bridge, url), \
            publishing(domain, 'joints'), ClientNode(domain, 'benchmark') as client:
        process = bridge.process.pid

        def row(count: int) -> tuple[str, ...]:
            threads, files = (len(list(Path(f'/proc/{process}/{name}').iterdir()))
                              for name in ('task', 'fd'))
            node = client.node
            ends = (node.count_publishers('/commands') + node.count_services('/served')
                    + node.count_services('/done/_action/send_goal')
                    + node.count_subscribers('/joint_states'))
            return (str(count), f'{resident_mib(process):.1f}', str(threads), str(files),
                    str(ends))

        end = time.monotonic() + 60.0 * options.minutes
        count = 0
        while time.monotonic() < end:
            asyncio.run(_visit(url, leaves=count % 2 == 0))
            count += 1
            if count == _WARM or count % _STEP == 0:
                time.sleep(_SETTLED)
                rows.append(row(count))
                print(*rows[-1], flush=True)
            time.sleep(1.0)
        time.sleep(_SETTLED)
        rows.append(row(count))
    publish(options.report, 'bridge soak', Table(
        'Connections that came and went', ('connections', 'MiB', 'threads', 'files',
                                           'endpoints left'), rows), machine_load())


async def _visit(url: str, *, leaves: bool) -> None:
    """Use what a client may use, then leave, or vanish without a word."""
    async with connect(url, compression=None) as connection:
        for message in (
                {'op': 'subscribe', 'topic': '/joint_states'},
                {'op': 'advertise', 'topic': '/commands', 'type': 'geometry_msgs/Twist'},
                {'op': 'advertise_service', 'service': '/served', 'type': 'std_srvs/SetBool'},
                {'op': 'advertise_action', 'action': '/done', 'type': _ACTION},
                {'op': 'publish', 'topic': '/commands', 'msg': {}},
                {'op': 'call_service', 'service': '/rosapi/topics'}):
            await connection.send(json.dumps(message))
        for _ in range(20):
            await connection.recv()
        if not leaves:
            connection.transport.abort()
